//! The file that an engine writes.

use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

use tempfile::{Builder, TempDir};

use super::cache::{self, OUTPUT, UNVERIFIED};

/// The file that an engine writes: in the cache, or in a private folder if the cache cannot be written. Dropping it
/// removes the file.
pub(super) struct OutputFile {
    pub(super) path: PathBuf,
    /// Removed with its content when dropped.
    _private: Option<TempDir>,
}

impl OutputFile {
    /// Chooses a path that no other engine uses.
    pub(super) fn new() -> io::Result<Self> {
        static COUNTER: AtomicU64 = AtomicU64::new(0);
        let name = format!("qrm-{}-{}.{OUTPUT}", std::process::id(), COUNTER.fetch_add(1, Ordering::Relaxed));
        if let Some(path) = cache::folder().map(|folder| folder.join(&name)) {
            // A killed command may have had the same process id.
            remove(&path);
            if File::create_new(&path).is_ok() {
                remove(&path);
                return Ok(Self { path, _private: None });
            }
        }
        let folder = private_folder()?;
        Ok(Self { path: folder.path().join(&name), _private: Some(folder) })
    }

    /// The file of the scene before verification.
    pub(super) fn unverified(&self) -> PathBuf {
        unverified(&self.path)
    }
}

impl Drop for OutputFile {
    fn drop(&mut self) {
        remove(&self.path);
    }
}

/// Creates a folder that other users can neither read nor write.
fn private_folder() -> io::Result<TempDir> {
    let mut builder = Builder::new();
    builder.prefix("qrm-");
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o700));
    builder.tempdir()
}

fn unverified(path: &Path) -> PathBuf {
    path.with_extension(UNVERIFIED)
}

fn remove(path: &Path) {
    for file in [path, &unverified(path)] {
        let _ = fs::remove_file(file);
    }
}

#[cfg(test)]
#[cfg(unix)]
mod tests {
    use std::os::unix::fs::PermissionsExt;

    use super::*;

    #[test]
    fn a_private_folder_is_for_its_user_alone() {
        let folder = private_folder().expect("a folder");
        let mode = fs::metadata(folder.path()).expect("there").permissions().mode();
        assert_eq!(mode & 0o777, 0o700);
        let path = folder.path().to_owned();
        drop(folder);
        assert!(!path.exists());
    }
}
