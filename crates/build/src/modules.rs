//! Creates the modules of scene files for a crate.

use std::fs;
use std::path::{Path, PathBuf};

use qrm_scene::diagnostic::{Diagnostic, Report};
use qrm_scene::files::write_atomic;
use qrm_scene::names::module_name;
use qrm_scene::resolve;
use qrm_scene::scene_file::SceneFile;

use crate::golden_copy::GoldenCopy;
use crate::index::{self, Entry};
use crate::{engine, values};

/// The scenes of a build script and the folders of its modules.
pub struct Request<'a> {
    /// The scene files.
    pub scenes: &'a [PathBuf],
    /// The folder of the golden copies.
    pub copies: &'a Path,
    /// The output folder for the modules and for `scenes.rs`, which includes them.
    pub out: &'a Path,
    /// Whether the scene with this name is compiled instead of interpreted. Scenes that differ from their golden copies
    /// in more than numbers are always compiled.
    pub is_compiled: &'a dyn Fn(&str) -> bool,
}

/// Writes `out/NAME.rs` with its tape and derivation for each scene, and `out/scenes.rs`, which includes all modules;
/// tells cargo when to run the script again. Returns warnings.
///
/// If `QRM_GENERATE` is set in the environment, no golden copy is used: the symbolic engine writes every module.
///
/// # Errors
/// A scene has errors, a golden copy was edited by hand, there is no engine, or a file cannot be written.
pub fn modules(request: &Request) -> Result<Vec<String>, String> {
    let Request { scenes, copies, out, is_compiled } = *request;
    println!("cargo::rerun-if-env-changed=QRM_GENERATE");
    [copies].into_iter().chain(scenes.iter().map(PathBuf::as_path)).for_each(watch);
    let files = SceneFile::read_all(scenes, same_module).map_err(|wrong| texts(wrong.iter()).join("\n\n"))?;
    let mut warnings = texts(files.iter().map(|file| &file.warnings).filter(|report| !report.diagnostics.is_empty()));
    let generates = std::env::var("QRM_GENERATE").is_ok_and(|value| !["", "0"].contains(&&*value));
    let mut entries = Vec::new();
    let mut missing = Vec::new();
    for file in &files {
        let name = module_name(&file.scene.name);
        let copy = current(copies, &name, file)?;
        let is_compiled = copy.is_none() || is_compiled(&file.scene.name);
        let copy = copy.filter(|_| !generates);
        if copy.is_none() {
            missing.push(&*file.path);
        }
        entries.push((name, copy, is_compiled, file));
    }
    fs::create_dir_all(out).map_err(|e| format!("{}: {e}", out.display()))?;
    if !missing.is_empty() {
        // A module of an earlier build must not remain if the engine fails to write a new one.
        for (name, ..) in entries.iter().filter(|(_, copy, ..)| copy.is_none()) {
            GoldenCopy::remove(out, name)?;
        }
        warnings.extend(engine::generate(&missing, out)?);
    }
    let entry = |(name, copy, is_compiled, file): (String, Option<GoldenCopy>, bool, _)| {
        let written = || format!("the symbolic engine has not written {name}.rs");
        let copy = match copy {
            Some(copy) => copy,
            None => GoldenCopy::read(out, &name)?.filter(|own| is_of(own, file)).ok_or_else(written)?,
        };
        Ok(Entry { name, copy, is_compiled, file })
    };
    let entries: Vec<Entry> = entries.into_iter().map(entry).collect::<Result<_, String>>()?;
    write(&entries, out)?;
    Ok(warnings)
}

/// Tells cargo to run the script again when a file or folder changes.
fn watch(path: &Path) {
    let path = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    println!("cargo::rerun-if-changed={}", path.display());
}

/// Reports as text.
fn texts<'a>(reports: impl Iterator<Item = &'a Report>) -> Vec<String> {
    reports.map(ToString::to_string).collect()
}

/// Reports a scene whose module has the same name as an earlier one.
fn same_module(new: &SceneFile, files: &[SceneFile]) -> Option<Report> {
    let module = module_name(&new.scene.name);
    let other = files.iter().find(|file| module_name(&file.scene.name) == module)?;
    let title = format!("scenes `{}` and `{}` would both become module `{module}`", other.scene.name, new.scene.name);
    let label = format!("the other one is in {}", other.path.display());
    let finding = Diagnostic::error(title, new.scene.name_span.clone(), label).help("give the scene another name");
    Some(new.report(vec![finding]))
}

/// The golden copy of a scene, updated to the scene's numbers; `None` if its formulae differ.
fn current(copies: &Path, module: &str, file: &SceneFile) -> Result<Option<GoldenCopy>, String> {
    let Some(copy) = GoldenCopy::read(copies, module)? else { return Ok(None) };
    let Some(source) = source(&copy.code) else { return Ok(None) };
    if source == file.source {
        return Ok(Some(copy));
    }
    // The copy may be from a version whose scenes are no longer valid.
    let Ok((scene, _)) = resolve::read(module, source) else { return Ok(None) };
    Ok(values::with_values(&copy, (&scene, source), file))
}

/// Whether a module was generated from the text of a scene.
fn is_of(copy: &GoldenCopy, file: &SceneFile) -> bool {
    // A text that is not a raw literal has another form in the module, and is not compared.
    source(&copy.code).is_none_or(|source| source == file.source)
}

/// The text of the scene from which a module was generated; `None` if it is not a raw literal.
fn source(code: &str) -> Option<&str> {
    const SOURCE: &str = "\npub const SOURCE: &str = r";
    let rest = &code[code.find(SOURCE)? + SOURCE.len()..];
    let (fence, rest) = rest.split_at(rest.find('"')?);
    Some(&rest[1..rest.find(&format!("\"{fence};"))?])
}

/// Writes the modules and their list, and removes those of deleted scenes. Unchanged files are not rewritten, since a
/// new time stamp would recompile everything.
fn write(entries: &[Entry], out: &Path) -> Result<(), String> {
    let mut files = vec![(out.join("scenes.rs"), index::text(entries).into_bytes())];
    for entry in entries {
        files.extend(entry.copy.files(out, &entry.name));
        if !entry.is_compiled {
            files.push((out.join(entry.module_file()), entry.description().into_bytes()));
        }
    }
    for (path, bytes) in &files {
        if fs::read(path).ok().as_ref() != Some(bytes) {
            write_atomic(path, bytes).map_err(|e| format!("{}: {e}", path.display()))?;
        }
    }
    let failed = |e| format!("{}: {e}", out.display());
    for old in fs::read_dir(out).map_err(failed)? {
        let path = old.map_err(failed)?.path();
        let is_module =
            path.extension().is_some_and(|extension| ["rs", "tape", "md"].iter().any(|own| extension == *own));
        if is_module && !files.iter().any(|(file, _)| *file == path) {
            fs::remove_file(&path).map_err(failed)?;
        }
    }
    Ok(())
}
