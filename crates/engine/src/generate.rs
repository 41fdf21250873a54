//! Generates module files from scene files.

use std::path::{Path, PathBuf};
use std::{fs, io};

use crate::Waiting;
use qrm_build::GoldenCopy;
use qrm_codegen::term::Equations;
use qrm_codegen::verify::{self, Unverified};
use qrm_codegen::{derivation, functions, names};
use qrm_core::NamedTape;
use qrm_language::{Code, rust};
use qrm_scene::diagnostic::{Diagnostic, Report};
use qrm_scene::document::Document;
use qrm_scene::names::module_name;
use qrm_scene::scene::{EliminationForm, Scene};
use qrm_scene::scene_file::SceneFile;

/// The reason why no code was generated.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A file could not be written.
    #[error("{path}: {source}")]
    File {
        /// The file.
        path: String,
        /// The error of the system.
        source: io::Error,
    },
    /// Scenes have errors.
    #[error("{}", .0.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n\n"))]
    Scenes(Vec<Report>),
    /// The engine could not be started.
    #[error(transparent)]
    Engine(crate::Error),
    /// A generated function could not be verified.
    #[error(transparent)]
    Unverified(Unverified),
}

/// Writes `directory/NAME.rs` for each scene file, with its tape, `NAME.tape`, and its derivation, `NAME.md`. Call it
/// at most once per process.
///
/// # Errors
/// The reason why a file cannot be written; no file is ever partially written.
pub fn generate(scenes: &[PathBuf], directory: &Path) -> Result<(), Error> {
    let files = SceneFile::read_all(scenes, |file, _| refused_name(file)).map_err(Error::Scenes)?;
    let all: Vec<&SceneFile> = files.iter().collect();
    fs::create_dir_all(directory).map_err(|source| Error::File { path: directory.display().to_string(), source })?;
    for (scene_file, equations) in all.iter().zip(&equations(&all, &|_| ())?) {
        let SceneFile { scene, source, path, .. } = scene_file;
        let tape = tape(scene_file, equations)?;
        verify::verify(scene, equations, &tape, &tape.placed()).map_err(Error::Unverified)?;
        let path = path.display().to_string();
        let code = rust::text(&Code { path: &path, scene, source, tape: &tape });
        rust::check(&tape, &code).map_err(|e| Error::Unverified(Unverified::Wrong(e)))?;
        let golden = GoldenCopy { tape, derivation: derivation::markdown(scene, equations, source), code };
        golden.write(directory, &module_name(&scene.name)).map_err(|(path, source)| Error::File { path, source })?;
    }
    Ok(())
}

/// Reads the scene of a text; also returns an error if its name cannot be that of a module.
pub(crate) fn read(path: &Path, source: String) -> Result<SceneFile, Error> {
    let wrong = |report| Error::Scenes(vec![report]);
    let file = SceneFile::new(path, source).map_err(wrong)?;
    refused_name(&file).map_or(Ok(file), |report| Err(wrong(report)))
}

/// Derives the equations of motion of scenes with the engine.
pub(crate) fn equations(scenes: &[&SceneFile], announce: &dyn Fn(Waiting)) -> Result<Vec<Equations>, Error> {
    let all: Vec<&Scene> = scenes.iter().map(|file| &file.scene).collect();
    crate::derive(&all, announce).map_err(|e| engine_error(e, scenes))
}

/// Creates the functions of a scene.
pub(crate) fn tape(file: &SceneFile, equations: &Equations) -> Result<NamedTape, Error> {
    let scene = &file.scene;
    functions::tape(scene, equations).map_err(|impossible| {
        let reason = match impossible.0 {
            EliminationForm::Sparse if !scene.normal_forces().is_empty() => "friction by normal forces",
            _ if scene.coordinates.is_empty() => "the scene has no coordinates",
            EliminationForm::RangeSpace if scene.constraints.is_empty() => "the scene has no constraints",
            _ => "a coordinate has no inertia, or no motion changes a constraint",
        };
        let asked = Document::parse(&file.source).0.run.elimination;
        let span = asked.map_or(0..0, |(_, span)| span);
        let help = "take it out, or write `\"null-space\"`";
        Error::Scenes(vec![file.report(vec![Diagnostic::error(impossible.to_string(), span, reason).help(help)])])
    })
}

/// Reports a name that cannot be that of a module.
fn refused_name(file: &SceneFile) -> Option<Report> {
    let finding = Diagnostic::error(names::refusal(&file.scene.name)?, file.scene.name_span.clone(), "");
    Some(file.report(vec![finding.help("give the scene another name")]))
}

/// The error of the engine as a diagnostic with its location.
fn engine_error(error: crate::Error, scenes: &[&SceneFile]) -> Error {
    let title = error.to_string();
    let (scene, finding) = match error {
        crate::Error::Formula { scene, span, reason } => {
            let help = "look for a division by something that is always zero, and for numbers beyond 1e308";
            (scene, Diagnostic::error("a formula cannot be differentiated", span, reason).help(help))
        }
        crate::Error::Circular { scene, span, output } => {
            let help = "name a force across the direction in which it slides, or give the joint `friction`";
            let label = format!("`{output}` contains this friction");
            (scene, Diagnostic::error(title, span, label).help(help))
        }
        error @ crate::Error::NotStarted(_) => return Error::Engine(error),
    };
    Error::Scenes(vec![scenes[scene].report(vec![finding])])
}
