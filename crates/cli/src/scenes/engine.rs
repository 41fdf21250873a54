//! The program `qrm-engine`, which derives scenes. A process derives one scene and ends, to release the lock of the
//! symbolic engine; only one process per machine can hold it.

use std::io::{BufRead, BufReader, Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant, SystemTime};

use qrm_build::engine::{BUILDING, Sources};
use qrm_core::{DERIVING, DerivedScene, WAITING};

use super::cache::{self, Entry};
use super::output_file::OutputFile;
use crate::error::Error;
use crate::progress::{Progress, interrupted, watch_interrupts};

/// The interval between two checks of the engine.
pub(crate) const POLL_INTERVAL: Duration = Duration::from_millis(1);
/// The time after which a derivation shows its progress.
const NOTICE_DELAY: Duration = Duration::from_secs(2);

/// The engine chosen by a program that embeds the command.
static EMBEDDED: OnceLock<PathBuf> = OnceLock::new();

/// Chooses a file as the engine of this program, unless one is chosen already.
pub(crate) fn choose(program: PathBuf) {
    let _ = EMBEDDED.set(program);
}

/// The path of the engine: the chosen one, or that of `QRM_ENGINE`; otherwise the one next to this program, the one
/// built in the clone that contains this program, or one on the `PATH`.
pub(crate) fn program() -> Option<PathBuf> {
    let chosen = EMBEDDED.get().cloned().filter(|program| program.is_file());
    if let Some(program) = chosen.or_else(qrm_build::engine::named) {
        return Some(program);
    }
    let own = std::env::current_exe().ok()?;
    let beside = own.parent()?.join(qrm_build::engine::file_name());
    let built = sources().map(|sources| sources.program());
    [Some(beside), built].into_iter().flatten().find(|program| program.is_file()).or_else(qrm_build::engine::on_path)
}

/// The sources of the engine in the clone that contains this program.
fn sources() -> Option<Sources> {
    Sources::around(&std::env::current_exe().ok()?)
}

/// Builds the engine if it is missing and its sources exist; a program that embeds the command chooses its own.
pub(crate) fn build_if_missing(said: impl FnOnce(&str)) -> Result<(), Error> {
    let Some(sources) = sources().filter(|_| program().is_none() && EMBEDDED.get().is_none()) else { return Ok(()) };
    watch_interrupts();
    said(BUILDING);
    let spinner = Progress::spinner();
    let keep_running = || {
        spinner.show("building the symbolic engine".to_owned());
        !interrupted()
    };
    sources.build(keep_running).map_err(Error::run)
}

/// Derives a scene and stores it in the cache.
pub(super) fn derive(path: &Path, source: &str) -> Result<DerivedScene, Error> {
    watch_interrupts();
    build_if_missing(|text| drop(writeln!(std::io::stderr(), "note: {text}")))?;
    let engine = Engine::start(path)?;
    if cache::folder().is_none() {
        let text =
            "there is no cache folder, so the derived scene is not kept: set QRM_CACHE to one that can be created";
        let _ = writeln!(std::io::stderr(), "note: {text}");
    }
    let mut derivation = engine.derive(source);
    let (begun, mut spinner) = (Instant::now(), None);
    loop {
        if let Some(derived) = derivation.result() {
            return derived;
        }
        if interrupted() {
            return Err(interruption());
        }
        thread::sleep(POLL_INTERVAL);
        if begun.elapsed() > NOTICE_DELAY {
            let spinner = spinner.get_or_insert_with(Progress::spinner);
            match derivation.is_waiting() {
                true => spinner.show(format!("{}: another derivation on this machine goes first", path.display())),
                false => spinner.show(format!("deriving {}", path.display())),
            }
        }
    }
}

/// The error if a scene must be derived and there is no engine.
fn missing(path: &Path) -> Error {
    let missing = match EMBEDDED.get() {
        Some(chosen) => format!("there is no symbolic engine {}", chosen.display()),
        None => "the symbolic engine `qrm-engine` is neither next to this program nor on the PATH".to_owned(),
    };
    let folder = match cache::folder() {
        Some(folder) => format!("bring the derived scene into {}", folder.display()),
        None => "set QRM_CACHE to a folder that can be created, and bring the derived scene into it".to_owned(),
    };
    Error::usage(format!("{} has not been derived yet, and {missing}", path.display())).help(format!(
        "install it from a clone of qrm by `cargo install --path crates/engine`, or set QRM_ENGINE to its path; or \
         {folder}"
    ))
}

/// An engine that waits for a scene. Dropping it ends the process.
pub(crate) struct Engine {
    child: Child,
    /// The time at which its program was built.
    built: Option<SystemTime>,
    output: OutputFile,
}

impl Engine {
    /// Starts the engine for a scene with this path.
    pub(crate) fn start(path: &Path) -> Result<Self, Error> {
        let program = program().ok_or_else(|| missing(path))?;
        qrm_build::engine::check(&program).map_err(Error::usage)?;
        let output = OutputFile::new().map_err(|e| {
            let error = format!("neither the cache nor the temporary folder can be written: {e}");
            Error::run(error).help("set QRM_CACHE or TMPDIR to a folder that can be written")
        })?;
        let child = Command::new(&program)
            .arg("derive")
            .arg(path)
            .arg(&output.path)
            .env("SYMBOLICA_HIDE_BANNER", "1")
            .stdin(Stdio::piped())
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .map_err(|e| Error::run(format!("{} cannot be started: {e}", program.display())))?;
        Ok(Self { child, built: cache::modified(&program), output })
    }

    /// Returns the engine if its process still waits and its program was not rebuilt since.
    pub(crate) fn usable(mut self) -> Option<Self> {
        (matches!(self.child.try_wait(), Ok(None)) && self.is_current()).then_some(self)
    }

    /// Whether its program is still the one that was started.
    fn is_current(&self) -> bool {
        program().and_then(|program| cache::modified(&program)) == self.built
    }

    /// Sends the scene to the engine.
    pub(crate) fn derive(mut self, source: &str) -> Derivation {
        if let Some(stdin) = &mut self.child.stdin {
            // If the engine ended early, its reason is in stderr. The pipe stays open, since the engine ends when it is
            // closed.
            let _ =
                stdin.write_all(source.as_bytes()).and_then(|()| stdin.write_all(&[0])).and_then(|()| stdin.flush());
        }
        // Read during the derivation: an engine whose pipe is full would block.
        let stderr = self.child.stderr.take();
        let is_waiting = Arc::new(AtomicBool::new(false));
        let own = Arc::clone(&is_waiting);
        let stderr = thread::spawn(move || stderr.map(|pipe| read_messages(pipe, &own)).unwrap_or_default());
        Derivation { engine: self, source: source.to_owned(), is_waiting, stderr: Some(stderr) }
    }
}

impl Drop for Engine {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// A derivation in progress. Dropping it cancels the derivation.
pub(crate) struct Derivation {
    engine: Engine,
    source: String,
    is_waiting: Arc<AtomicBool>,
    stderr: Option<JoinHandle<String>>,
}

impl Derivation {
    /// The derived scene, before its functions are verified against its formulae.
    pub(crate) fn unverified(&self) -> Option<DerivedScene> {
        self.read(&self.engine.output.unverified())
    }

    /// Whether the derivation waits for another derivation on this machine.
    pub(crate) fn is_waiting(&self) -> bool {
        self.is_waiting.load(Ordering::Relaxed)
    }

    /// The verified scene, then also in the cache, or the error of the engine; `None` while it works.
    pub(crate) fn result(&mut self) -> Option<Result<DerivedScene, Error>> {
        match self.engine.child.try_wait() {
            Ok(None) => None,
            Ok(Some(status)) if status.success() => Some(self.store()),
            Ok(Some(status)) => {
                let stderr = self.stderr.take().and_then(|stderr| stderr.join().ok());
                Some(Err(engine_error(&stderr.unwrap_or_default(), status)))
            }
            Err(e) => Some(Err(Error::run(format!("the state of the engine is unknown: {e}")))),
        }
    }

    /// Moves the verified scene to the cache and returns it.
    fn store(&self) -> Result<DerivedScene, Error> {
        let file = &self.engine.output.path;
        let derived = self.read(file).ok_or_else(|| Error::run("the engine has written no derived scene"))?;
        if self.engine.is_current() {
            Entry::new(&self.source).store(file);
            cache::prune();
        }
        Ok(derived)
    }

    /// Reads the derived scene from a file, if it matches the source.
    fn read(&self, file: &Path) -> Option<DerivedScene> {
        cache::read(file).filter(|derived| derived.description.source == self.source)
    }
}

/// Whether the user interrupted the engine: a terminal interrupts all programs in it.
fn is_interrupted(status: ExitStatus) -> bool {
    #[cfg(unix)]
    return std::os::unix::process::ExitStatusExt::signal(&status) == Some(2);
    #[cfg(not(unix))]
    return interrupted() && !status.success();
}

fn interruption() -> Error {
    Error::run("the derivation was interrupted")
}

/// Reads the messages of an engine, without the lines about waiting.
fn read_messages(pipe: impl Read, is_waiting: &AtomicBool) -> String {
    let mut text = String::new();
    for line in BufReader::new(pipe).split(b'\n').map_while(Result::ok) {
        match &*String::from_utf8_lossy(&line) {
            WAITING => is_waiting.store(true, Ordering::Relaxed),
            DERIVING => is_waiting.store(false, Ordering::Relaxed),
            line => text += &format!("{line}\n"),
        }
    }
    text
}

/// The error of an engine that failed.
fn engine_error(stderr: &str, status: ExitStatus) -> Error {
    if is_interrupted(status) {
        return interruption();
    }
    let text = stderr.trim();
    let text = text.strip_prefix("error: ").unwrap_or(text);
    Error::usage(if text.is_empty() { format!("the engine ended with {status}") } else { text.to_owned() })
}
