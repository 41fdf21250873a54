//! The rows of an unfinished sweep, from which an interrupted sweep continues.

use std::fs::File;
use std::io::{self, BufRead, BufReader, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use qrm_core::digest;
use qrm_scene::files::{open_locked, temporary_path};
use qrm_sim::columns::Column;

use super::rows::{Block, Field};
use super::table::Format;
use crate::error::Error;
use crate::output::check_target;

/// An unfinished table: a line that identifies the sweep, the header, and blocks of rows in CSV, each followed by a
/// mark.
pub(super) struct Journal {
    path: PathBuf,
    file: File,
    mark: Mark,
}

/// The line after a block of rows: the number of rows so far, and a digest of everything since the previous mark.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Mark {
    done: usize,
    failed: usize,
    line: String,
}

impl Mark {
    fn new(before: &str, block: &[u8], done: usize, failed: usize) -> Self {
        let counts = format!("# {done} done, {failed} failed");
        let digest = digest(before.bytes().chain(block.iter().copied()).chain(counts.bytes()));
        Self { done, failed, line: format!("{counts} {digest:016x}\n") }
    }

    /// Reads a mark, if it matches its block.
    fn read(line: &str, before: &str, block: &[u8]) -> Option<Self> {
        let mut words = line.split_whitespace();
        let counts = [words.nth(1)?, words.nth(1)?].map(str::parse);
        let mark = Self::new(before, block, counts[0].clone().ok()?, counts[1].clone().ok()?);
        (mark.line == line).then_some(mark)
    }
}

impl Journal {
    /// Opens the unfinished table of `out`; returns it with the number of designs in it.
    pub(super) fn open(out: &Path, title: &str, columns: &[Column<Field>]) -> Result<(Self, usize), Error> {
        check_target(out)?;
        let path = temporary_path(out);
        let failed = |e: io::Error| Error::unwritable(&path, &e);
        let mut file = open_locked(&path).map_err(|e| Error::unwritable(out, &e))?;
        let title = format!("# {title}\n");
        match Found::read(&mut file, &title).map_err(failed)? {
            Found::Nothing => {
                let header: Vec<&str> = columns.iter().map(|column| column.name.as_str()).collect();
                let header = header.join(",") + "\n";
                let mark = Mark::new(&title, header.as_bytes(), 0, 0);
                file.set_len(0).and_then(|()| write!(file, "{title}{header}{}", mark.line)).map_err(failed)?;
                Ok((Self { path, file, mark }, 0))
            }
            Found::Rows { mark, length } => {
                // A truncated block is computed again.
                file.set_len(length).map_err(failed)?;
                let count = mark.done + mark.failed;
                Ok((Self { path, file, mark }, count))
            }
            Found::Other => {
                let text = format!("{} holds the rows of another sweep that was interrupted", path.display());
                Err(Error::usage(text)
                    .help("finish that one by the command that began it, remove the file, or choose another --out"))
            }
            Found::Changed(line) => {
                let text =
                    format!("{} was changed in or before line {line}, since its sweep was interrupted", path.display());
                Err(Error::usage(text).help("remove the file, to begin again"))
            }
        }
    }

    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// The number of designs that reached their end, and of those that did not.
    pub(super) fn counts(&self) -> (usize, usize) {
        (self.mark.done, self.mark.failed)
    }

    /// Writes rows and their mark at once.
    pub(super) fn write(&mut self, rows: &Block) -> Result<(), Error> {
        let [done, failed] = [self.mark.done + rows.done, self.mark.failed + rows.failed];
        let mark = Mark::new(&self.mark.line, rows.text.as_bytes(), done, failed);
        let text = [rows.text.as_bytes(), mark.line.as_bytes()].concat();
        self.file.write_all(&text).map_err(|e| Error::unwritable(&self.path, &e).while_running())?;
        self.mark = mark;
        Ok(())
    }

    /// Converts the rows to the final table, and removes them.
    pub(super) fn finish(self, out: &Path) -> Result<(), Error> {
        let format = Format::from_path(out)?;
        let written = File::open(&self.path).and_then(|file| {
            format.write(&mut Rows { lines: BufReader::new(file), line: Vec::new(), place: 0 }, out)?;
            std::fs::remove_file(&self.path)
        });
        written.map_err(|e| Error::unwritable(out, &e).while_running())
    }
}

/// The contents of an unfinished table.
#[derive(Debug, PartialEq, Eq)]
enum Found {
    /// No finished block.
    Nothing,
    /// The rows up to a mark, and the length of the file up to it.
    Rows { mark: Mark, length: u64 },
    /// Rows of another sweep.
    Other,
    /// The number of a line that does not match the lines before it.
    Changed(usize),
}

impl Found {
    fn read(file: &mut (impl Read + Seek), title: &str) -> io::Result<Self> {
        file.seek(SeekFrom::Start(0))?;
        let mut reader = BufReader::new(file);
        let mut found = Self::Nothing;
        let (mut before, mut block, mut line) = (title.to_owned(), Vec::new(), Vec::new());
        let mut length = 0;
        for number in 1.. {
            line.clear();
            length += reader.read_until(b'\n', &mut line)? as u64;
            if line.last() != Some(&b'\n') {
                break;
            }
            if number == 1 {
                if line != title.as_bytes() {
                    return Ok(Self::Other);
                }
            } else if line[0] == b'#' {
                let mark = str::from_utf8(&line).ok().and_then(|line| Mark::read(line, &before, &block));
                let Some(mark) = mark else { return Ok(Self::Changed(number)) };
                before.clone_from(&mark.line);
                block.clear();
                found = Self::Rows { mark, length };
            } else {
                block.extend(&line);
            }
        }
        Ok(found)
    }
}

/// The lines of an unfinished table that belong to the final table.
struct Rows<R> {
    lines: R,
    line: Vec<u8>,
    place: usize,
}

impl<R: BufRead> Read for Rows<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        while self.place == self.line.len() {
            self.place = 0;
            self.line.clear();
            if self.lines.read_until(b'\n', &mut self.line)? == 0 {
                return Ok(0);
            }
            if self.line[0] == b'#' {
                self.line.clear();
            }
        }
        let count = (&self.line[self.place..]).read(buffer)?;
        self.place += count;
        Ok(count)
    }
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use super::*;

    const TITLE: &str = "# a sweep\n";

    /// An unfinished table of three blocks.
    fn text() -> Vec<u8> {
        let mut text = TITLE.to_owned();
        let mut mark = Mark { done: 0, failed: 0, line: TITLE.to_owned() };
        for (i, block) in ["design,status\n", "0,done\n1,failed\n", "2,done\n"].into_iter().enumerate() {
            let failed = usize::from(i > 0);
            mark = Mark::new(&mark.line, block.as_bytes(), i, failed);
            text += block;
            text += &mark.line;
        }
        text.into_bytes()
    }

    fn found(text: &[u8]) -> Found {
        Found::read(&mut Cursor::new(text), TITLE).expect("read")
    }

    #[test]
    fn rows_are_those_between_the_marks() {
        let mut table = String::new();
        Rows { lines: text().as_slice(), line: Vec::new(), place: 0 }.read_to_string(&mut table).expect("read");
        assert_eq!(table, "design,status\n0,done\n1,failed\n2,done\n");
        let Found::Rows { mark, length } = found(&text()) else { panic!("no rows") };
        assert_eq!((mark.done, mark.failed, length), (2, 1, text().len() as u64));
    }

    #[test]
    fn whatever_is_cut_off_is_computed_again() {
        let whole = text();
        for length in 0..whole.len() {
            match found(&whole[..length]) {
                Found::Nothing => {}
                Found::Rows { mark, length: kept } => {
                    assert!(kept as usize <= length);
                    assert!(whole[..kept as usize].ends_with(mark.line.as_bytes()));
                }
                other => panic!("{other:?} at {length}"),
            }
        }
    }

    #[test]
    fn a_changed_byte_is_never_taken_for_a_row() {
        let whole = text();
        for place in 0..whole.len() {
            for bit in 0..8 {
                let mut changed = whole.clone();
                changed[place] ^= 1 << bit;
                match found(&changed) {
                    Found::Nothing | Found::Other | Found::Changed(_) => {}
                    // The change lies behind the rows that are kept.
                    Found::Rows { length, .. } => assert!(length as usize <= place, "bit {bit} of byte {place}"),
                }
            }
        }
    }
}
