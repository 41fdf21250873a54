//! The build script of `qrm-model`: it writes a module for each scene in `scenes`.
//!
//! The functions come from the golden copies. If only numbers of a scene have changed, they are replaced in the copy;
//! if its formulae have changed, the symbolic engine derives the scene again.

use std::path::{Path, PathBuf};

/// The scenes whose functions are compiled. Each takes 2 to 12 s of processor time. The other scenes are interpreted,
/// with bitwise identical results, unless `QRM_SCENES` names them or their formulae differ from the golden copy.
const COMPILED: [&str; 1] = ["quick-return"];

fn main() {
    println!("cargo::rerun-if-changed=../scenes");
    // Messages show paths relative to the root of the workspace, as the user types them.
    let there = std::env::set_current_dir("..").map_err(|e| e.to_string());
    qrm_build::report(there.and_then(|()| modules()));
}

/// Writes the modules; returns warnings.
fn modules() -> Result<Vec<String>, String> {
    let (scenes, all) = scenes()?;
    let out = qrm_build::out_folder()?.join("scenes");
    qrm_build::modules(&qrm_build::Request {
        scenes: &scenes,
        copies: Path::new("qrm-model/golden"),
        out: &out,
        is_compiled: &|name| all || COMPILED.contains(&name),
    })
}

/// The scene files in alphabetical order, and whether all are compiled. The files are those of `scenes`, or those named
/// by `QRM_SCENES`, which may also lie in `scenes/large`. `QRM_SCENES=all` compiles all of `scenes`.
fn scenes() -> Result<(Vec<PathBuf>, bool), String> {
    println!("cargo::rerun-if-env-changed=QRM_SCENES");
    let scenes = files("scenes")?;
    let asked = std::env::var("QRM_SCENES").unwrap_or_default();
    if asked.is_empty() || asked == "all" {
        return Ok((scenes, asked == "all"));
    }
    let mut scenes = [scenes, files("scenes/large")?].concat();
    let asked: Vec<&str> = asked.split(',').map(str::trim).filter(|name| !name.is_empty()).collect();
    let name = |path: &PathBuf| path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    if let Some(unknown) = asked.iter().find(|asked| !scenes.iter().any(|path| name(path) == **asked)) {
        let known: Vec<String> = scenes.iter().map(name).collect();
        return Err(format!(
            "error: QRM_SCENES asks for `{unknown}`, but there is no scenes/{unknown}.toml\n  \
             = help: scenes: {}; or `all`",
            known.join(", ")
        ));
    }
    scenes.retain(|path| asked.contains(&name(path).as_str()));
    Ok((scenes, true))
}

/// The scene files of a folder.
fn files(folder: &str) -> Result<Vec<PathBuf>, String> {
    let entries = std::fs::read_dir(folder).map_err(|e| format!("cannot read the folder `{folder}`: {e}"))?;
    let mut scenes = Vec::new();
    for entry in entries {
        let path = entry.map_err(|e| format!("cannot read the folder `{folder}`: {e}"))?.path();
        if path.extension().is_some_and(|e| e == "toml") {
            scenes.push(path);
        }
    }
    scenes.sort();
    Ok(scenes)
}
