//! The program `qrm-engine`, which derives the equations of motion of scenes.
//!
//! - `qrm-engine generate FOLDER SCENE...` writes the modules of scene files, in Rust, and their derivations.
//! - `qrm-engine derive SCENE FILE` derives the scene on its standard input, and writes it to a file as data. `SCENE`
//!   is the name for messages. The scene ends with a zero byte, after which the input stays open: when it is closed,
//!   the engine ends and leaves no file. A scene may also end with the input. `qrm` starts the engine for scenes that
//!   it was not built with, and ends it when the scene has changed meanwhile. The file with the extension `unverified`
//!   is written first, before the functions are verified against the formulae of the scene.
//! - `qrm-engine --version` prints the version, which must equal that of the calling program.
//!
//! Errors are printed to standard error; everything else on standard output can be ignored.

use std::io::{BufRead, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::thread;

use qrm_core::{DERIVING, DerivedScene, WAITING};
use qrm_engine::Waiting;
use qrm_engine::generate::generate;
use qrm_scene::files::write_atomic;

const USAGE: &str = "error: usage: qrm-engine generate FOLDER SCENE...\n\
                     \x20      qrm-engine derive SCENE FILE < SCENE\n\
                     \x20      qrm-engine --version";

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let result = match &arguments[..] {
        ["--version"] => {
            let _ = writeln!(std::io::stdout(), "qrm-engine {}", env!("CARGO_PKG_VERSION"));
            Ok(())
        }
        ["derive", scene, file] => derive(scene, Path::new(file)),
        ["generate", folder, scenes @ ..] if !scenes.is_empty() => {
            let scenes: Vec<PathBuf> = scenes.iter().map(PathBuf::from).collect();
            generate(&scenes, Path::new(folder)).map_err(|e| e.to_string())
        }
        _ => Err(USAGE.to_owned()),
    };
    result.map_or_else(|message| failure(&message), |()| ExitCode::SUCCESS)
}

fn failure(message: &str) -> ExitCode {
    let _ = writeln!(std::io::stderr(), "{message}");
    ExitCode::FAILURE
}

fn derive(scene: &str, file: &Path) -> Result<(), String> {
    let unverified = file.with_extension("unverified");
    let mut source = Vec::new();
    std::io::stdin().lock().read_until(0, &mut source).map_err(|e| format!("error: {scene}: {e}"))?;
    if source.pop_if(|last| *last == 0).is_some() {
        let files = [file.to_owned(), unverified.clone()];
        thread::spawn(move || end_with_input(&files));
    }
    let source = String::from_utf8(source).map_err(|e| format!("error: {scene}: {e}"))?;
    let failed = |e| format!("error: cannot write {}: {e}", file.display());
    let mut is_shown = Ok(());
    let show = |derived: &DerivedScene| is_shown = write_atomic(&unverified, &derived.to_bytes());
    let announce = |waiting| {
        let line = if waiting == Waiting::Begins { WAITING } else { DERIVING };
        let _ = writeln!(std::io::stderr(), "{line}");
    };
    let derived =
        qrm_engine::interpretable::derive(Path::new(scene), source, &announce, show).map_err(|e| e.to_string())?;
    is_shown.and_then(|()| write_atomic(file, &derived.to_bytes())).map_err(failed)
}

/// Ends the program and removes its files when the input is closed, since the calling program has ended.
fn end_with_input(files: &[PathBuf]) {
    let _ = std::io::stdin().lock().read_until(0, &mut Vec::new());
    for file in files {
        let _ = std::fs::remove_file(file);
    }
    std::process::exit(1);
}
