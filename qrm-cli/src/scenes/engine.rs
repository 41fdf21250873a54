//! The program that derives scenes. It lives no longer than a derivation takes: the symbolic engine allows one process
//! per machine.

use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use qrm_core::DerivedScene;

use super::cache::{self, Entry};
use crate::error::Error;
use crate::progress::{Spinner, interrupted, watch_interrupts};

/// How often it is looked whether the engine is done.
pub(crate) const PATIENCE: Duration = Duration::from_millis(1);
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
    watch_interrupts();
    let mut derivation = Engine::start(path)?.derive(source);
    let (begun, mut spinner) = (Instant::now(), None);
    loop {
        if let Some(derived) = derivation.result(entry) {
            return derived;
        }
        if interrupted() {
            return Err(Error::run("the derivation was interrupted"));
        }
        std::thread::sleep(PATIENCE);
        if begun.elapsed() > SILENCE {
            spinner.get_or_insert_with(Spinner::new).show(format!("deriving {}", path.display()));
        }
    }
}

/// An engine that waits for a scene. Dropped, it ends.
pub(crate) struct Engine {
    child: Child,
    /// What it writes.
    file: PathBuf,
}

impl Engine {
    /// Starts the engine for a scene of this path.
    pub(crate) fn start(path: &Path) -> Result<Self, Error> {
        static COUNTER: AtomicU64 = AtomicU64::new(0);
        let Some(program) = program() else {
            return Err(Error::usage(format!(
                "{} has not been derived yet, and the symbolic engine `qrm-engine` does not lie beside this program",
                path.display()
            ))
            .help(format!(
                "build it by `cargo build --release` in a clone of qrm, or install both by `cargo install --path .` \
                 there; or bring the derived scene into {}",
                cache::folder().display()
            )));
        };
        let number = COUNTER.fetch_add(1, Ordering::Relaxed);
        let file = cache::folder().join(format!("{}-{number}.under-way", std::process::id()));
        let child = Command::new(&program)
            .arg(path)
            .arg(&file)
            .stdin(Stdio::piped())
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .map_err(|e| Error::run(format!("{} cannot be started: {e}", program.display())))?;
        Ok(Self { child, file })
    }

    /// Gives the engine its scene.
    pub(crate) fn derive(mut self, source: &str) -> Derivation {
        if let Some(mut stdin) = self.child.stdin.take() {
            // An engine that does not listen says why.
            let _ = stdin.write_all(source.as_bytes());
        }
        // Read while it runs: an engine with much to say would wait for a reader.
        let stderr = self.child.stderr.take();
        let said = std::thread::spawn(move || stderr.and_then(|mut stderr| read_text(&mut stderr)).unwrap_or_default());
        Derivation { engine: self, said: Some(said) }
    }
}

impl Drop for Engine {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
        for file in [&self.file, &unverified(&self.file)] {
            let _ = std::fs::remove_file(file);
        }
    }
}

/// A derivation that is under way. Dropped, it is cancelled.
pub(crate) struct Derivation {
    engine: Engine,
    said: Option<JoinHandle<String>>,
}

impl Derivation {
    /// The scene once it is derived, before its functions were compared with its formulae.
    pub(crate) fn unverified(&self) -> Option<DerivedScene> {
        cache::read(&unverified(&self.engine.file))
    }

    /// The scene, or what is wrong with it, once that is known; a scene is kept in the cache.
    pub(crate) fn result(&mut self, entry: &Entry) -> Option<Result<DerivedScene, Error>> {
        let Engine { child, file } = &mut self.engine;
        match child.try_wait() {
            Ok(None) => None,
            Ok(Some(status)) if status.success() => Some(kept(file, entry)),
            Ok(Some(status)) => {
                let said = self.said.take().and_then(|said| said.join().ok());
                Some(Err(refusal(&said.unwrap_or_default(), status)))
            }
            Err(e) => Some(Err(Error::run(format!("the engine is lost: {e}")))),
        }
    }
}

/// Where the engine writes a scene before its functions are compared with its formulae.
fn unverified(file: &Path) -> PathBuf {
    file.with_extension("unverified")
}

/// The scene that the engine wrote, which is moved to the cache.
fn kept(file: &Path, entry: &Entry) -> Result<DerivedScene, Error> {
    let derived = cache::read(file);
    std::fs::rename(file, &entry.path).map_err(|e| Error::unwritable(&entry.path, &e))?;
    cache::prune();
    derived.ok_or_else(|| Error::run(format!("{} is not a derived scene", entry.path.display())))
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
