//! Reads and writes small files atomically.

use std::fs::{self, File};
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};

use tempfile::{Builder, NamedTempFile, TempPath};

/// Reads a file of limited size.
///
/// # Errors
/// The file cannot be read, is not a regular file, or is larger than `most`.
pub fn read_at_most(path: &Path, most: u64) -> io::Result<Vec<u8>> {
    // Pipes and devices may never end.
    let data = fs::metadata(path)?;
    if !data.is_file() {
        return Err(io::Error::other(if data.is_dir() { "it is a folder" } else { "it is not a plain file" }));
    }
    let mut bytes = Vec::new();
    File::open(path)?.take(most + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > most { Err(io::Error::other(format!("it has more than {most} bytes"))) } else { Ok(bytes) }
}

/// The path of a file while it is being written, next to its final path.
pub fn temporary_path(path: &Path) -> PathBuf {
    let mut name = path.file_name().unwrap_or_default().to_owned();
    name.push(".under-way");
    path.with_file_name(name)
}

/// Opens a file for appending and locks it against other processes; creates the file and its folder if necessary.
///
/// # Errors
/// The file cannot be opened; [`io::ErrorKind::WouldBlock`] if another process has locked it.
pub fn open_locked(path: &Path) -> io::Result<File> {
    path.parent().map_or(Ok(()), fs::create_dir_all)?;
    loop {
        let file = File::options().read(true).append(true).create(true).open(path)?;
        file.try_lock().map_err(|e| match e {
            fs::TryLockError::WouldBlock => io::Error::from(io::ErrorKind::WouldBlock),
            fs::TryLockError::Error(e) => e,
        })?;
        // The other process may have moved the file before it released the lock.
        if is_at(&file, path) {
            return Ok(file);
        }
    }
}

/// Whether a path still refers to an open file.
fn is_at(file: &File, path: &Path) -> bool {
    #[cfg(unix)]
    {
        use std::os::unix::fs::MetadataExt;
        let place = |data: fs::Metadata| (data.dev(), data.ino());
        match (file.metadata(), fs::metadata(path)) {
            (Ok(own), Ok(there)) => place(own) == place(there),
            _ => false,
        }
    }
    #[cfg(not(unix))]
    {
        let _ = file;
        path.exists()
    }
}

/// Writes a file atomically; creates its folder if necessary.
///
/// # Errors
/// The folder or the file cannot be written; temporary files are removed.
pub fn write_atomic(path: &Path, bytes: &[u8]) -> io::Result<()> {
    write_atomic_with(path, |file| file.write_all(bytes))
}

/// Writes a file atomically through a function: see [`write_atomic`].
///
/// # Errors
/// The file cannot be written, or the function failed.
pub fn write_atomic_with<T>(path: &Path, write: impl FnOnce(&mut File) -> io::Result<T>) -> io::Result<T> {
    path.parent().map_or(Ok(()), fs::create_dir_all)?;
    let mut part = part(path)?;
    let written = write(part.as_file_mut())?;
    part.into_temp_path().persist(path)?;
    Ok(written)
}

/// Writes files that belong together: none appears before all of them are written.
///
/// # Errors
/// The path of a file and the reason why it cannot be written. Temporary files are removed; files that were already
/// moved to their final path remain.
pub fn write_all_atomic(files: &[(PathBuf, impl AsRef<[u8]>)]) -> Result<(), (&Path, io::Error)> {
    let mut parts = Vec::new();
    for (path, bytes) in files {
        let written = || -> io::Result<TempPath> {
            if path.is_dir() {
                return Err(io::ErrorKind::IsADirectory.into());
            }
            path.parent().map_or(Ok(()), fs::create_dir_all)?;
            let mut part = part(path)?;
            part.write_all(bytes.as_ref())?;
            Ok(part.into_temp_path())
        };
        parts.push(written().map_err(|e| (path.as_path(), e))?);
    }
    for (part, (path, _)) in parts.into_iter().zip(files) {
        part.persist(path).map_err(|e| (path.as_path(), e.error))?;
    }
    Ok(())
}

/// Creates a temporary file in the folder of `path`; it is removed when dropped.
fn part(path: &Path) -> io::Result<NamedTempFile> {
    let mut prefix = path.file_name().unwrap_or_default().to_owned();
    prefix.push(".");
    let mut builder = Builder::new();
    builder.prefix(&prefix).suffix(".part");
    // The permissions of an ordinary new file.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    let folder = path.parent().filter(|folder| *folder != Path::new(""));
    builder.tempfile_in(folder.unwrap_or(Path::new(".")))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn folder(name: &str) -> PathBuf {
        std::env::temp_dir().join(format!("qrm-files-{name}-{}", std::process::id()))
    }

    #[test]
    fn a_failed_write_leaves_the_earlier_file() {
        let folder = folder("failed");
        let path = folder.join("below/file.txt");
        write_atomic(&path, b"first").expect("written");
        let failed = write_atomic_with(&path, |file| {
            file.write_all(b"second")?;
            Err::<(), _>(io::Error::other("no more"))
        });
        assert!(failed.is_err());
        assert_eq!(fs::read(&path).expect("there"), b"first");
        assert_eq!(fs::read_dir(folder.join("below")).expect("a folder").count(), 1);
        fs::remove_dir_all(folder).expect("removed");
    }

    #[test]
    fn files_that_belong_together_appear_together() {
        let folder = folder("together");
        let files: Vec<(PathBuf, &str)> = ["a", "b"].map(|name| (folder.join(name), name)).to_vec();
        fs::create_dir_all(folder.join("b")).expect("made");
        let (path, e) = write_all_atomic(&files).expect_err("one is a folder");
        assert_eq!((path, e.kind()), (&*folder.join("b"), io::ErrorKind::IsADirectory));
        assert_eq!(fs::read_dir(&folder).expect("a folder").count(), 1);
        fs::remove_dir(folder.join("b")).expect("removed");
        write_all_atomic(&files).expect("written");
        assert_eq!(fs::read_dir(&folder).expect("a folder").count(), 2);
        assert_eq!(fs::read(folder.join("b")).expect("there"), b"b");
        fs::remove_dir_all(folder).expect("removed");
    }

    #[test]
    fn long_and_endless_files_are_not_read() {
        let path = folder("long");
        fs::write(&path, b"12345").expect("written");
        assert_eq!(read_at_most(&path, 5).expect("read"), b"12345");
        assert!(read_at_most(&path, 4).is_err());
        assert!(read_at_most(Path::new("/dev/zero"), 4).is_err() && read_at_most(&std::env::temp_dir(), 4).is_err());
        fs::remove_file(path).expect("removed");
    }

    #[test]
    fn a_file_is_opened_by_one_at_a_time() {
        let path = folder("alone").join("rows");
        let mut first = open_locked(&path).expect("opened");
        first.write_all(b"one").expect("written");
        assert_eq!(open_locked(&path).map_err(|e| e.kind()).err(), Some(io::ErrorKind::WouldBlock));
        fs::rename(&path, path.with_extension("done")).expect("moved");
        // The name can be used again, though the first file is still locked.
        let second = open_locked(&path).expect("another file");
        assert_eq!(second.metadata().expect("there").len(), 0);
        fs::remove_dir_all(folder("alone")).expect("removed");
    }

    #[test]
    fn two_writers_do_not_mix() {
        let folder = folder("two");
        let path = folder.join("file.txt");
        std::thread::scope(|scope| {
            for letter in [b'a', b'b'] {
                let path = &path;
                scope.spawn(move || (0..50).for_each(|_| write_atomic(path, &[letter; 10_000]).expect("written")));
            }
        });
        let bytes = fs::read(&path).expect("there");
        assert!(bytes.len() == 10_000 && bytes.iter().all(|byte| *byte == bytes[0]));
        assert_eq!(fs::read_dir(&folder).expect("a folder").count(), 1);
        fs::remove_dir_all(folder).expect("removed");
    }
}
