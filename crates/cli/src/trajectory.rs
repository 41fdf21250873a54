//! `trajectory.csv`: every row in full precision. Rows are written during the run; the file gets its name at the end.

use std::fs::File;
use std::io::{self, BufRead, BufReader, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use qrm_scene::files::{open_locked, temporary_path};
use qrm_sim::columns::Column;

/// The longest time for which rows are buffered.
const FLUSH_INTERVAL: Duration = Duration::from_millis(200);

/// An unfinished trajectory, in a temporary file next to its final one.
pub(crate) struct Trajectory {
    path: PathBuf,
    writer: csv::Writer<BufWriter<File>>,
    flushed: Instant,
    text: Vec<u8>,
    rows: u64,
}

impl Trajectory {
    pub(crate) fn create(path: &Path, columns: &[Column]) -> io::Result<Self> {
        let file = open_locked(&temporary_path(path))?;
        // A killed run left its rows.
        if file.metadata()?.is_file() {
            file.set_len(0)?;
        }
        let file = BufWriter::with_capacity(1 << 16, file);
        let mut writer = csv::WriterBuilder::new().buffer_capacity(1 << 12).from_writer(file);
        writer.write_record(columns.iter().map(|column| &column.name))?;
        writer.flush()?;
        Ok(Self { path: path.to_owned(), writer, flushed: Instant::now(), text: Vec::new(), rows: 0 })
    }

    pub(crate) fn row(&mut self, numbers: impl Iterator<Item = f64>) -> io::Result<()> {
        for number in numbers {
            self.text.clear();
            // The Debug format is the shortest decimal that reads back exactly.
            write!(self.text, "{number:?}")?;
            self.writer.write_field(&self.text)?;
        }
        self.writer.write_record(None::<&[u8]>)?;
        self.rows += 1;
        Ok(())
    }

    /// Writes buffered rows to disk from time to time.
    pub(crate) fn flush_if_due(&mut self) -> io::Result<()> {
        if self.flushed.elapsed() >= FLUSH_INTERVAL {
            self.flush()?;
        }
        Ok(())
    }

    /// Moves the rows to their final file, and returns their number; after a failed write, the number of complete rows.
    pub(crate) fn finish(mut self, failed: bool) -> io::Result<u64> {
        let path = temporary_path(&self.path);
        if failed {
            // Buffered rows could not be written either, and must not be written when the writer is dropped.
            std::mem::forget(self.writer);
            if !std::fs::metadata(&path)?.is_file() {
                return Ok(0);
            }
            self.rows = cut(&path)?;
        } else {
            self.writer.flush()?;
            self.writer.get_ref().get_ref().sync_all()?;
        }
        std::fs::rename(path, &self.path)?;
        Ok(self.rows)
    }

    /// Writes all buffered rows to disk.
    pub(crate) fn flush(&mut self) -> io::Result<()> {
        self.flushed = Instant::now();
        self.writer.flush()
    }
}

/// Removes an incomplete row after a failed write, and counts the complete ones.
fn cut(path: &Path) -> io::Result<u64> {
    let mut file = BufReader::new(File::options().read(true).write(true).open(path)?);
    let (mut lines, mut whole, mut line) = (0, 0, Vec::new());
    loop {
        line.clear();
        let length = file.read_until(b'\n', &mut line)?;
        if line.last() != Some(&b'\n') {
            break;
        }
        lines += 1;
        whole += length as u64;
    }
    file.into_inner().set_len(whole)?;
    Ok(u64::saturating_sub(lines, 1))
}
