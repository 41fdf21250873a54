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
/// The extension of an engine's output file.
pub(super) const OUTPUT: &str = "under-way";
/// The extension of an engine's output file before verification.
pub(super) const UNVERIFIED: &str = "unverified";
/// The age at which temporary files of killed commands are removed.
const LEFTOVER_AGE: Duration = Duration::from_secs(24 * 3600);

/// The file of a derived scene; `None` if there is no cache folder.
pub(crate) struct Entry(Option<PathBuf>);

impl Entry {
    /// The file for the scene of a text, by a hash of the text and of the version of this program.
    pub(crate) fn new(source: &str) -> Self {
        let version = env!("CARGO_PKG_VERSION").bytes();
        let hash = digest(version.chain([0]).chain(source.bytes()));
        Self(folder().map(|folder| folder.join(format!("{hash:016x}.scene"))))
    }

    /// Reads the scene if it exists, is complete, matches the text, and is not older than the engine.
    pub(crate) fn read(&self, source: &str) -> Option<DerivedScene> {
        let path = self.0.as_ref()?;
        let engine = super::engine::program().and_then(|program| modified(&program));
        if modified(path) < engine {
            return None;
        }
        let derived = read(path).filter(|derived| derived.description.source == source)?;
        // Recently used scenes are kept longest.
        let _ = File::options().append(true).open(path).and_then(|file| file.set_modified(SystemTime::now()));
        Some(derived)
    }

    /// Moves a file of the engine here. Without a cache folder or room in it, the scene is derived again next time.
    pub(super) fn store(&self, file: &Path) {
        let _ = self.0.as_ref().map(|path| std::fs::rename(file, path));
    }

    /// Removes the scene.
    pub(crate) fn remove(&self) {
        let _ = self.0.as_ref().map(std::fs::remove_file);
    }
}

/// Removes the least recently used scenes, and the temporary files of killed commands. The folder may contain files of
/// others, which remain.
pub(super) fn prune() {
    if let Some(folder) = folder() {
        prune_folder(&folder);
    }
}

fn prune_folder(folder: &Path) {
    let files = std::fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path());
    let files = files.filter_map(|path| Some((modified(&path)?, Kind::from_path(&path)?, path)));
    let (mut scenes, temporary): (Vec<_>, Vec<_>) = files.partition(|(_, kind, _)| *kind == Kind::Scene);
    scenes.sort_unstable_by(|(a, ..), (b, ..)| b.cmp(a));
    let oldest = SystemTime::now() - LEFTOVER_AGE;
    let leftovers = temporary.into_iter().filter(|(time, ..)| *time < oldest);
    for (.., path) in scenes.into_iter().skip(MAX_SCENES).chain(leftovers) {
        // Another command may have removed the file already.
        let _ = std::fs::remove_file(path);
    }
}

/// The kind of a file that this program writes into the cache.
#[derive(PartialEq)]
enum Kind {
    Scene,
    Temporary,
}

impl Kind {
    /// The kind of a file by its name; `None` for a file of others.
    fn from_path(path: &Path) -> Option<Self> {
        let name = path.file_name()?.to_str()?;
        let is_hash =
            |text: &str| text.len() == 16 && text.bytes().all(|byte| matches!(byte, b'0'..=b'9' | b'a'..=b'f'));
        if name.strip_suffix(".scene").is_some_and(is_hash) {
            return Some(Self::Scene);
        }
        let is_number = |text: &str| !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
        let (numbers, extension) = name.strip_prefix("qrm-")?.split_once('.')?;
        let (process, engine) = numbers.split_once('-')?;
        // A file of the engine is first written under its name with a random text and `.part`.
        let own = extension.strip_suffix(".part").and_then(|own| own.split_once('.')).map_or(extension, |(own, _)| own);
        let is_own = is_number(process) && is_number(engine) && [OUTPUT, UNVERIFIED].contains(&own);
        is_own.then_some(Self::Temporary)
    }
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

/// The folder of derived scenes: `QRM_CACHE`, or the user's cache folder; `None` if it cannot be created.
pub(super) fn folder() -> Option<PathBuf> {
    let own = std::env::var_os("QRM_CACHE").filter(|folder| !folder.is_empty()).map(PathBuf::from);
    let of_user = || etcetera::choose_base_strategy().ok().map(|folders| folders.cache_dir().join("qrm"));
    own.or_else(of_user).filter(|folder| std::fs::create_dir_all(folder).is_ok())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Files of others have the same extensions, and names that are almost those of this program.
    #[test]
    fn files_of_others_remain() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let write = |name: &str, age: Duration| {
            let file = File::create(folder.path().join(name)).expect("written");
            file.set_modified(SystemTime::now() - age).expect("an older date");
        };
        let others = [
            "a.part",
            "b.under-way",
            "c.unverified",
            "notes.scene",
            "0123456789abcdef0.scene",
            "0123456789ABCDEF.scene",
            "7-0.under-way",
            "qrm-7-0.part",
            "qrm-7-.under-way",
            "qrm-7-x.unverified",
            "qrm-7-0.csv.part",
            "qrm-7-0.under-way.csv",
            "qrm-notes.under-way.a1B2c3.part",
        ];
        let leftovers = [
            "qrm-7-0.under-way",
            "qrm-7-0.unverified",
            "qrm-7-12.under-way.a1B2c3.part",
            "qrm-7-12.unverified.a1B2c3.part",
        ];
        let recent = "qrm-8-0.under-way";
        let hour = Duration::from_secs(3600);
        others.iter().chain(&leftovers).for_each(|name| write(name, 1000 * hour));
        write(recent, hour);
        // The last scenes are the oldest.
        let scenes: Vec<String> = (0..MAX_SCENES + 3).map(|number| format!("{number:016x}.scene")).collect();
        scenes.iter().zip(1..).for_each(|(name, age)| write(name, age * hour));
        prune_folder(folder.path());
        let mut expected: Vec<&str> = others.into_iter().chain([recent]).collect();
        expected.extend(scenes[..MAX_SCENES].iter().map(String::as_str));
        expected.sort_unstable();
        let left = std::fs::read_dir(folder.path()).expect("a folder").flatten();
        let mut left: Vec<String> = left.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
        left.sort_unstable();
        assert_eq!(left, expected);
    }
}
