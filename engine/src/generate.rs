//! From scene files to module files.

use std::path::{Path, PathBuf};
use std::{fs, io};

use crate::Waiting;
use qrm_build::with_checksum;
use qrm_codegen::tape::{self, Tape};
use qrm_codegen::term::Equations;
use qrm_codegen::verify::{self, Unverified};
use qrm_codegen::{derivation, functions, header, names, rust};
use qrm_core::OwnedTape;
use qrm_scene::diagnostic::{Diagnostic, Report};
use qrm_scene::files;
use qrm_scene::names::module_name;
use qrm_scene::scene::Scene;
use qrm_scene::scene_file::SceneFile;

/// Why no code was generated.
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
    /// Scenes have mistakes.
    #[error("{}", .0.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n\n"))]
    Scenes(Vec<Report>),
    /// The engine could not be started.
    #[error(transparent)]
    Engine(crate::Error),
    /// A generated function was not found right.
    #[error(transparent)]
    Unverified(Unverified),
}

/// Writes `directory/NAME.rs` for each scene file, with its derivation, `NAME.md`. At most one call per process.
///
/// # Errors
/// Anything that keeps one of the files from being written; no file is ever half-written.
pub fn generate(scenes: &[PathBuf], directory: &Path) -> Result<(), Error> {
    let files = SceneFile::read_all(scenes, |file, _| refused_name(file)).map_err(Error::Scenes)?;
    let all: Vec<&SceneFile> = files.iter().collect();
    fs::create_dir_all(directory).map_err(|source| Error::File { path: directory.display().to_string(), source })?;
    for (scene_file, equations) in all.iter().zip(&equations(&all, &|_| ())?) {
        let SceneFile { scene, source, .. } = scene_file;
        let tape = functions::tape(scene, equations);
        let module = code(scene_file, equations, &tape, &tape::placed(scene, &tape))?;
        let file = directory.join(format!("{}.rs", module_name(&scene.name)));
        let markdown = derivation::markdown(scene, equations, source);
        // First: the module includes it, and is the mark of both.
        write_whole(&file.with_extension("md"), &markdown)?;
        write_whole(&file, &with_checksum(module, &markdown))?;
    }
    Ok(())
}

/// The scene of a text; also an error if its name cannot be that of a module.
pub(crate) fn read(path: &Path, source: String) -> Result<SceneFile, Error> {
    let wrong = |report| Error::Scenes(vec![report]);
    let file = SceneFile::new(path, source).map_err(wrong)?;
    refused_name(&file).map_or(Ok(file), |report| Err(wrong(report)))
}

/// The equations of motion of scenes, by the engine.
pub(crate) fn equations(scenes: &[&SceneFile], announce: &dyn Fn(Waiting)) -> Result<Vec<Equations>, Error> {
    let all: Vec<&Scene> = scenes.iter().map(|file| &file.scene).collect();
    crate::derive(&all, announce).map_err(|e| engine_error(e, scenes))
}

/// A name that cannot be that of a module.
fn refused_name(file: &SceneFile) -> Option<Report> {
    let finding = Diagnostic::error(names::refusal(&file.scene.name)?, file.scene.name_span.clone(), "");
    Some(file.report(vec![finding.help("give the scene another name")]))
}

/// The place where the engine gave up, as a diagnostic.
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

/// The text of a scene's module, without its last line, once its functions are found right.
pub(crate) fn code(
    SceneFile { path, source, scene, .. }: &SceneFile,
    equations: &Equations,
    tape: &Tape,
    placed: &OwnedTape,
) -> Result<String, Error> {
    verify::verify(scene, equations, tape, placed).map_err(Error::Unverified)?;
    let file = rust::module(scene, tape, source);
    rust::check(tape, &file).map_err(|e| Error::Unverified(Unverified::Wrong(e)))?;
    // The printer drops comments of this kind, so the header is joined afterwards.
    let header = header::header(&path.display().to_string(), scene, equations, tape, &header::hash(source));
    Ok(format!("{header}\n{}{}", spaced(&prettyplease::unparse(&file)), tape::text(&placed.tape())))
}

/// Sets a blank line between items and between methods, and makes comments of the documentation of statements.
fn spaced(text: &str) -> String {
    let mut spaced = String::new();
    let mut lines = text.lines().peekable();
    // The scene stands at the end, in a literal whose lines must stay as they are.
    let mut in_literal = false;
    while let Some(line) = lines.next() {
        let is_before_statement = lines.peek().is_some_and(|next| next.trim_start().starts_with("let "));
        match line.split_once("/// ") {
            Some((indent, comment)) if is_before_statement && !in_literal => {
                spaced += &format!("\n{indent}// {comment}");
            }
            _ => spaced += line,
        }
        spaced.push('\n');
        in_literal |= line.starts_with("pub const SOURCE");
        let ends_item = ["}", "};", "    }"].contains(&line) || line.starts_with("    const ");
        let next_is_item = lines.peek().is_some_and(|next| !next.is_empty() && !next.trim_start().starts_with('}'));
        if !in_literal && ends_item && next_is_item {
            spaced.push('\n');
        }
    }
    spaced
}

/// Writes a generated file.
fn write_whole(path: &Path, text: &str) -> Result<(), Error> {
    let failed = |source| Error::File { path: path.display().to_string(), source };
    files::write_whole(path, text.as_bytes()).map_err(failed)
}
