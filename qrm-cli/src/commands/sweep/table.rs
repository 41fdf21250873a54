//! The tables of sweeps: written in the format that their name asks for, and joined.

use std::fs::File;
use std::io::{self, BufRead, BufReader, Read, Write};
use std::path::{Path, PathBuf};

use qrm_scene::files::write_whole_with;

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
    /// The format that the name of a file asks for.
    pub(super) fn of(path: &Path) -> Result<Self, Error> {
        let name = path.display();
        if path.is_dir() || path.as_os_str().to_string_lossy().ends_with(std::path::is_separator) {
            return Err(Error::usage(format!("`{name}` is a folder")).help("name the file that the table is written \
             to"));
        }
        match path.extension().and_then(|e| e.to_str()) {
            Some(ending) if ending.eq_ignore_ascii_case("csv") => Ok(Self::Csv),
            Some(ending) if ending.eq_ignore_ascii_case("parquet") => Ok(Self::Parquet),
            _ => Err(Error::usage(format!("`{name}` ends in neither `.csv` nor `.parquet`"))
                .help("the ending says how the table is written")),
        }
    }

    /// Writes rows with their header as a table, and returns how many there are.
    pub(super) fn write(self, rows: &mut impl Read, path: &Path) -> io::Result<usize> {
        write_whole_with(path, |file| match self {
            Self::Csv => copy_lines(rows, file).map(|lines| lines.saturating_sub(1)),
            Self::Parquet => parquet::write(rows, file, parquet_kind),
        })
    }
}

/// Copies text, and returns how many lines it has.
fn copy_lines(from: &mut impl Read, to: &mut impl Write) -> io::Result<usize> {
    let (mut buffer, mut lines) = (vec![0; 1 << 16], 0);
    loop {
        match from.read(&mut buffer)? {
            0 => return Ok(lines),
            count => {
                to.write_all(&buffer[..count])?;
                lines += buffer[..count].iter().filter(|&&byte| byte == b'\n').count();
            }
        }
    }
}

/// The check of rows that are read again, one design after the other.
pub(super) struct RowReader {
    pub(super) columns: usize,
    /// The design whose row comes next; any, before the first.
    pub(super) next: Option<usize>,
}

impl RowReader {
    /// Whether the design of a row came to its end; or what is wrong with the row.
    pub(super) fn check(&mut self, line: &str) -> Result<bool, String> {
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
        // The reason, behind the status, is text.
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

/// An error if tables do not hold one design after the other, from the first on, each row whole.
fn check(parts: &[PathBuf]) -> Result<(), Error> {
    let mut next = 0;
    for path in parts {
        let failed = |why: String| {
            Error::usage(format!("{} does not continue the parts before it: {why}", path.display()))
                .help("give all parts of one sweep, whole and in their order")
        };
        let file = File::open(path).map_err(|e| Error::unreadable(path, &e))?;
        let mut reader = BufReader::new(file);
        let (mut line, mut rows) = (String::new(), RowReader { columns: 0, next: Some(next) });
        for number in 1.. {
            line.clear();
            match reader.read_line(&mut line) {
                Ok(0) => break,
                Ok(_) if number == 1 => rows.columns = line.split(',').count(),
                Ok(_) if !line.ends_with('\n') => return Err(failed(format!("line {number} is cut off"))),
                Ok(_) => _ = rows.check(&line).map_err(|why| failed(format!("in line {number}, {why}")))?,
                // Not text; reading it as a table fails with a message.
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

/// Joins tables in CSV to one, and returns how many rows it has.
pub(crate) fn join(parts: &[PathBuf], out: &Path) -> Result<usize, Error> {
    let format = Format::of(out)?;
    check(parts)?;
    let mut header: Option<String> = None;
    let mut readers: Vec<Box<dyn Read>> = Vec::new();
    for path in parts {
        let mut reader = BufReader::new(File::open(path).map_err(|e| Error::unreadable(path, &e))?);
        let mut first = String::new();
        if reader.read_line(&mut first).is_err() || !first.starts_with("design,") {
            return Err(Error::usage(format!("{} is no table of a sweep in CSV", path.display()))
                .help("let each part write a file that ends in `.csv`"));
        }
        if !first.ends_with('\n') {
            return Err(Error::usage(format!("{} ends in its first line", path.display()))
                .help("it was cut off: run this part again"));
        }
        match &header {
            None => {
                readers.push(Box::new(io::Cursor::new(first.clone().into_bytes())));
                header = Some(first);
            }
            Some(header) if *header != first => {
                let (path, first) = (path.display(), parts[0].display());
                return Err(Error::usage(format!("{path} has other columns than {first}")));
            }
            Some(_) => {}
        }
        readers.push(Box::new(reader));
    }
    let mut rows = Chain { readers, place: 0 };
    format.write(&mut rows, out).map_err(|e| Error::unwritable(out, &e))
}

/// Readers one after another.
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
