//! Symbolic differentiation. Only this crate uses symbolica.
//!
//! Without a licence key the engine allows one thread of one process per machine and aborts a second one. Therefore all
//! symbolic work happens on a single thread. A machine-wide lock is held from before the first symbol is defined until
//! the process ends, as long as the engine holds its own claim.

mod algebra;
mod derive;
mod differentiate;
mod entry;
mod functions;
pub mod generate;
pub mod interpretable;
mod kernel;
mod linearization;
mod loads;
mod normal_forces;
mod number;
mod rows;
mod simplify;
mod sparse;
mod spline_names;
mod splines;
mod switch;
mod system;
mod translate;
mod virtual_work;

use std::fs::{File, TryLockError};
use std::io;
use std::path::PathBuf;
use std::sync::Mutex;

use normal_forces::Circular;
use qrm_codegen::term::Equations;
use qrm_scene::diagnostic::Span;
use qrm_scene::scene::Scene;

/// The reason why scenes could not be differentiated.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The lock file cannot be created, or the thread cannot be started.
    #[error("the symbolic engine could not be started: {0}")]
    NotStarted(#[from] io::Error),
    /// A normal force of friction depends on that friction.
    #[error("the normal force `{output}` contains the friction that depends on it")]
    Circular {
        /// The number of the scene.
        scene: usize,
        /// The location of the load.
        span: Span,
        /// The output that is the normal force.
        output: String,
    },
    /// The engine failed at a formula, or returned an unsupported result.
    #[error("{reason}")]
    Formula {
        /// The index of its scene.
        scene: usize,
        /// The location of the formula in the scene.
        span: Span,
        /// The message.
        reason: String,
    },
}

/// Derives the equations of motion of every scene. Call it at most once per process.
///
/// `announce` is called when waiting for another process begins and ends.
///
/// # Errors
/// The engine could not be started, or cannot differentiate a formula.
pub fn derive(scenes: &[&Scene], announce: &dyn Fn(Waiting)) -> Result<Vec<Equations>, Error> {
    let lock = lock(announce)?;
    let place = Mutex::new((0, 0..0));
    let quiet = std::panic::take_hook();
    // A panic of the engine becomes an error with a location.
    std::panic::set_hook(Box::new(|_| ()));
    let joined = std::thread::scope(|scope| {
        let place = &place;
        let work = move || {
            algebra::define_symbols(scenes);
            scenes.iter().enumerate().map(|(i, scene)| derive::equations(i, scene, place)).collect()
        };
        let thread =
            std::thread::Builder::new().name("symbolica".into()).stack_size(64 << 20).spawn_scoped(scope, work)?;
        Ok(thread.join())
    });
    std::panic::set_hook(quiet);
    // The lock is released when the process ends.
    std::mem::forget(lock);
    joined.map_err(Error::NotStarted)?.map_err(|panic| {
        let (scene, span) = place.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner);
        if let Some(Circular(output)) = panic.downcast_ref::<Circular>() {
            let own = scenes[scene].loads.iter().find(|load| load.kind.normal() == Some(*output));
            let span = own.map_or(0..0, |load| load.kind.forces().last().map_or(0..0, |size| size.whole_span()));
            return Error::Circular { scene, span, output: scenes[scene].outputs[*output].name.clone() };
        }
        let said = panic.downcast_ref::<String>().cloned();
        let reason = said.or_else(|| panic.downcast_ref::<&str>().map(|s| (*s).to_owned()));
        Error::Formula { scene, span, reason: reason.unwrap_or_else(|| "the engine gave up".to_owned()) }
    })
}

/// The scene and the location of the formula in progress.
type Place = Mutex<(usize, Span)>;

/// The begin or the end of waiting for another process.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Waiting {
    /// Another process uses the engine.
    Begins,
    /// The engine is free.
    Ends,
}

/// Waits until no other process of this project uses the engine on this machine.
fn lock(announce: &dyn Fn(Waiting)) -> io::Result<File> {
    let path = lock_path();
    // A lock file of another user can at least be opened for reading, which suffices for locking it.
    let file = File::options().create(true).truncate(false).write(true).open(&path).or_else(|_| File::open(&path));
    let file = file.map_err(|e| io::Error::new(e.kind(), format!("cannot open the lock {}: {e}", path.display())))?;
    match file.try_lock() {
        Ok(()) => {}
        Err(TryLockError::WouldBlock) => {
            announce(Waiting::Begins);
            file.lock()?;
            announce(Waiting::Ends);
        }
        Err(TryLockError::Error(e)) => return Err(e),
    }
    Ok(file)
}

/// A single path for the whole machine: temporary directories may differ between processes.
fn lock_path() -> PathBuf {
    let shared = PathBuf::from("/tmp");
    let directory = if shared.is_dir() { shared } else { std::env::temp_dir() };
    directory.join("qrm-symbolica.lock")
}
