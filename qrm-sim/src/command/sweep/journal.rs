//! The rows of a sweep on disk: a table under way, from which an interrupted sweep goes on, and the table in the end.

use std::fs::{File, OpenOptions};
use std::io::{self, BufRead, BufReader, BufWriter, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use super::super::parquet;
use super::super::{Failure, unwritable};
use super::row::Line;

/// A table under way: a line that says of which sweep, then rows as CSV.
pub(super) struct Journal {
    path: PathBuf,
    file: File,
    /// Designs that came to their end, and those that did not.
    counts: (usize, usize),
}

/// What a table is written as.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Ending {
    Csv,
    Parquet,
}

/// What the name of a file asks for.
pub(super) fn ending(path: &Path) -> Result<Ending, Failure> {
    if path.is_dir() || path.as_os_str().to_string_lossy().ends_with(std::path::is_separator) {
        return Err(Failure::Use(format!(
            "error: `{}` is a folder\n  = help: name the file that the table is written to",
            path.display()
        )));
    }
    match path.extension().and_then(|e| e.to_str()) {
        Some(ending) if ending.eq_ignore_ascii_case("csv") => Ok(Ending::Csv),
        Some(ending) if ending.eq_ignore_ascii_case("parquet") => Ok(Ending::Parquet),
        _ => Err(Failure::Use(format!(
            "error: `{}` ends in neither `.csv` nor `.parquet`\n  = help: the ending says how the table is written",
            path.display()
        ))),
    }
}

impl Journal {
    /// Opens the table that belongs to `out`, and says how many designs are in it already.
    pub(super) fn open(out: &Path, title: &str, header: &[String], first: usize) -> Result<(Self, usize), Failure> {
        super::make_folder(out)?;
        let path = beside(out, "under-way");
        let failed = |e: &io::Error| Failure::Use(unwritable(&path, e));
        let mut file = OpenOptions::new().read(true).append(true).create(true).open(&path).map_err(|e| failed(&e))?;
        // Two at once would mix their rows.
        if file.try_lock().is_err() {
            return Err(Failure::Use(format!("error: another sweep is writing {}", path.display())));
        }
        let found = Found::read(&mut file, header.len(), first).map_err(|e| failed(&e))?;
        let mut journal = Self { path: path.clone(), file, counts: (found.done, found.failed) };
        if found.title.is_empty() {
            journal.file.set_len(0).map_err(|e| failed(&e))?;
            writeln!(journal.file, "{title}\n{}", header.join(",")).map_err(|e| failed(&e))?;
            return Ok((journal, 0));
        }
        if found.title != title {
            return Err(Failure::Use(format!(
                "error: {} holds the rows of another sweep that was interrupted\n  \
                 = help: finish that one by the command that began it, remove the file, or choose another --out",
                path.display()
            )));
        }
        if let Some(why) = found.wrong {
            return Err(Failure::Use(format!(
                "error: {} was changed since its sweep was interrupted: {why}\n  = help: remove the file, to begin again",
                path.display()
            )));
        }
        // A row that was cut off is computed again.
        journal.file.set_len(found.length).map_err(|e| failed(&e))?;
        Ok((journal, found.done + found.failed))
    }

    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// Designs that came to their end, and those that did not.
    pub(super) fn counts(&self) -> (usize, usize) {
        self.counts
    }

    pub(super) fn write(&mut self, lines: &[Line]) -> Result<(), Failure> {
        let mut writer = csv::Writer::from_writer(Vec::new());
        let written = lines.iter().try_for_each(|line| writer.write_record(&line.fields));
        let bytes = written
            .map_err(io::Error::other)
            .and_then(|()| writer.into_inner().map_err(|e| io::Error::other(e.to_string())));
        let written = bytes.and_then(|bytes| self.file.write_all(&bytes));
        written.map_err(|e| Failure::Run(unwritable(&self.path, &e)))?;
        let done = lines.iter().filter(|line| line.is_done).count();
        self.counts = (self.counts.0 + done, self.counts.1 + lines.len() - done);
        Ok(())
    }

    /// Makes the table out of it.
    pub(super) fn finish(self, out: &Path) -> Result<(), Failure> {
        let failed = |e: io::Error| Failure::Run(unwritable(out, &e));
        let part = beside(out, "part");
        let mut rows = BufReader::new(File::open(&self.path).map_err(failed)?);
        rows.read_line(&mut String::new()).map_err(failed)?;
        write_table(&mut rows, &part, ending(out)?).and_then(|_| std::fs::rename(&part, out)).map_err(failed)?;
        std::fs::remove_file(&self.path).map_err(failed)
    }
}

/// Rows that are read again, one design after the other.
struct Rows {
    columns: usize,
    /// The design whose row comes next; any, before the first.
    next: Option<usize>,
}

impl Rows {
    /// Whether the design of a row came to its end; or what is wrong with the row.
    fn check(&mut self, line: &str) -> Result<bool, String> {
        let mut record = csv::StringRecord::new();
        let mut reader = csv::ReaderBuilder::new().has_headers(false).flexible(true).from_reader(line.as_bytes());
        let is_read = reader.read_record(&mut record).map_err(|e| e.to_string())?;
        if !is_read || record.len() != self.columns {
            return Err(format!("it has {} fields instead of {}", record.len(), self.columns));
        }
        let design: usize = record[0].parse().map_err(|_| format!("`{}` is no number of a design", &record[0]))?;
        if self.next.is_some_and(|next| next != design) {
            return Err(format!("it is the row of design {design} instead of {}", self.next.unwrap_or(0)));
        }
        self.next = Some(design + 1);
        let status = record.iter().position(|field| field == "done" || field == "failed");
        let status = status.ok_or("it is neither `done` nor `failed`")?;
        // The reason, behind the status, is words.
        let numbers =
            record.iter().enumerate().filter(|(i, field)| ![status, status + 1].contains(i) && !field.is_empty());
        for (_, field) in numbers {
            if !field.parse::<f64>().is_ok_and(f64::is_finite) {
                return Err(format!("`{field}` is no finite number"));
            }
        }
        Ok(&record[status] == "done")
    }
}

/// What a table under way holds.
struct Found {
    title: String,
    done: usize,
    failed: usize,
    /// Up to the end of the last whole row.
    length: u64,
    /// What is wrong with a row.
    wrong: Option<String>,
}

impl Found {
    fn read(file: &mut File, columns: usize, first: usize) -> io::Result<Self> {
        file.seek(SeekFrom::Start(0))?;
        let mut reader = BufReader::new(file);
        let mut found = Self { title: String::new(), done: 0, failed: 0, length: 0, wrong: None };
        let mut rows = Rows { columns, next: Some(first) };
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

/// A file of another name in the same folder.
fn beside(out: &Path, what: &str) -> PathBuf {
    let mut name = out.file_name().unwrap_or_default().to_owned();
    name.push(format!(".{what}"));
    out.with_file_name(name)
}

/// Writes rows with their header as a table, and says how many there are.
fn write_table(rows: &mut impl Read, path: &Path, ending: Ending) -> io::Result<usize> {
    match ending {
        Ending::Csv => {
            let mut file = BufWriter::new(File::create(path)?);
            let mut counting = Counting { inner: rows, lines: 0 };
            io::copy(&mut counting, &mut file)?;
            file.flush()?;
            Ok(counting.lines.saturating_sub(1))
        }
        Ending::Parquet => parquet::write(rows, path, kind),
    }
}

struct Counting<'r, R> {
    inner: &'r mut R,
    lines: usize,
}

impl<R: Read> Read for Counting<'_, R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let count = self.inner.read(buffer)?;
        self.lines += buffer[..count].iter().filter(|&&byte| byte == b'\n').count();
        Ok(count)
    }
}

/// Whether tables hold one design after the other, from the first on, each row whole.
fn check(parts: &[PathBuf]) -> Result<(), Failure> {
    let mut next = 0;
    for path in parts {
        let failed = |why: String| {
            Failure::Use(format!(
                "error: {} does not continue the parts before it: {why}\n  \
                 = help: give all parts of one sweep, whole and in their order",
                path.display()
            ))
        };
        let file = File::open(path).map_err(|e| Failure::Use(format!("error: cannot read {}: {e}", path.display())))?;
        let mut reader = BufReader::new(file);
        let (mut line, mut rows) = (String::new(), Rows { columns: 0, next: Some(next) });
        for number in 1.. {
            line.clear();
            match reader.read_line(&mut line) {
                Ok(0) => break,
                Ok(_) if number == 1 => rows.columns = line.split(',').count(),
                Ok(_) if !line.ends_with('\n') => return Err(failed(format!("line {number} is cut off"))),
                Ok(_) => _ = rows.check(&line).map_err(|why| failed(format!("in line {number}, {why}")))?,
                // Not text; what it is instead is said when it is read as a table.
                Err(_) => break,
            }
            if number == 1 && !line.starts_with("design,") {
                break;
            }
        }
        next = rows.next.unwrap_or(next);
    }
    Ok(())
}

/// Joins tables in CSV to one, and says how many rows it has.
pub(super) fn join(parts: &[PathBuf], out: &Path) -> Result<usize, Failure> {
    check(parts)?;
    super::make_folder(out)?;
    let mut header: Option<String> = None;
    let mut readers: Vec<Box<dyn Read>> = Vec::new();
    for path in parts {
        let failed = |e: io::Error| Failure::Use(format!("error: cannot read {}: {e}", path.display()));
        let mut reader = BufReader::new(File::open(path).map_err(failed)?);
        let mut first = String::new();
        if reader.read_line(&mut first).is_err() || !first.starts_with("design,") {
            return Err(Failure::Use(format!(
                "error: {} is no table of a sweep in CSV\n  = help: let each part write a file that ends in `.csv`",
                path.display()
            )));
        }
        match &header {
            None => {
                readers.push(Box::new(io::Cursor::new(first.clone().into_bytes())));
                header = Some(first);
            }
            Some(header) if *header != first => {
                return Err(Failure::Use(format!(
                    "error: {} has other columns than {}",
                    path.display(),
                    parts[0].display()
                )));
            }
            Some(_) => {}
        }
        readers.push(Box::new(reader));
    }
    let mut rows = Chain { readers, place: 0 };
    let part = beside(out, "part");
    let written =
        write_table(&mut rows, &part, ending(out)?).and_then(|count| std::fs::rename(&part, out).map(|()| count));
    written.map_err(|e| Failure::Use(unwritable(out, &e)))
}

/// One after another.
struct Chain {
    readers: Vec<Box<dyn Read>>,
    place: usize,
}

impl Read for Chain {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        while let Some(reader) = self.readers.get_mut(self.place) {
            match reader.read(buffer)? {
                0 => self.place += 1,
                count => return Ok(count),
            }
        }
        Ok(0)
    }
}

/// What a column of a sweep holds.
fn kind(name: &str) -> parquet::Kind {
    match name {
        "design" | "steps" => parquet::Kind::Whole,
        "status" | "reason" => parquet::Kind::Text,
        _ => parquet::Kind::Number,
    }
}
