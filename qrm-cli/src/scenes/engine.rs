//! The program that derives scenes. It lives no longer than a derivation takes: the symbolic engine allows one process
//! per machine.

use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use qrm_core::DerivedScene;

use super::cache::{self, Entry};
use crate::error::Error;
use crate::progress::{Spinner, interrupted, watch_interrupts};

/// How often it is looked whether the engine is done.
const PATIENCE: Duration = Duration::from_millis(1);
/// A derivation that takes longer shows that it goes on.
const SILENCE: Duration = Duration::from_secs(2);

/// The engine beside this program, if it was built with one.
pub(super) fn program() -> Option<PathBuf> {
    let own = std::env::current_exe().ok()?;
    let beside = |folder: &Path| folder.join(format!("qrm-engine{}", std::env::consts::EXE_SUFFIX));
    // Programs that cargo builds for examples and tests lie one folder deeper.
    let folders = own.ancestors().skip(1).take(2).map(beside);
    folders.into_iter().find(|program| program.is_file())
}

/// Derives a scene and keeps it in the cache.
pub(super) fn derive(path: &Path, source: &str, entry: &Entry) -> Result<DerivedScene, Error> {
    let Some(program) = program() else {
        return Err(Error::usage(format!(
            "{} has not been derived yet, and the symbolic engine `qrm-engine` does not lie beside this program",
            path.display()
        ))
        .help(format!(
            "build it by `cargo build --release` in a clone of qrm, or install both by `cargo install --path .` there; or \
             bring the derived scene into {}",
            cache::folder().display()
        )));
    };
    let failed = |e: std::io::Error| Error::run(format!("{} cannot be started: {e}", program.display()));
    watch_interrupts();
    let mut child = Command::new(&program)
        .arg(path)
        .arg(&entry.path)
        .stdin(Stdio::piped())
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .map_err(failed)?;
    if let Some(mut stdin) = child.stdin.take() {
        // An engine that does not listen says why.
        let _ = stdin.write_all(source.as_bytes());
    }
    // Read while it runs: an engine with much to say would wait for a reader.
    let stderr = child.stderr.take();
    let said = std::thread::spawn(move || stderr.and_then(|mut stderr| read_text(&mut stderr)).unwrap_or_default());
    let status = wait(&mut child, path)?;
    if !status.success() {
        return Err(refusal(&said.join().unwrap_or_default(), status));
    }
    cache::read(&entry.path).ok_or_else(|| Error::run(format!("{} is not a derived scene", entry.path.display())))
}

/// Waits for the engine.
fn wait(child: &mut Child, path: &Path) -> Result<ExitStatus, Error> {
    let (begun, mut spinner) = (Instant::now(), None);
    loop {
        match child.try_wait() {
            Ok(Some(status)) => return Ok(status),
            Ok(None) if interrupted() => {
                let _ = child.kill();
                let _ = child.wait();
                return Err(Error::run("the derivation was interrupted"));
            }
            Ok(None) => std::thread::sleep(PATIENCE),
            Err(e) => return Err(Error::run(format!("the engine is lost: {e}"))),
        }
        if begun.elapsed() > SILENCE {
            spinner.get_or_insert_with(Spinner::new).show(format!("deriving {}", path.display()));
        }
    }
}

/// All that is written to a pipe.
fn read_text(pipe: &mut impl Read) -> Option<String> {
    let mut bytes = Vec::new();
    pipe.read_to_end(&mut bytes).ok()?;
    Some(String::from_utf8_lossy(&bytes).into_owned())
}

/// What the engine said as an error.
fn refusal(said: &str, status: ExitStatus) -> Error {
    let said = said.trim();
    let said = said.strip_prefix("error: ").unwrap_or(said);
    Error::usage(if said.is_empty() { format!("the engine ended with {status}") } else { said.to_owned() })
}
