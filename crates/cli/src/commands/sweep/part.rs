//! A separately computed part of a sweep, and the joining of parts.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, BufRead, BufReader, Read};
use std::path::{Path, PathBuf};

use qrm_core::digest;
use qrm_scene::files::read_at_most;
use qrm_sim::columns::Column;
use serde::{Deserialize, Serialize};

use super::rows::Field;
use super::table::Format;
use crate::columns::{Meaning, save_units};
use crate::error::Error;
use crate::output::save_json;

/// The identity of a part, stored in `NAME.part.json` next to its table `NAME.csv`.
#[derive(Serialize, Deserialize)]
pub(super) struct Part {
    /// The scene, the version of the program and a digest of everything that determines the rows of the sweep.
    pub(super) sweep: String,
    /// The number of designs of the sweep.
    pub(super) designs: usize,
    /// The first design of this part.
    pub(super) first: usize,
    /// The number of designs of this part.
    pub(super) count: usize,
    /// The digest of the table.
    digest: String,
    /// Units and descriptions of the columns.
    columns: BTreeMap<String, Meaning>,
}

/// The largest accepted size of a part's description.
const MAX_BYTES: u64 = 1 << 22;

impl Part {
    /// Writes the identity of the part of a sweep whose table is complete.
    pub(super) fn save(
        sweep: &str,
        designs: usize,
        (first, end): (usize, usize),
        columns: &[Column<Field>],
        table: &Path,
    ) -> Result<(), Error> {
        let columns = columns.iter().map(|column| (column.name.clone(), Meaning::new(column))).collect();
        let digest = digest_of(table).map_err(|e| Error::unreadable(table, &e).while_running())?;
        let part = Self { sweep: sweep.to_owned(), designs, first, count: end - first, digest, columns };
        save_json(&table.with_extension("part.json"), &part).map_err(Error::while_running)
    }

    /// Reads the identity of the part with this table.
    fn read(table: &Path) -> Result<Self, Error> {
        let path = table.with_extension("part.json");
        let text = read_at_most(&path, MAX_BYTES).map_err(|e| {
            Error::unreadable(&path, &e).help("`qrm sweep --shard K/N` writes it next to its table; keep both together")
        })?;
        serde_json::from_slice(&text)
            .map_err(|e| Error::usage(format!("{} is no part of a sweep: {e}", path.display())))
    }
}

fn digest_of(path: &Path) -> io::Result<String> {
    let mut failed = Ok(());
    let bytes = BufReader::new(File::open(path)?).bytes();
    let value = digest(bytes.map_while(|byte| byte.map_err(|e| failed = Err(e)).ok()));
    failed.map(|()| format!("{value:016x}"))
}

/// Joins the parts of a sweep into one table; returns its number of rows and the path of its units.
pub(crate) fn join(parts: &[PathBuf], out: &Path) -> Result<(usize, PathBuf), Error> {
    let format = Format::from_path(out)?;
    format.require()?;
    if let Some(part) = parts.iter().find(|part| is_same_file(part, out)) {
        return Err(Error::usage(format!("{} is both a part and the table to write", part.display()))
            .help("name the table first, then the parts"));
    }
    let mut before: Option<(&PathBuf, Part)> = None;
    for path in parts {
        let part = Part::read(path)?;
        check(path, &part, before.as_ref())?;
        before = Some((path, part));
    }
    let Some((path, last)) = before.filter(|(_, last)| last.first + last.count == last.designs) else {
        let last = parts.last().map_or_else(String::new, |last| last.display().to_string());
        return Err(Error::usage(format!("{last} is not the last part of its sweep")).help(ALL));
    };
    let mut rows = Rows { parts, place: 0, reader: None };
    let count = format.write(&mut rows, out).map_err(|e| Error::unwritable(out, &e))?;
    let header = BufReader::new(File::open(path).map_err(|e| Error::unreadable(path, &e))?).lines().next();
    let header = header.transpose().map_err(|e| Error::unreadable(path, &e))?.unwrap_or_default();
    let mut meanings = last.columns;
    let columns = header.split(',').filter_map(|name| meanings.remove_entry(name));
    Ok((count, save_units(out, columns.collect())?))
}

/// The hint for parts that do not fit together.
const ALL: &str = "give all parts of one sweep in their order";

/// Returns an error if a part does not follow the previous one, or its table was changed.
fn check(path: &Path, part: &Part, before: Option<&(&PathBuf, Part)>) -> Result<(), Error> {
    let name = path.display();
    let next = match before {
        Some((other, before)) if before.sweep != part.sweep || before.designs != part.designs => {
            let text = format!("{name} and {} belong to different sweeps", other.display());
            return Err(Error::usage(text).help("scene, version of the program and options must be the same"));
        }
        Some((_, before)) => before.first + before.count,
        None => 0,
    };
    if part.first != next {
        return Err(Error::usage(format!("{name} begins with design {} instead of {next}", part.first)).help(ALL));
    }
    let digest = digest_of(path).map_err(|e| Error::unreadable(path, &e))?;
    if digest != part.digest {
        return Err(
            Error::usage(format!("{name} was changed or cut off since it was written")).help("compute this part again")
        );
    }
    Ok(())
}

/// Whether two paths lead to the same file.
fn is_same_file(a: &Path, b: &Path) -> bool {
    a == b || matches!((a.canonicalize(), b.canonicalize()), (Ok(a), Ok(b)) if a == b)
}

/// The rows of tables one after another, below the header of the first.
struct Rows<'p> {
    parts: &'p [PathBuf],
    place: usize,
    reader: Option<BufReader<File>>,
}

impl Read for Rows<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        loop {
            if let Some(reader) = &mut self.reader {
                match reader.read(buffer)? {
                    0 => self.place += 1,
                    count => return Ok(count),
                }
            }
            let Some(part) = self.parts.get(self.place) else { return Ok(0) };
            let mut reader = BufReader::new(File::open(part)?);
            if self.place > 0 {
                reader.read_until(b'\n', &mut Vec::new())?;
            }
            self.reader = Some(reader);
        }
    }
}
