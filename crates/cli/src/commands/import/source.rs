//! The text of a model, and errors at places in it.

use std::ops::Range;
use std::path::Path;

use qrm_scene::diagnostic::{Diagnostic, Report};
use qrm_scene::files::read_at_most;

use crate::error::Error;

/// The text of a model.
pub(super) struct Source {
    pub(super) path: String,
    pub(super) text: String,
}

/// The largest size of a model. Models that hold results have some megabytes.
const MAX_BYTES: u64 = 32_000_000;

/// The longest line that an error shows.
const LONGEST_LINE: usize = 400;

impl Source {
    /// Reads a file, which must be UTF-8.
    pub(super) fn read(path: &Path) -> Result<Self, Error> {
        if path.is_dir() {
            let title = format!("{} is a folder", path.display());
            return Err(Error::usage(title).help("choose the file of a model"));
        }
        let bytes = read_at_most(path, MAX_BYTES).map_err(|e| {
            Error::unreadable(path, &e).help(format!("a model is a plain file of at most {MAX_BYTES} bytes"))
        })?;
        let name = path.display().to_string();
        if bytes.starts_with(&[0xFF, 0xFE]) || bytes.starts_with(&[0xFE, 0xFF]) {
            return Err(Error::usage(format!("{name} is UTF-16 text")).help("save the file as UTF-8"));
        }
        let text = String::from_utf8(bytes).map_err(|e| {
            let line = e.as_bytes()[..e.utf8_error().valid_up_to()].iter().filter(|byte| **byte == b'\n').count() + 1;
            Error::usage(format!("{name} is not UTF-8 text: line {line} has a byte that begins no character"))
                .help("save the model as text in UTF-8")
        })?;
        let text = text.strip_prefix('\u{feff}').map_or(text.clone(), str::to_owned);
        if text.trim().is_empty() {
            return Err(Error::usage(format!("{name} is empty")).help("choose the file of a model"));
        }
        Ok(Self { path: name, text })
    }

    /// Makes an error at a place of the text.
    pub(super) fn error(
        &self,
        title: impl Into<String>,
        span: Range<usize>,
        label: &str,
        help: impl Into<String>,
    ) -> Error {
        let finding = |span| Diagnostic::error(title.into(), span, label).help(help);
        // A report shows its lines whole, however long they are, and looks at all of them.
        let end = self.text.len();
        let start = self.floor(span.start.min(end));
        let begin = self.text[..start].rfind('\n').map_or(0, |at| at + 1);
        let stop = self.text[start..].find('\n').map_or(end, |at| start + at);
        if stop - begin <= LONGEST_LINE && end <= 1_000_000 {
            let span = start..self.ceil(span.end.clamp(start, end));
            return Report::new(&self.path, &self.text, vec![finding(span)]).into();
        }
        let line = self.text[..start].matches('\n').count();
        let [from, to] = [self.floor(start.saturating_sub(100).max(begin)), self.floor((start + 100).min(stop))];
        let shown = "\n".repeat(line) + &self.text[from..to];
        let span = line + start - from..line + self.ceil(span.end.clamp(start, to)) - from;
        Report::new(&self.path, shown, vec![finding(span)]).into()
    }

    /// Makes an error of the whole model.
    pub(super) fn whole(&self, title: &str, help: impl Into<String>) -> Error {
        Error::usage(format!("{}: {title}", self.path)).help(help)
    }

    fn floor(&self, at: usize) -> usize {
        (0..=at).rev().find(|at| self.text.is_char_boundary(*at)).unwrap_or(0)
    }

    fn ceil(&self, at: usize) -> usize {
        (at..=self.text.len()).find(|at| self.text.is_char_boundary(*at)).unwrap_or(self.text.len())
    }
}
