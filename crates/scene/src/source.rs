//! The text of a scene file.

use std::io::ErrorKind;
use std::path::Path;

use crate::diagnostic::{Diagnostic, Report};
use crate::files::read_at_most;

/// The largest size of a scene file. Files of this size with errors in every line are reported within two seconds.
const MAX_BYTES: u64 = 1_000_000;

/// Reads a scene file, which must be UTF-8.
///
/// # Errors
/// A report that the file cannot be read, or the location at which it stops being UTF-8.
pub fn read_text(path: &Path) -> Result<String, Report> {
    let name = path.display().to_string();
    let bytes = read_at_most(path, MAX_BYTES).map_err(|e| {
        let (reason, help) = match e.kind() {
            ErrorKind::NotFound => ("there is no such file".to_owned(), "check its name and its folder".to_owned()),
            _ => (e.to_string(), format!("a scene is a file of at most {MAX_BYTES} bytes that can be read")),
        };
        Report::new(&name, "", vec![Diagnostic::whole_file(format!("the scene cannot be read: {reason}")).help(help)])
    })?;
    String::from_utf8(bytes).map_err(|e| {
        let place = e.utf8_error().valid_up_to();
        let text = String::from_utf8_lossy(e.as_bytes()).into_owned();
        let span = place..place + char::REPLACEMENT_CHARACTER.len_utf8();
        let finding = Diagnostic::error("the scene is not UTF-8 text", span, "this byte begins no character");
        Report::new(&name, text, vec![finding.help("save the file as UTF-8")])
    })
}
