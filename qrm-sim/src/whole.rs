//! Files that appear whole or not at all.

use std::io;
use std::path::Path;

/// Writes a file under another name first.
pub(crate) fn write_whole(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let mut name = path.file_name().unwrap_or_default().to_owned();
    // Another process may write the same file at the same time.
    name.push(format!(".{}.part", std::process::id()));
    let part = path.with_file_name(name);
    let written = std::fs::write(&part, bytes).and_then(|()| std::fs::rename(&part, path));
    if written.is_err() {
        // What is left of it is of no use; that it cannot be removed would be no news.
        let _ = std::fs::remove_file(&part);
    }
    written
}
