//! Differentiation. The only module that touches symbolica.
//!
//! Without a licence key the engine allows one thread of one process per machine and aborts a second one. So all
//! symbolic work happens on one thread of its own, and a machine-wide lock is held from before the first symbol is
//! defined until the process ends, because the engine holds its own claim as long.

mod algebra;
mod derive;
mod translate;

use std::fs::File;
use std::io;
use std::path::PathBuf;

use crate::scene::Scene;
use crate::term::Equations;

/// Derives the equations of motion of every scene. At most one call per process.
///
/// # Errors
/// The lock file cannot be made, or the thread cannot be started.
///
/// # Panics
/// If the engine panics.
pub fn derive(scenes: &[&Scene]) -> io::Result<Vec<Equations>> {
    let lock = lock()?;
    std::thread::scope(|scope| {
        let work = || scenes.iter().enumerate().map(|(i, scene)| derive::equations(i, scene)).collect();
        let thread =
            std::thread::Builder::new().name("symbolica".into()).stack_size(64 << 20).spawn_scoped(scope, work)?;
        let equations = thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic));
        // Released by the end of the process.
        std::mem::forget(lock);
        Ok(equations)
    })
}

/// Waits until no other process of this project uses the engine on this machine.
fn lock() -> io::Result<File> {
    let path = lock_path();
    // A lock made by another user can be opened for reading at least, and that is enough to lock it.
    let file = File::options().create(true).truncate(false).write(true).open(&path).or_else(|_| File::open(&path));
    let file = file.map_err(|e| io::Error::new(e.kind(), format!("cannot open the lock {}: {e}", path.display())))?;
    file.lock()?;
    Ok(file)
}

/// One path for the whole machine: temporary directories may differ between processes.
fn lock_path() -> PathBuf {
    let shared = PathBuf::from("/tmp");
    let directory = if shared.is_dir() { shared } else { std::env::temp_dir() };
    directory.join("qrm-symbolica.lock")
}
