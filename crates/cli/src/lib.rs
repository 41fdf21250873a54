//! The command `qrm`: runs, checks, tables and pictures of the mechanisms compiled into a program.
//!
//! Each subcommand is a module of `commands` with its options and a function `run`, listed in the table there.

pub mod api;
mod columns;
mod commands;
mod error;
mod far_places;
mod format;
mod gpu;
mod keys;
mod live;
mod lsp;
mod memory;
mod messages;
mod methods;
mod options;
mod output;
mod packing;
mod parquet;
mod pictures;
mod plots;
mod progress;
mod recorder;
mod reference;
mod regular_forms;
mod resolution;
mod run_files;
mod run_report;
mod scenes;
mod setup;
mod table;
mod trajectory;

use std::ffi::OsString;
use std::io::Write;
use std::process::ExitCode;

use clap::Parser;
use qrm_core::Model;

use commands::Command;

/// Simulates mechanisms with closed loops from generated equations of motion.
///
/// Without a command, runs the scene `quick-return`.
#[derive(Parser)]
#[command(name = "qrm", version)]
struct CommandLine {
    #[command(subcommand)]
    command: Option<Command>,
}

/// Runs the command with the scenes of a program.
pub fn main(models: &'static [Model]) -> ExitCode {
    ExitCode::from(execute(models, std::env::args_os()))
}

/// Runs a command line, whose first word is the name of the program, and returns its exit status.
pub fn execute(models: &'static [Model], line: impl IntoIterator<Item = OsString>) -> u8 {
    let parsed = CommandLine::try_parse_from(line).and_then(|line| match line.command {
        Some(command) => Ok(command),
        None => CommandLine::try_parse_from(["qrm", "run"]).map(|line| line.command.expect("it was given")),
    });
    let command = match parsed {
        Ok(command) => command,
        Err(e) => {
            // Help and version arrive here too; standard output may be closed.
            let _ = e.print();
            return u8::try_from(e.exit_code()).unwrap_or(2);
        }
    };
    match command.run(models).and_then(|()| output::printed()) {
        Ok(()) => 0,
        Err(error) => {
            let _ = writeln!(std::io::stderr(), "{error}");
            error.status()
        }
    }
}
