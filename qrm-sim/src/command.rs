//! The command `qrm`.

mod account;
#[cfg(feature = "pictures")]
mod accuracy;
#[cfg(feature = "pictures")]
mod animate;
mod arguments;
mod check;
mod code;
mod condition;
mod derive;
mod digest;
mod explain;
#[cfg(feature = "fmu")]
mod export_fmu;
mod late;
mod list;
#[cfg(feature = "sweep")]
mod parquet;
mod progress;
mod recorder;
#[cfg(feature = "pictures")]
mod reference;
#[cfg(feature = "pictures")]
mod report;
mod run;
#[cfg(feature = "sensitivity")]
mod sensitivity;
mod settings;
mod setup;
#[cfg(feature = "stability")]
mod stability;
#[cfg(feature = "sweep")]
mod sweep;
mod units;
mod words;

use std::ffi::OsString;
use std::io::Write;
use std::path::Path;
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering};

use clap::Parser;

use crate::scenes::Scenes;
use crate::whole::write_whole;
use arguments::{Arguments, RunArguments, Task};

/// How a command ended without reaching its goal.
enum Failure {
    /// The run itself failed; its files tell how far it got. Exit status 1.
    Run(String),
    /// The command or the scene is wrong. Exit status 2.
    Use(String),
}

/// Runs the command with the scenes it was built with.
pub fn main(scenes: &Scenes) -> ExitCode {
    ExitCode::from(execute(scenes, std::env::args_os()))
}

/// Runs a command line, the first word of which is the name of the program, and gives its exit status.
pub fn execute(scenes: &Scenes, line: impl IntoIterator<Item = OsString>) -> u8 {
    let arguments = match Arguments::try_parse_from(line) {
        Ok(arguments) => arguments,
        Err(e) => {
            // Help and version are asked for in this way too; nobody may be listening.
            let _ = e.print();
            return u8::try_from(e.exit_code()).unwrap_or(2);
        }
    };
    let default = || Task::Run(Box::new(RunArguments::parse_from(["qrm"])));
    let result = match arguments.command.unwrap_or_else(default) {
        Task::Run(arguments) => run::run(scenes, &arguments),
        #[cfg(feature = "pictures")]
        Task::Animate(arguments) => animate::animate(scenes, &arguments),
        #[cfg(feature = "pictures")]
        Task::Report(arguments) => report::report(scenes, &arguments),
        #[cfg(feature = "pictures")]
        Task::Accuracy(arguments) => accuracy::accuracy(scenes, &arguments),
        #[cfg(feature = "stability")]
        Task::Stability(arguments) => stability::stability(scenes, &arguments),
        #[cfg(feature = "sensitivity")]
        Task::Sensitivity(arguments) => sensitivity::sensitivity(scenes, &arguments),
        #[cfg(feature = "sweep")]
        Task::Sweep(arguments) => sweep::sweep(scenes, &arguments),
        #[cfg(feature = "sweep")]
        Task::Merge(arguments) => sweep::merge(&arguments),
        Task::Check(arguments) => check::check(scenes, &arguments),
        #[cfg(feature = "fmu")]
        Task::ExportFmu(arguments) => export_fmu::export_fmu(scenes, &arguments),
        Task::Explain(arguments) => explain::explain(scenes, &arguments),
        Task::Code(arguments) => code::code(scenes, &arguments),
        Task::Derive(arguments) => derive::derive(scenes, &arguments),
        Task::List => {
            say(&list::list(scenes));
            Ok(())
        }
    };
    let (message, status) = match result {
        Ok(()) if UNSAID.load(Ordering::Relaxed) => ("error: cannot write to the standard output".to_owned(), 1),
        Ok(()) => return 0,
        Err(Failure::Run(message)) => (message, 1),
        Err(Failure::Use(message)) => (message, 2),
    };
    let _ = writeln!(std::io::stderr(), "{message}");
    status
}

/// Writes a file of a command, in a folder that is made if it is not there.
fn write(path: &Path, bytes: &[u8]) -> std::io::Result<()> {
    path.parent().map_or(Ok(()), std::fs::create_dir_all)?;
    write_whole(path, bytes)
}

/// The bytes of a table in CSV.
#[cfg(feature = "pictures")]
fn table_of(writer: csv::Writer<Vec<u8>>) -> Result<Vec<u8>, csv::Error> {
    writer.into_inner().map_err(|e| csv::Error::from(e.into_error()))
}

/// The same for a command whose purpose is the file.
fn save(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    write(path, bytes).map_err(|e| Failure::Use(unwritable(path, &e)))
}

/// What is said when a file cannot be written.
fn unwritable(path: &Path, e: &std::io::Error) -> String {
    format!("error: cannot write {}: {e}\n  = help: choose another folder with --out DIR", path.display())
}

/// Prints to standard output, to which nobody may be listening any more.
fn say(text: &str) {
    let mut out = std::io::stdout();
    if let Err(e) = writeln!(out, "{text}").and_then(|()| out.flush())
        && e.kind() != std::io::ErrorKind::BrokenPipe
    {
        UNSAID.store(true, Ordering::Relaxed);
    }
}

/// Set when something could not be printed.
static UNSAID: AtomicBool = AtomicBool::new(false);
