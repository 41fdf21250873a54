//! The results of the command, for programs that embed it, such as the Python package.
//!
//! A [`LoadedScene`] gives numbers where the command writes files. Options are those of the command, under the same
//! names and with the same errors.

mod accuracy;
mod equations;
mod options;
mod page;
mod run;
mod scene;
mod sensitivity;
mod sweep;

pub use crate::commands::sweep::THREADS;
pub use crate::error::{Error, Finding};
pub use accuracy::{Accuracy, AccuracyOptions};
pub use equations::EquationsOfMotion;
pub use options::RunOptions;
pub use run::Run;
pub use scene::LoadedScene;
pub use sensitivity::{Derivatives, SensitivityOptions};
pub use sweep::{Sweep, SweepOptions, Values};

use std::path::PathBuf;

use crate::progress;
use crate::scenes::engine;

/// Does some work that ends early when `check` returns true; `check` is called on this thread, every few milliseconds.
///
/// Work that is not under this function installs a handler of signals, as the command does.
pub fn interruptible<T>(check: fn() -> bool, work: impl FnOnce() -> T) -> T {
    progress::interruptible(check, work)
}

/// Makes a file the symbolic engine, the program `qrm-engine`, that derives scene files; the first call decides.
pub fn choose_engine(program: PathBuf) {
    engine::choose(program);
}
