//! Golden copies, that is, committed generated modules.

use std::fs;
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

use qrm_core::{NamedTape, digest};
use qrm_scene::files::write_atomic;

/// A generated module: its tape, derivation and text.
#[derive(Clone, Debug)]
pub struct GoldenCopy {
    /// The functions.
    pub tape: NamedTape,
    /// The derivation, in Markdown.
    pub derivation: String,
    /// The module in Rust, without the checksum.
    pub code: String,
}

impl GoldenCopy {
    /// Reads the copy of a module in a folder; `None` if there is none.
    ///
    /// # Errors
    /// The copy cannot be read, or was changed since its generation.
    pub(crate) fn read(folder: &Path, module: &str) -> Result<Option<Self>, String> {
        let [code, tape, derivation] = paths(folder, module);
        let Some(text) = read(&code)? else { return Ok(None) };
        let (bytes, text) = (read(&tape)?.unwrap_or_default(), String::from_utf8(text).unwrap_or_default());
        let derivation_text = String::from_utf8(read(&derivation)?.unwrap_or_default()).unwrap_or_default();
        let tape = NamedTape::from_bytes(&bytes).filter(|_| is_whole(&text, &bytes, &derivation_text));
        let Some(tape) = tape else {
            return Err(format!(
                "{} is not what the generator wrote: it, or {}, or their tape, was edited or cut off\n  \
                 = help: put them back (`git checkout -- {}`), or delete them: the symbolic engine derives the scene then",
                code.display(),
                derivation.display(),
                folder.display(),
            ));
        };
        let code = text.rsplit_once(CHECKSUM).map_or(&*text, |(code, _)| code).to_owned();
        Ok(Some(Self { tape, derivation: derivation_text, code }))
    }

    /// Removes the files of a module from a folder.
    ///
    /// # Errors
    /// A file cannot be removed.
    pub(crate) fn remove(folder: &Path, module: &str) -> Result<(), String> {
        for path in paths(folder, module) {
            match fs::remove_file(&path) {
                Err(e) if e.kind() != ErrorKind::NotFound => return Err(format!("{}: {e}", path.display())),
                _ => {}
            }
        }
        Ok(())
    }

    /// Writes the files of a module into a folder.
    ///
    /// # Errors
    /// The path of a file that cannot be written, and the reason.
    pub fn write(&self, folder: &Path, module: &str) -> Result<(), (String, io::Error)> {
        for (path, bytes) in self.files(folder, module) {
            write_atomic(&path, &bytes).map_err(|e| (path.display().to_string(), e))?;
        }
        Ok(())
    }

    /// The files of a module in a folder. The last one includes the others, and is written last to mark the module as
    /// complete.
    pub(crate) fn files(&self, folder: &Path, module: &str) -> [(PathBuf, Vec<u8>); 3] {
        let tape = self.tape.to_bytes();
        let code = self.code.clone() + &checksum_line(&self.code, &tape, &self.derivation);
        let [code_path, tape_path, derivation_path] = paths(folder, module);
        [(derivation_path, self.derivation.clone().into_bytes()), (tape_path, tape), (code_path, code.into_bytes())]
    }
}

/// The text before the checksum of a generated file.
const CHECKSUM: &str = "\n// Hash of this file, its tape and its derivation: ";

/// The files of a module: code, tape, derivation.
fn paths(folder: &Path, module: &str) -> [PathBuf; 3] {
    ["rs", "tape", "md"].map(|extension| folder.join(format!("{module}.{extension}")))
}

/// Reads a file; `None` if it does not exist.
fn read(path: &Path) -> Result<Option<Vec<u8>>, String> {
    match fs::read(path) {
        Ok(bytes) => Ok(Some(bytes)),
        Err(e) if e.kind() == ErrorKind::NotFound => Ok(None),
        Err(e) => Err(format!("{} cannot be read: {e}", path.display())),
    }
}

/// The last line of a generated file, which reveals truncated or changed files.
fn checksum_line(code: &str, tape: &[u8], derivation: &str) -> String {
    let bytes = code.bytes().chain([0]).chain(tape.iter().copied()).chain([0]).chain(derivation.bytes());
    format!("{CHECKSUM}{:016x}\n", digest(bytes))
}

/// Whether a generated file, its tape and its derivation are complete and unchanged.
fn is_whole(code: &str, tape: &[u8], derivation: &str) -> bool {
    let is_own = |(text, _): (&str, &str)| code[text.len()..] == checksum_line(text, tape, derivation);
    code.rsplit_once(CHECKSUM).is_some_and(is_own)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_that_was_cut_off_or_changed_is_not_whole() {
        let (derivation, tape) = ("# Derivation\n", [1, 2, 3]);
        let code = "// Generated\n\nfn step() {}\n";
        let whole = code.to_owned() + &checksum_line(code, &tape, derivation);
        assert!(is_whole(&whole, &tape, derivation));
        assert!((0..whole.len()).all(|cut| !is_whole(&whole[..cut], &tape, derivation)));
        assert!((0..derivation.len()).all(|cut| !is_whole(&whole, &tape, &derivation[..cut])));
        assert!(!is_whole(&whole.replace("step", "stop"), &tape, derivation));
        assert!(!is_whole(&whole, &[1, 2, 4], derivation));
    }
}
