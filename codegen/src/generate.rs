//! From scene files to module files: what a build script calls.

use std::path::{Path, PathBuf};
use std::{fs, io};

use crate::emit::{self, Module, module_name, struct_name};
use crate::engine::Waiting;
use crate::term::Equations;
use crate::verify::{self, Unverified};
use crate::{derivation, engine, header, names, tape};
use qrm_core::OwnedTape;
use qrm_scene::diagnostic::{Diagnostic, Report};
use qrm_scene::files;
use qrm_scene::resolve;
use qrm_scene::scene::Scene;
use qrm_scene::source::read_text;

/// Why no code was generated.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A file could not be written.
    #[error("{path}: {source}")]
    File {
        /// The file.
        path: String,
        /// What the system said.
        source: io::Error,
    },
    /// Scenes have mistakes.
    #[error("{}", .0.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n\n"))]
    Scenes(Vec<Report>),
    /// The engine could not be started.
    #[error(transparent)]
    Engine(engine::Error),
    /// A generated function was not found right.
    #[error(transparent)]
    Unverified(Unverified),
}

/// What was generated.
#[derive(Debug)]
pub struct Generated {
    /// The modules, in the order of the scenes.
    pub modules: Vec<GeneratedModule>,
    /// What looks like a mistake in a scene but is none.
    pub warnings: Vec<Report>,
}

/// A generated module.
#[derive(Debug)]
pub struct GeneratedModule {
    /// Its name, also that of its file.
    pub name: String,
    /// The struct in it that is the mechanism.
    pub mechanism: String,
    /// How many coordinates it has.
    pub coordinates: usize,
    /// How many constraints it has.
    pub constraints: usize,
}

/// Generates `directory/NAME.rs` for each scene file with its derivation, `NAME.md`, and `directory/scenes.rs`, which
/// includes them all. A module that is there already and was made from the same text by this same program is left
/// alone, and if all are, the engine is not started.
///
/// # Errors
/// Anything that keeps one of the files from being written; no file is ever half-written.
pub fn generate(scenes: &[PathBuf], directory: &Path) -> Result<Generated, Error> {
    let (read, warnings) = read_all(scenes)?;
    let file = |scene: &Scene| directory.join(format!("{}.rs", module_name(&scene.name)));
    let derivation = |scene: &Scene| file(scene).with_extension("md");
    let is_done = |r: &&Read| is_current(&file(&r.scene), &derivation(&r.scene), &r.source);
    let stale: Vec<&Read> = read.iter().filter(|r| !is_done(r)).collect();
    if !stale.is_empty() {
        for (read, equations) in stale.iter().zip(&equations(&stale, &|_| ())?) {
            let Read { scene, source, .. } = read;
            let (module, _) = code(read, equations, emit::module(scene, equations, source))?;
            // First: the module includes it, and is the mark of both.
            let markdown = derivation::markdown(scene, equations, source);
            write_whole(&derivation(scene), &markdown)?;
            write_whole(&file(scene), &header::with_checksum(module, &markdown))?;
        }
    }
    let modules = read.iter().map(|Read { scene, .. }| GeneratedModule {
        name: module_name(&scene.name),
        mechanism: struct_name(&scene.name),
        coordinates: scene.coordinates.len(),
        constraints: scene.constraints.len(),
    });
    let modules: Vec<GeneratedModule> = modules.collect();
    remove_others(directory, &modules)?;
    let index = directory.join("scenes.rs");
    let text = index_text(&modules);
    // A new time on an unchanged file would have everything compiled again.
    if fs::read_to_string(&index).ok().as_ref() != Some(&text) {
        write_whole(&index, &text)?;
    }
    Ok(Generated { modules, warnings })
}

/// A scene that was read.
pub(crate) struct Read {
    path: String,
    source: String,
    pub(crate) scene: Scene,
}

impl Read {
    /// The scene of this text; also an error if its name cannot be that of a module.
    pub(crate) fn new(path: &str, source: &str) -> Result<Self, Error> {
        let wrong = |report| Error::Scenes(vec![report]);
        let (scene, _) = resolve::read(path, source).map_err(wrong)?;
        let read = Self { path: path.to_owned(), source: source.to_owned(), scene };
        same_module(&read, &[]).map_or(Ok(read), |report| Err(wrong(report)))
    }
}

/// The equations of motion of scenes, by the engine.
pub(crate) fn equations(scenes: &[&Read], announce: &dyn Fn(Waiting)) -> Result<Vec<Equations>, Error> {
    let all: Vec<&Scene> = scenes.iter().map(|read| &read.scene).collect();
    engine::derive(&all, announce).map_err(|e| engine_error(e, scenes))
}

/// Reads all scenes; mistakes of all of them are reported together.
fn read_all(paths: &[PathBuf]) -> Result<(Vec<Read>, Vec<Report>), Error> {
    let mut read: Vec<Read> = Vec::new();
    let (mut wrong, mut warnings) = (Vec::new(), Vec::new());
    for path in paths {
        let name = path.display().to_string();
        let result = read_text(path).and_then(|source| {
            let (scene, report) = resolve::read(&name, &source)?;
            Ok((Read { path: name, source, scene }, report))
        });
        match result {
            Ok((scene, report)) => {
                wrong.extend(same_module(&scene, &read));
                warnings.extend(Some(report).filter(|r| !r.diagnostics.is_empty()));
                read.push(scene);
            }
            Err(report) => wrong.push(report),
        }
    }
    if wrong.is_empty() { Ok((read, warnings)) } else { Err(Error::Scenes(wrong)) }
}

/// Every scene becomes a module, so no two may have names that make the same one.
fn same_module(new: &Read, read: &[Read]) -> Option<Report> {
    let module = module_name(&new.scene.name);
    let other = read.iter().find(|r| module_name(&r.scene.name) == module);
    let title = match other {
        Some(other) => {
            format!("scenes `{}` and `{}` would both become module `{module}`", other.scene.name, new.scene.name)
        }
        None => names::refusal(&new.scene.name)?,
    };
    let label = other.map_or_else(String::new, |other| format!("the other one is in {}", other.path));
    let finding = Diagnostic::error(title, new.scene.name_span.clone(), label).help("give the scene another name");
    Some(Report::new(&new.path, &new.source, vec![finding]))
}

/// Where the engine gave up, in the shape of other mistakes.
fn engine_error(error: engine::Error, scenes: &[&Read]) -> Error {
    let title = error.to_string();
    let (scene, finding) = match error {
        engine::Error::Formula { scene, span, reason } => {
            let help = "look for a division by something that is always zero, and for numbers beyond 1e308";
            (scene, Diagnostic::error("a formula cannot be differentiated", span, reason).help(help))
        }
        engine::Error::Circular { scene, span, output } => {
            let help = "name a force across the direction in which it slides, or give the joint `friction`";
            let label = format!("`{output}` contains this friction");
            (scene, Diagnostic::error(title, span, label).help(help))
        }
        error @ engine::Error::NotStarted(_) => return Error::Engine(error),
    };
    let Read { path, source, .. } = scenes[scene];
    Error::Scenes(vec![Report::new(path, source, vec![finding])])
}

/// Removes modules of scenes that are gone.
fn remove_others(directory: &Path, modules: &[GeneratedModule]) -> Result<(), Error> {
    let failed = |source| Error::File { path: directory.display().to_string(), source };
    for entry in fs::read_dir(directory).map_err(failed)? {
        let path = entry.map_err(failed)?.path();
        let name = path.file_stem().unwrap_or_default().to_string_lossy();
        let is_ours = name == "scenes" || modules.iter().any(|m| m.name == name);
        if path.extension().is_some_and(|e| e == "rs" || e == "md") && !is_ours {
            fs::remove_file(&path).map_err(failed)?;
        }
    }
    Ok(())
}

/// The file that includes the modules and lists their mechanisms.
fn index_text(modules: &[GeneratedModule]) -> String {
    let mut text = String::from("// Generated by qrm-codegen. Do not edit.\n");
    for module in modules {
        let (name, mechanism) = (&module.name, &module.mechanism);
        text += &format!(
            "\n/// The scene of [`{name}::{mechanism}`].\n#[allow(non_snake_case)]\npub mod {name} {{\n    include!(\"{name}.rs\");\n}}\n"
        );
    }
    text += "\nqrm_core::models! {\n";
    for GeneratedModule { name, mechanism, coordinates, constraints } in modules {
        text += &format!("    {name}::{mechanism}, {coordinates}, {constraints};\n");
    }
    text + "}\n"
}

/// The text of a scene's module, without its last line, and its tape, once they are found right.
pub(crate) fn code(
    Read { path, source, scene }: &Read,
    equations: &Equations,
    module: Module,
) -> Result<(String, OwnedTape), Error> {
    verify::verify(scene, equations, &module.file, &module.tape).map_err(Error::Unverified)?;
    // The printer drops comments of this kind, so the header is joined afterwards.
    let header = header::header(path, scene, equations, &module, &header::hash(source));
    let text = format!("{header}\n{}{}", spaced(&prettyplease::unparse(&module.file)), tape::text(&module.tape.tape()));
    Ok((text, module.tape))
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

/// Whether a module and its derivation hold what this program would write. A file older than the program is made again.
fn is_current(path: &Path, derivation: &Path, source: &str) -> bool {
    let modified = |path: &Path| fs::metadata(path).and_then(|m| m.modified()).ok();
    let newer = match (modified(path), std::env::current_exe().ok().and_then(|exe| modified(&exe))) {
        (Some(file), Some(program)) => file > program,
        _ => false,
    };
    let derived = || fs::read_to_string(derivation).unwrap_or_default();
    newer && fs::read_to_string(path).is_ok_and(|text| header::is_current(&text, &derived(), source))
}

/// Writes a generated file.
fn write_whole(path: &Path, text: &str) -> Result<(), Error> {
    let failed = |source| Error::File { path: path.display().to_string(), source };
    files::write_whole(path, text.as_bytes()).map_err(failed)
}
