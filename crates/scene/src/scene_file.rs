//! Scene files.

use std::path::{Path, PathBuf};

use crate::diagnostic::{Diagnostic, Report};
use crate::resolve;
use crate::scene::Scene;
use crate::source::read_text;

/// A scene with its text and its path.
pub struct SceneFile {
    /// The path of the file.
    pub path: PathBuf,
    /// The text of the scene.
    pub source: String,
    /// The scene that the text describes.
    pub scene: Scene,
    /// The warnings about the scene.
    pub warnings: Report,
}

impl SceneFile {
    /// Reads a scene from a text.
    ///
    /// # Errors
    /// A report of all errors of the scene.
    pub fn new(path: &Path, source: String) -> Result<Self, Report> {
        let (scene, warnings) = resolve::read(&path.display().to_string(), &source)?;
        Ok(Self { path: path.to_owned(), source, scene, warnings })
    }

    /// Reads files, and checks each of them together with the files before it.
    ///
    /// # Errors
    /// The reports of all files that have errors or cannot be read.
    pub fn read_all(
        paths: &[PathBuf],
        check: impl Fn(&Self, &[Self]) -> Option<Report>,
    ) -> Result<Vec<Self>, Vec<Report>> {
        let (mut files, mut wrong) = (Vec::new(), Vec::new());
        for path in paths {
            match read_text(path).and_then(|source| Self::new(path, source)) {
                Ok(file) => {
                    wrong.extend(check(&file, &files));
                    files.push(file);
                }
                Err(report) => wrong.push(report),
            }
        }
        if wrong.is_empty() { Ok(files) } else { Err(wrong) }
    }

    /// Creates a report of findings about this file.
    pub fn report(&self, findings: Vec<Diagnostic>) -> Report {
        Report::new(self.path.display().to_string(), &self.source, findings)
    }
}
