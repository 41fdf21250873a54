//! The program `qrm-engine SCENE FILE`: derives the scene on its standard input, and writes it to a file as data.
//!
//! `SCENE` is the name for messages. `qrm` starts it for scenes that it was not built with, and ends it when the scene has
//! changed meanwhile. The file with the extension `unverified` is written first, before the functions are compared with
//! the formulae of the scene. What the engine prints on the standard output is of no use.

use std::io::{Read, Write};
use std::path::Path;
use std::process::ExitCode;

use qrm_core::DerivedScene;
use qrm_scene::files::write_whole;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().collect();
    let [_, scene, file] = &arguments[..] else { return failure("error: usage: qrm-engine SCENE FILE < SCENE") };
    derive(scene, Path::new(file)).map_or_else(|message| failure(&message), |()| ExitCode::SUCCESS)
}

fn failure(message: &str) -> ExitCode {
    let _ = writeln!(std::io::stderr(), "{message}");
    ExitCode::FAILURE
}

fn derive(scene: &str, file: &Path) -> Result<(), String> {
    let mut source = String::new();
    std::io::stdin().read_to_string(&mut source).map_err(|e| format!("error: {scene}: {e}"))?;
    let failed = |e| format!("error: cannot write {}: {e}", file.display());
    let mut is_shown = Ok(());
    let show = |derived: &DerivedScene| is_shown = write_whole(&file.with_extension("unverified"), &derived.to_bytes());
    let derived = qrm_codegen::interpretable::derive(scene, &source, show).map_err(|e| e.to_string())?;
    is_shown.and_then(|()| write_whole(file, &derived.to_bytes())).map_err(failed)
}
