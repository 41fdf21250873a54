//! The rows of a sweep under way, from which an interrupted sweep goes on.

use std::fs::{File, OpenOptions};
use std::io::{self, BufRead, BufReader, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use qrm_sim::columns::Column;

use super::rows::{Field, Row};
use super::table::{Format, RowReader};
use crate::error::Error;

/// A table under way: a line that names the sweep, then rows as CSV.
pub(super) struct Journal {
    path: PathBuf,
    file: File,
    /// Designs that came to their end, and those that did not.
    counts: (usize, usize),
}

impl Journal {
    /// Opens the table that belongs to `out`; returns it with the number of designs that are in it already.
    pub(super) fn open(
        out: &Path,
        title: &str,
        columns: &[Column<Field>],
        first: usize,
    ) -> Result<(Self, usize), Error> {
        let mut name = out.file_name().unwrap_or_default().to_owned();
        name.push(".under-way");
        let path = out.with_file_name(name);
        let failed = |e: io::Error| Error::unwritable(&path, &e);
        path.parent().map_or(Ok(()), std::fs::create_dir_all).map_err(|e| Error::unwritable(out, &e))?;
        let mut file = OpenOptions::new().read(true).append(true).create(true).open(&path).map_err(failed)?;
        // Two at once would mix their rows.
        if file.try_lock().is_err() {
            return Err(Error::usage(format!("another sweep is writing {}", path.display())));
        }
        let found = Found::read(&mut file, columns.len(), first).map_err(failed)?;
        let mut journal = Self { path: path.clone(), file, counts: (found.done, found.failed) };
        if found.title.is_empty() {
            journal.file.set_len(0).map_err(failed)?;
            let header: Vec<&str> = columns.iter().map(|column| column.name.as_str()).collect();
            writeln!(journal.file, "{title}\n{}", header.join(",")).map_err(failed)?;
            return Ok((journal, 0));
        }
        if found.title != title {
            let text = format!("{} holds the rows of another sweep that was interrupted", path.display());
            return Err(Error::usage(text)
                .help("finish that one by the command that began it, remove the file, or choose another --out"));
        }
        if let Some(why) = found.wrong {
            let text = format!("{} was changed since its sweep was interrupted: {why}", path.display());
            return Err(Error::usage(text).help("remove the file, to begin again"));
        }
        // A row that was cut off is computed again.
        journal.file.set_len(found.length).map_err(failed)?;
        Ok((journal, found.done + found.failed))
    }

    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// Designs that came to their end, and those that did not.
    pub(super) fn counts(&self) -> (usize, usize) {
        self.counts
    }

    pub(super) fn write(&mut self, rows: &[Row]) -> Result<(), Error> {
        let mut writer = csv::Writer::from_writer(Vec::new());
        let written = rows.iter().try_for_each(|row| writer.write_record(&row.fields));
        let bytes = written
            .map_err(io::Error::other)
            .and_then(|()| writer.into_inner().map_err(|e| io::Error::other(e.to_string())));
        let written = bytes.and_then(|bytes| self.file.write_all(&bytes));
        written.map_err(|e| Error::unwritable(&self.path, &e).while_running())?;
        let done = rows.iter().filter(|row| row.is_done).count();
        self.counts = (self.counts.0 + done, self.counts.1 + rows.len() - done);
        Ok(())
    }

    /// Makes the table from the rows, and removes them.
    pub(super) fn finish(self, out: &Path) -> Result<(), Error> {
        let format = Format::of(out)?;
        let written = File::open(&self.path).and_then(|file| {
            let mut rows = BufReader::new(file);
            rows.read_line(&mut String::new())?;
            format.write(&mut rows, out)?;
            std::fs::remove_file(&self.path)
        });
        written.map_err(|e| Error::unwritable(out, &e).while_running())
    }
}

/// The contents of a table under way.
struct Found {
    title: String,
    done: usize,
    failed: usize,
    /// Up to the end of the last whole row.
    length: u64,
    /// The mistake in a row.
    wrong: Option<String>,
}

impl Found {
    fn read(file: &mut File, columns: usize, first: usize) -> io::Result<Self> {
        file.seek(SeekFrom::Start(0))?;
        let mut reader = BufReader::new(file);
        let mut found = Self { title: String::new(), done: 0, failed: 0, length: 0, wrong: None };
        let mut rows = RowReader { columns, next: Some(first) };
        let mut line = String::new();
        for number in 0.. {
            line.clear();
            let count = reader.read_line(&mut line)?;
            if count == 0 || !line.ends_with('\n') {
                break;
            }
            found.length += count as u64;
            match number {
                0 => found.title = line.trim_end().to_owned(),
                1 => {}
                _ => match rows.check(&line) {
                    Ok(true) => found.done += 1,
                    Ok(false) => found.failed += 1,
                    Err(why) => {
                        found.wrong = Some(format!("in line {}, {why}", number + 1));
                        break;
                    }
                },
            }
        }
        // Without its header it is as good as not begun.
        if found.length <= found.title.len() as u64 + 1 {
            found.title.clear();
        }
        Ok(found)
    }
}
