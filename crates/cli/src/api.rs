//! The results of the command, for programs that embed it, such as the Python package.
//!
//! A [`LoadedScene`] returns numbers where the command writes files. Options have the same names as those of the
//! command, and the same errors.

mod accuracy;
mod equations;
mod modes;
mod options;
mod page;
mod run;
mod scene;
mod sensitivity;
mod steady;
mod sweep;

pub use crate::commands::sweep::THREADS;
pub use crate::error::{Error, Finding};
pub use crate::gpu::Processor;
pub use accuracy::{Accuracy, AccuracyOptions};
pub use equations::EquationsOfMotion;
pub use options::RunOptions;
pub use run::Run;
pub use scene::LoadedScene;
pub use sensitivity::{Derivatives, SensitivityOptions};
pub use steady::SteadyOptions;
pub use sweep::{Sweep, SweepOptions, Values};

use std::path::PathBuf;

use crate::progress;
use crate::scenes::engine;

/// Does some work that ends early when `check` returns true; `check` is called on this thread, every few milliseconds.
///
/// Work outside this function installs a signal handler, as the command does.
pub fn interruptible<T>(check: fn() -> bool, work: impl FnOnce() -> T) -> T {
    progress::interruptible(check, work)
}

/// Uses this file as the symbolic engine, the program `qrm-engine`, which derives scene files; only the first call has
/// an effect.
pub fn choose_engine(program: PathBuf) {
    engine::choose(program);
}
