//! The table of a sweep, in the format given by its file name.

use std::io::{self, BufWriter, Read, Write};
use std::path::Path;

use qrm_scene::files::write_atomic_with;

use super::rows::parquet_kind;
use crate::error::Error;
use crate::parquet;

/// The format of a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Format {
    Csv,
    Parquet,
}

impl Format {
    /// The format given by the extension of a file.
    pub(super) fn from_path(path: &Path) -> Result<Self, Error> {
        let name = path.display();
        if path.is_dir() || path.as_os_str().to_string_lossy().ends_with(std::path::is_separator) {
            return Err(Error::usage(format!("`{name}` is a folder")).help(
                "name the file that the table is written \
             to",
            ));
        }
        match path.extension().and_then(|e| e.to_str()) {
            Some(ending) if ending.eq_ignore_ascii_case("csv") => Ok(Self::Csv),
            Some(ending) if ending.eq_ignore_ascii_case("parquet") => Ok(Self::Parquet),
            _ => Err(Error::usage(format!("`{name}` ends in neither `.csv` nor `.parquet`"))
                .help("the ending says how the table is written")),
        }
    }

    /// Returns an error if this program cannot write the format.
    pub(super) fn require(self) -> Result<(), Error> {
        if self == Self::Parquet { parquet::require() } else { Ok(()) }
    }

    /// Writes rows and their header as a table; returns the number of rows.
    pub(super) fn write(self, rows: &mut impl Read, path: &Path) -> io::Result<usize> {
        write_atomic_with(path, |file| {
            let count = match self {
                Self::Csv => copy_lines(rows, file)?.saturating_sub(1),
                Self::Parquet => parquet::write(rows, file, parquet_kind)?,
            };
            // Synced, since the source rows are removed next.
            file.sync_all()?;
            Ok(count)
        })
    }
}

/// Copies text; returns the number of lines.
fn copy_lines(from: &mut impl Read, to: &mut impl Write) -> io::Result<usize> {
    let mut to = BufWriter::with_capacity(1 << 16, to);
    let (mut buffer, mut lines) = (vec![0; 1 << 16], 0);
    loop {
        match from.read(&mut buffer)? {
            0 => return to.flush().map(|()| lines),
            count => {
                to.write_all(&buffer[..count])?;
                lines += buffer[..count].iter().filter(|&&byte| byte == b'\n').count();
            }
        }
    }
}
