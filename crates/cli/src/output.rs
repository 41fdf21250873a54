//! The output of the command: standard output and files.

use std::collections::BTreeSet;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};

use qrm_scene::files::{write_all_atomic, write_atomic};
use serde::Serialize;
use serde::ser::{SerializeMap, Serializer};

use crate::error::Error;

/// Set when printing failed.
static FAILED: AtomicBool = AtomicBool::new(false);

/// Prints to standard output, which may be closed.
pub(crate) fn print(text: &str) {
    let mut out = std::io::stdout();
    if let Err(e) = writeln!(out, "{text}").and_then(|()| out.flush())
        && e.kind() != std::io::ErrorKind::BrokenPipe
    {
        FAILED.store(true, Ordering::Relaxed);
    }
}

/// Returns an error if printing failed.
pub(crate) fn printed() -> Result<(), Error> {
    if FAILED.load(Ordering::Relaxed) { Err(Error::run("cannot write to the standard output")) } else { Ok(()) }
}

/// The scene files read so far.
static SCENE_FILES: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

/// Protects a scene file from being overwritten by a result.
pub(crate) fn protect(scene: &Path) {
    if let Ok(path) = scene.canonicalize().or_else(|_| std::path::absolute(scene)) {
        SCENE_FILES.lock().unwrap_or_else(PoisonError::into_inner).insert(path);
    }
}

/// Returns an error if a result would overwrite a scene file. Links to scene files may be replaced.
pub(crate) fn check_target(path: &Path) -> Result<(), Error> {
    let is_link = path.is_symlink();
    let files = SCENE_FILES.lock().unwrap_or_else(PoisonError::into_inner);
    match path.canonicalize() {
        Ok(real) if !is_link && files.contains(&real) => {
            Err(Error::usage(format!("the result would replace the scene file {}", path.display()))
                .help("choose another place by `--out`, or another name for the scene"))
        }
        _ => Ok(()),
    }
}

/// Writes a file of a command; creates its folder if necessary.
pub(crate) fn save(path: &Path, bytes: &[u8]) -> Result<(), Error> {
    check_target(path)?;
    write_atomic(path, bytes).map_err(|e| Error::unwritable(path, &e))
}

/// Writes files of a command that belong together: all or none.
pub(crate) fn save_all(files: &[(PathBuf, String)]) -> Result<(), Error> {
    files.iter().try_for_each(|(path, _)| check_target(path))?;
    write_all_atomic(files).map_err(|(path, e)| Error::unwritable(path, &e))
}

/// Writes a file and prints its size.
pub(crate) fn save_and_print(path: &Path, bytes: &[u8]) -> Result<(), Error> {
    save(path, bytes)?;
    print(&format!("wrote {} ({} kB)", path.display(), bytes.len().div_ceil(1000)));
    Ok(())
}

/// The line that lists the written files.
pub(crate) fn written(files: &[String]) -> String {
    let files = if files.is_empty() { "nothing".to_owned() } else { files.join("\n      ") };
    format!("wrote {files}")
}

/// Quotes a word of a command line if a shell would split it.
pub(crate) fn shell_word(word: &str) -> String {
    let is_plain = |c: char| c.is_alphanumeric() || "_-./:=@%+,".contains(c);
    if !word.is_empty() && word.chars().all(is_plain) {
        word.to_owned()
    } else {
        format!("'{}'", word.replace('\'', r"'\''"))
    }
}

/// Writes a value as a file in JSON.
pub(crate) fn save_json(path: &Path, value: &impl Serialize) -> Result<(), Error> {
    let text = serde_json::to_string_pretty(value)?;
    save(path, format!("{text}\n").as_bytes())
}

/// The bytes of a table in CSV.
pub(crate) fn csv<R>(
    header: impl IntoIterator<Item: AsRef<[u8]>>,
    rows: impl Iterator<Item = R>,
) -> Result<Vec<u8>, Error>
where
    R: IntoIterator<Item: AsRef<[u8]>>,
{
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(header)?;
    rows.into_iter().try_for_each(|row| writer.write_record(row))?;
    writer.into_inner().map_err(|e| csv::Error::from(e.into_error()).into())
}

/// Values with names, in order.
#[derive(Debug)]
pub(crate) struct Named<T>(pub(crate) Vec<(String, T)>);

impl<T> Named<T> {
    pub(crate) fn get(&self, name: &str) -> Option<&T> {
        self.0.iter().find(|(other, _)| other == name).map(|(_, value)| value)
    }
}

impl<T: Serialize> Serialize for Named<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(self.0.len()))?;
        self.0.iter().try_for_each(|(name, value)| map.serialize_entry(name, value))?;
        map.end()
    }
}
