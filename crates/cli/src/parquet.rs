//! Converts a table in CSV to a Parquet file, in programs with the feature `parquet`.

#[cfg(feature = "parquet")]
mod writer;

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use qrm_scene::files::write_atomic_with;

use crate::error::Error;

/// The type of a column.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    /// An integer.
    Whole,
    /// A number.
    Number,
    /// Text.
    Text,
}

/// Returns an error if the program was built without Parquet.
pub(crate) fn require() -> Result<(), Error> {
    if cfg!(feature = "parquet") {
        return Ok(());
    }
    Err(Error::usage("this program was built without Parquet").help(
        "build it with the feature `parquet` (`cargo install --path . --features parquet`), or write `.csv`, which \
         pandas and polars turn into Parquet",
    ))
}

/// Copies a table in CSV to a Parquet file.
pub(crate) fn copy(table: &Path, path: &Path, kind: impl Fn(&str) -> Kind) -> io::Result<()> {
    write_atomic_with(path, |file| write(&mut io::BufReader::new(File::open(table)?), file, kind)).map(|_| ())
}

/// Writes a table with its header in the first line; returns the number of rows.
#[cfg(feature = "parquet")]
pub(crate) fn write(rows: &mut impl Read, file: &mut File, kind: impl Fn(&str) -> Kind) -> io::Result<usize> {
    writer::write(rows, file, kind)
}

/// Fails, since this program has no Parquet.
#[cfg(not(feature = "parquet"))]
pub(crate) fn write(_: &mut impl Read, _: &mut File, kind: impl Fn(&str) -> Kind) -> io::Result<usize> {
    let _ = [Kind::Whole, Kind::Number, Kind::Text].map(|own| kind("") == own);
    Err(io::Error::from(io::ErrorKind::Unsupported))
}
