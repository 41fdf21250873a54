//! Derived scenes in the user's cache folder, by a hash of their sources.

use std::fs::File;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

use etcetera::BaseStrategy;
use qrm_core::{DerivedScene, digest};
use qrm_scene::files::read_at_most;

/// The size of the largest file that is read.
const MAX_BYTES: u64 = 1 << 28;
/// The largest number of scenes in the cache.
const MAX_SCENES: usize = 256;
/// The age at which temporary files of killed commands are removed.
const LEFTOVER_AGE: Duration = Duration::from_secs(24 * 3600);

/// The file of a derived scene.
pub(crate) struct Entry {
    pub(super) path: PathBuf,
}

impl Entry {
    /// The file for the scene of a text, by a hash of the text and of the version of this program.
    pub(crate) fn new(source: &str) -> Self {
        let version = env!("CARGO_PKG_VERSION").bytes();
        let hash = digest(version.chain([0]).chain(source.bytes()));
        Self { path: folder().join(format!("{hash:016x}.scene")) }
    }

    /// Reads the scene if it exists, is complete, matches the text, and is not older than the engine.
    pub(crate) fn read(&self, source: &str) -> Option<DerivedScene> {
        let engine = super::engine::program().and_then(|program| modified(&program));
        if modified(&self.path) < engine {
            return None;
        }
        let derived = read(&self.path).filter(|derived| derived.description.source == source)?;
        // Recently used scenes are kept longest.
        let _ = File::options().append(true).open(&self.path).and_then(|file| file.set_modified(SystemTime::now()));
        Some(derived)
    }

    /// Removes the scene.
    pub(crate) fn remove(&self) {
        let _ = std::fs::remove_file(&self.path);
    }
}

/// Removes the least recently used scenes, and the temporary files of killed commands.
pub(super) fn prune() {
    let files = std::fs::read_dir(folder()).into_iter().flatten().flatten().map(|entry| entry.path());
    let files = files.filter_map(|path| Some((modified(&path)?, path)));
    let (mut scenes, others): (Vec<_>, Vec<_>) = files.partition(|(_, path)| has_extension(path, &["scene"]));
    scenes.sort_unstable_by(|a, b| b.cmp(a));
    let oldest = SystemTime::now() - LEFTOVER_AGE;
    let is_leftover =
        |(time, path): &(_, PathBuf)| *time < oldest && has_extension(path, &["under-way", "unverified", "part"]);
    for (_, path) in scenes.into_iter().skip(MAX_SCENES).chain(others.into_iter().filter(is_leftover)) {
        // Another command may have removed the file already.
        let _ = std::fs::remove_file(path);
    }
}

fn has_extension(path: &Path, extensions: &[&str]) -> bool {
    path.extension().is_some_and(|own| extensions.iter().any(|extension| own == *extension))
}

/// The time at which a file was written.
pub(super) fn modified(path: &Path) -> Option<SystemTime> {
    std::fs::metadata(path).and_then(|data| data.modified()).ok()
}

/// Reads a derived scene; `None` if it is missing or truncated.
pub(super) fn read(path: &Path) -> Option<DerivedScene> {
    let bytes = read_at_most(path, MAX_BYTES).ok()?;
    DerivedScene::from_bytes(&bytes)
}

/// The folder of derived scenes: `QRM_CACHE`, or the user's cache folder, or the temporary folder if that cannot be
/// created.
pub(super) fn folder() -> PathBuf {
    let own = std::env::var_os("QRM_CACHE").filter(|folder| !folder.is_empty()).map(PathBuf::from);
    let of_user = || etcetera::choose_base_strategy().ok().map(|folders| folders.cache_dir().join("qrm"));
    let usable = own.or_else(of_user).filter(|folder| std::fs::create_dir_all(folder).is_ok());
    usable.unwrap_or_else(|| std::env::temp_dir().join("qrm"))
}
