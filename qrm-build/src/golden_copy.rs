//! A golden copy: a generated module that is committed.

use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use qrm_core::digest;

/// A generated module and its derivation.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct GoldenCopy {
    /// The module, in Rust.
    pub(crate) code: String,
    /// The derivation, in Markdown.
    pub(crate) derivation: String,
}

impl GoldenCopy {
    /// The copy of a module in a folder; `None` if there is none.
    ///
    /// # Errors
    /// It cannot be read, or is not what the generator wrote.
    pub(crate) fn read(folder: &Path, module: &str) -> Result<Option<Self>, String> {
        let [code, derivation] = paths(folder, module);
        let Some(own) = read(&code)? else { return Ok(None) };
        let copy = Self { code: own, derivation: read(&derivation)?.unwrap_or_default() };
        if !is_whole(&copy.code, &copy.derivation) {
            return Err(format!(
                "{} is not what the generator wrote: it, or {}, was edited or cut off\n  \
                 = help: put both back (`git checkout -- {}`), or delete them: the symbolic engine derives the scene then",
                code.display(),
                derivation.display(),
                folder.display(),
            ));
        }
        Ok(Some(copy))
    }

    /// The text of the scene that it was generated from; `None` if it is not a raw literal.
    pub(crate) fn source(&self) -> Option<&str> {
        let (start, end) = self.literal()?;
        Some(&self.code[start..end])
    }

    /// The place of that text.
    fn literal(&self) -> Option<(usize, usize)> {
        let before = self.code.find(SOURCE)? + SOURCE.len();
        let fence = self.code[before..].find('"')?;
        let start = before + fence + 1;
        let end = self.code[start..].find(&format!("\"{};", &self.code[before..before + fence]))?;
        Some((start, start + end))
    }

    /// The copy with another text of its scene.
    pub(crate) fn with_source(mut self, source: &str) -> Option<Self> {
        let (start, end) = self.literal()?;
        let fence = &self.code[self.code.find(SOURCE)? + SOURCE.len()..start - 1];
        if source.contains('\r') || source.contains(&format!("\"{fence}")) {
            return None;
        }
        self.code.replace_range(start..end, source);
        Some(self)
    }

    /// The parts of the module that an interpreter needs: names and operations.
    pub(crate) fn data(&self) -> Option<&str> {
        self.code.find(DESCRIPTION).map(|start| &self.code[start..])
    }

    /// The sizes of the mechanism and its type: `3, 2` and `QuickReturn`.
    pub(crate) fn mechanism(&self) -> Option<(&str, &str)> {
        let (_, rest) = self.code.split_once("\nimpl Generated<")?;
        let (sizes, rest) = rest.split_once("> for ")?;
        Some((sizes, rest.split_once(' ')?.0))
    }
}

/// The text before that of the scene.
const SOURCE: &str = "\npub const SOURCE: &str = r";
/// The first line of names and operations.
const DESCRIPTION: &str = "/// Names, units and meanings.\npub const DESCRIPTION";
/// The text before the checksum of a generated file.
const CHECKSUM: &str = "\n// Hash of this file and its derivation: ";

/// The files of a module.
pub(crate) fn paths(folder: &Path, module: &str) -> [PathBuf; 2] {
    ["rs", "md"].map(|extension| folder.join(format!("{module}.{extension}")))
}

/// The text of a file; `None` if there is none.
fn read(path: &Path) -> Result<Option<String>, String> {
    match fs::read_to_string(path) {
        Ok(text) => Ok(Some(text)),
        Err(e) if e.kind() == ErrorKind::NotFound => Ok(None),
        Err(e) => Err(format!("{} cannot be read: {e}", path.display())),
    }
}

/// A generated file with its last line, by which a file that was cut off or changed is known.
pub fn with_checksum(text: String, derivation: &str) -> String {
    let line = checksum_line(&text, derivation);
    text + line.as_str()
}

fn checksum_line(text: &str, derivation: &str) -> String {
    let bytes = text.bytes().chain([0]).chain(derivation.bytes());
    format!("{CHECKSUM}{:016x}\n", digest(bytes))
}

/// Whether a generated file and its derivation are whole.
fn is_whole(generated: &str, derivation: &str) -> bool {
    let is_own = |(text, _): (&str, &str)| generated[text.len()..] == checksum_line(text, derivation);
    generated.rsplit_once(CHECKSUM).is_some_and(is_own)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_that_was_cut_off_or_changed_is_not_whole() {
        let derivation = "# Derivation\n";
        let whole = with_checksum("// Generated\n\nfn step() {}\n".to_owned(), derivation);
        assert!(is_whole(&whole, derivation));
        assert!((0..whole.len()).all(|cut| !is_whole(&whole[..cut], derivation)));
        assert!((0..derivation.len()).all(|cut| !is_whole(&whole, &derivation[..cut])));
        assert!(!is_whole(&whole.replace("step", "stop"), derivation));
    }

    #[test]
    fn the_scene_is_found_and_replaced() {
        let code = "//\npub const SOURCE: &str = r#\"name = \"a\"\n\"#;\n".to_owned();
        let copy = GoldenCopy { code, derivation: String::new() };
        assert_eq!(copy.source(), Some("name = \"a\"\n"));
        let other = copy.clone().with_source("name = \"b\"\n").expect("a text");
        assert_eq!(other.source(), Some("name = \"b\"\n"));
        assert_eq!(copy.clone().with_source("doc = '\"#'"), None);
        assert_eq!(copy.with_source("a\r\n"), None);
    }
}
