//! Finds and builds the program `qrm-engine`.

use std::env;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};
use std::{io, thread};

/// The version of the engine that belongs to this crate.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");
/// The message that the engine is being built.
pub const BUILDING: &str = "building the symbolic engine; this takes minutes, once";
/// The interval between two checks of its build.
const POLL_INTERVAL: Duration = Duration::from_millis(50);

/// The source of the engine.
enum Origin {
    /// A program of the matching version.
    Program(PathBuf),
    /// The sources in a clone of the project, from which cargo builds it.
    Sources(Sources),
}

/// The sources of the engine in a clone.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Sources {
    /// The root folder of the clone.
    clone: PathBuf,
}

impl Sources {
    /// Finds the sources in the clone that contains a file or folder.
    pub fn around(path: &Path) -> Option<Self> {
        let is_clone = |folder: &&Path| {
            ["crates/engine/Cargo.toml", "crates/build/Cargo.toml"]
                .iter()
                .all(|manifest| folder.join(manifest).is_file())
        };
        path.ancestors().find(is_clone).map(|clone| Self { clone: clone.to_owned() })
    }

    /// The target folder of cargo.
    fn target(&self) -> PathBuf {
        env::var_os("CARGO_TARGET_DIR").map_or_else(|| self.clone.join("target"), PathBuf::from).join("engine")
    }

    /// The program built by cargo.
    pub fn program(&self) -> PathBuf {
        self.target().join("release").join(file_name())
    }

    /// Builds the program; ends early if `keep_running` returns false.
    ///
    /// # Errors
    /// There is no cargo, the build failed, or it was interrupted.
    pub fn build(&self, mut keep_running: impl FnMut() -> bool) -> Result<(), String> {
        let mut cargo = self.start()?;
        let stderr = cargo.stderr.take();
        // Read during the build: a program whose pipe is full would block.
        let said = thread::spawn(move || stderr.and_then(|pipe| io::read_to_string(pipe).ok()).unwrap_or_default());
        let status = loop {
            if let Some(status) = cargo.try_wait().map_err(|e| format!("cargo: {e}"))? {
                break status;
            }
            if !keep_running() {
                let _ = cargo.kill();
                let _ = cargo.wait();
                return Err(
                    "the build of the symbolic engine was interrupted; the next one continues from there".to_owned()
                );
            }
            thread::sleep(POLL_INTERVAL);
        };
        let said = said.join().unwrap_or_default();
        if status.success() { Ok(()) } else { Err(self.failure(&said, status)) }
    }

    /// Starts cargo.
    fn start(&self) -> Result<Child, String> {
        let cargo = env::var_os("CARGO").unwrap_or_else(|| OsString::from("cargo"));
        let mut command = Command::new(&cargo);
        command.args(["build", "--release", "--locked", "--bin", "qrm-engine", "--color", "never", "--manifest-path"]);
        command.arg(self.clone.join("crates/engine/Cargo.toml")).arg("--target-dir").arg(self.target());
        // An outer cargo or clippy sets these variables for its own compilers.
        for variable in ["CARGO_ENCODED_RUSTFLAGS", "CARGO_BUILD_TARGET", "RUSTC_WORKSPACE_WRAPPER", "CARGO_MAKEFLAGS"]
        {
            command.env_remove(variable);
        }
        command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::piped());
        command.spawn().map_err(|e| {
            format!(
                "the symbolic engine could not be built: {} cannot be started: {e}\n  \
                 = help: install Rust, or set QRM_ENGINE to a program `qrm-engine` {VERSION}",
                Path::new(&cargo).display()
            )
        })
    }

    /// The error of a failed build, from the output of cargo and its exit status.
    fn failure(&self, said: &str, status: ExitStatus) -> String {
        let noise = ["Compiling ", "Downloaded ", "Downloading ", "Updating ", "warning: spurious network error"];
        let is_noise = |line: &&str| noise.iter().any(|noise| line.contains(noise));
        let lines: Vec<&str> = said.lines().filter(|line| !line.trim().is_empty() && !is_noise(line)).collect();
        let last = match lines.len() {
            0 => format!("cargo ended with {status}"),
            count => lines[count.saturating_sub(12)..].join("\n  "),
        };
        format!(
            "the symbolic engine could not be built:\n  {last}\n  = help: run `cargo build --release --locked \
             --manifest-path {} --target-dir {}` to see all of it, or set QRM_ENGINE to a program `qrm-engine` \
             {VERSION}",
            self.clone.join("crates/engine/Cargo.toml").display(),
            self.target().display()
        )
    }
}

/// The name of the program.
pub fn file_name() -> String {
    format!("qrm-engine{}", env::consts::EXE_SUFFIX)
}

/// The program named by `QRM_ENGINE`, of any version.
pub fn named() -> Option<PathBuf> {
    env::var_os("QRM_ENGINE").filter(|path| !path.is_empty()).map(PathBuf::from)
}

/// The engine in a folder of `PATH`, of any version.
pub fn on_path() -> Option<PathBuf> {
    let folders = env::var_os("PATH")?;
    env::split_paths(&folders).map(|folder| folder.join(file_name())).find(|program| program.is_file())
}

/// Checks that a program is the engine of this version.
///
/// # Errors
/// The program cannot be started, or is another program or version.
pub fn check(program: &Path) -> Result<(), String> {
    let name = program.display();
    let help = format!(
        "  = help: QRM_ENGINE, if it is set, is the path of `qrm-engine` {VERSION}; `cargo install --path \
         crates/engine` in a clone installs it"
    );
    let output = Command::new(program).arg("--version").stdin(Stdio::null()).output();
    let output = output.map_err(|e| format!("the symbolic engine {name} cannot be started: {e}\n{help}"))?;
    let said = String::from_utf8_lossy(&output.stdout);
    if output.status.success() && said.trim() == format!("qrm-engine {VERSION}") {
        return Ok(());
    }
    let said =
        said.trim().strip_prefix("qrm-engine ").map_or("of an unknown version".to_owned(), |v| format!("version {v}"));
    Err(format!("the symbolic engine {name} is {said}, and this is {VERSION}\n{help}"))
}

/// The engine for a build script: the one named by `QRM_ENGINE`, that of the clone that contains this crate or the
/// user's crate, or one on the `PATH`.
fn origin() -> Result<Origin, String> {
    if let Some(program) = named() {
        return check(&program).map(|()| Origin::Program(program));
    }
    let users = env::var_os("CARGO_MANIFEST_DIR").map(PathBuf::from).unwrap_or_default();
    let sources = [Path::new(env!("CARGO_MANIFEST_DIR")), &users].into_iter().find_map(Sources::around);
    if let Some(sources) = sources {
        return Ok(Origin::Sources(sources));
    }
    let program = on_path().ok_or_else(|| {
        format!(
            "formulae have changed, and there is no symbolic engine `qrm-engine` {VERSION} on the PATH\n  \
             = help: install it from a clone of qrm (`cargo install --path crates/engine`), or set QRM_ENGINE to its path"
        )
    })?;
    check(&program).map(|()| Origin::Program(program))
}

/// Runs the engine, which writes the modules of scene files into a folder; builds it if it is missing or outdated.
/// Returns messages for the user.
pub(crate) fn generate(scenes: &[&Path], out: &Path) -> Result<Vec<String>, String> {
    println!("cargo::rerun-if-env-changed=QRM_ENGINE");
    let (program, note) = match origin()? {
        Origin::Program(program) => {
            println!("cargo::rerun-if-changed={}", program.display());
            (program, None)
        }
        Origin::Sources(sources) => {
            for folder in ["crates/engine", "codegen/src", "crates/scene/src", "crates/core/src"] {
                println!("cargo::rerun-if-changed={}", sources.clone.join(folder).display());
            }
            let note = build(&sources)?;
            (sources.program(), note)
        }
    };
    let mut command = Command::new(&program);
    let output = command.arg("generate").arg(out).args(scenes).stdin(Stdio::null()).output();
    let output = output.map_err(|e| format!("{} cannot be started: {e}", program.display()))?;
    match output.status.success() {
        true => Ok(note.into_iter().collect()),
        false => {
            let said = String::from_utf8_lossy(&output.stderr).trim().to_owned();
            let silent = || format!("the symbolic engine {} ended with {}", program.display(), output.status);
            Err(if said.is_empty() { silent() } else { said })
        }
    }
}

/// Builds the engine; returns a message if that took long.
fn build(sources: &Sources) -> Result<Option<String>, String> {
    let begun = Instant::now();
    let is_new = !sources.program().is_file();
    if is_new {
        announce(BUILDING);
    }
    sources.build(|| true)?;
    // Cargo may consider an old file current because of its time stamp.
    if check(&sources.program()).is_err() {
        let failed = |e| format!("the symbolic engine {} cannot be replaced: {e}", sources.program().display());
        std::fs::remove_file(sources.program()).map_err(failed)?;
        sources.build(|| true)?;
        check(&sources.program())?;
    }
    let note = format!(
        "the symbolic engine was built in {} s; it lies in {}",
        begun.elapsed().as_secs(),
        sources.program().display()
    );
    Ok(is_new.then_some(note))
}

/// Prints a message on the terminal immediately: cargo shows the output of a build script only after the script has
/// ended.
#[cfg(unix)]
fn announce(message: &str) {
    if let Ok(mut terminal) = std::fs::File::options().write(true).open("/dev/tty") {
        let _ = std::io::Write::write_fmt(&mut terminal, format_args!("{message}\n"));
    }
}

/// Other systems have no such terminal.
#[cfg(not(unix))]
fn announce(_message: &str) {}
