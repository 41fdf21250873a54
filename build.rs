//! The build script of `qrm-model`: scenes to Rust, or, without the feature `generate`, a check of the golden copy.

use std::path::{Path, PathBuf};

fn main() {
    println!("cargo::rerun-if-changed=../scenes");
    // Messages name files as the user knows them, from the top of the workspace.
    let scenes = std::env::set_current_dir("..").map_err(|e| e.to_string()).and_then(|()| scenes());
    if let Err(message) = scenes.and_then(|scenes| work(&scenes)) {
        // A script that fails itself would have its message shown below the command and all that was printed before.
        for line in message.lines() {
            println!("cargo::error={}", line.strip_prefix("error: ").unwrap_or(line));
        }
    }
}

/// The scene files, in the order of their names: all of `scenes`, or those that `QRM_SCENES` names, which may lie in
/// `scenes/large` too.
fn scenes() -> Result<Vec<PathBuf>, String> {
    println!("cargo::rerun-if-env-changed=QRM_SCENES");
    let scenes = files("scenes")?;
    let Ok(asked) = std::env::var("QRM_SCENES") else { return Ok(scenes) };
    let mut scenes = [scenes, files("scenes/large")?].concat();
    let asked: Vec<&str> = asked.split(',').map(str::trim).filter(|name| !name.is_empty()).collect();
    let name = |path: &PathBuf| path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    if let Some(unknown) = asked.iter().find(|asked| !scenes.iter().any(|path| name(path) == **asked)) {
        let known: Vec<String> = scenes.iter().map(name).collect();
        return Err(format!(
            "error: QRM_SCENES asks for `{unknown}`, but there is no scenes/{unknown}.toml\n  = help: scenes: {}",
            known.join(", ")
        ));
    }
    scenes.retain(|path| asked.contains(&name(path).as_str()));
    Ok(scenes)
}

/// The scenes of a folder.
fn files(folder: &str) -> Result<Vec<PathBuf>, String> {
    let entries = std::fs::read_dir(folder).map_err(|e| format!("cannot read the folder `{folder}`: {e}"))?;
    let mut scenes = Vec::new();
    for entry in entries {
        let path = entry.map_err(|e| format!("cannot read the folder `{folder}`: {e}"))?.path();
        if path.extension().is_some_and(|e| e == "toml") {
            println!("cargo::rerun-if-changed=../{}", path.display());
            scenes.push(path);
        }
    }
    scenes.sort();
    Ok(scenes)
}

/// The module that belongs to a file.
fn module_of(path: &Path) -> String {
    path.file_stem().unwrap_or_default().to_string_lossy().to_lowercase().replace('-', "_")
}

#[cfg(feature = "generate")]
fn work(scenes: &[PathBuf]) -> Result<(), String> {
    let out = std::env::var("OUT_DIR").map_err(|_| "OUT_DIR is not set: this program is run by cargo")?;
    let out = Path::new(&out).join("scenes");
    std::fs::create_dir_all(&out).map_err(|e| format!("{}: {e}", out.display()))?;
    // For the test that compares what was generated with the golden copy.
    println!("cargo::rustc-env=QRM_GENERATED={}", out.display());
    let generated = qrm_codegen::generate::generate(scenes, &out).map_err(|e| e.to_string())?;
    for (path, module) in scenes.iter().zip(&generated.modules) {
        if module_of(path) != module.name {
            return Err(format!(
                "error: the scene in {} has another name than its file\n  = help: give both the same name: the golden copy \
                 and messages go by it",
                path.display()
            ));
        }
    }
    for report in generated.warnings {
        for line in report.to_string().lines() {
            println!("cargo::warning={line}");
        }
    }
    Ok(())
}

/// Nothing is generated, so the golden copy must have been made from the very scenes that are there.
#[cfg(not(feature = "generate"))]
fn work(scenes: &[PathBuf]) -> Result<(), String> {
    for entry in std::fs::read_dir("qrm-model/golden").map_err(|e| format!("qrm-model/golden: {e}"))? {
        let path = entry.map_err(|e| format!("qrm-model/golden: {e}"))?.path();
        let module = module_of(&path);
        let is_asked = std::env::var_os("QRM_SCENES").is_some();
        if module != "scenes" && !is_asked && !scenes.iter().any(|scene| module_of(scene) == module) {
            return Err(format!(
                "{} has no scene any more, and this build has no symbolic engine.\n\
                 Build with the default features, or put the scene back.",
                path.display()
            ));
        }
    }
    for path in scenes {
        let scene = std::fs::read_to_string(path).map_err(|e| format!("{}: {e}", path.display()))?;
        let module = module_of(path);
        let golden = format!("qrm-model/golden/{module}.rs");
        println!("cargo::rerun-if-changed=../{golden}");
        // The scene stands in its module, as a raw string literal.
        let literal = format!("\"{scene}\"#");
        if path.starts_with("scenes/large") {
            return Err(format!(
                "{} has no golden copy, and this build has no symbolic engine.\nBuild with the default features.",
                path.display()
            ));
        }
        if !std::fs::read_to_string(&golden).is_ok_and(|golden| golden.contains(&literal)) {
            return Err(format!(
                "{} is not the scene that {golden} was generated from, and this build has no symbolic engine.\n\
                 Build with the default features, or put the scene back as it was.",
                path.display()
            ));
        }
    }
    let modules: Vec<String> = scenes.iter().map(|path| module_of(path)).collect();
    index(&modules)
}

/// Includes the modules of the golden copy that are asked for: its own list without the others.
#[cfg(not(feature = "generate"))]
fn index(modules: &[String]) -> Result<(), String> {
    let whole = std::fs::read_to_string("qrm-model/golden/scenes.rs")
        .map_err(|e| format!("qrm-model/golden/scenes.rs: {e}"))?;
    println!("cargo::rerun-if-changed=../qrm-model/golden/scenes.rs");
    let golden = std::env::current_dir().map_err(|e| e.to_string())?.join("qrm-model/golden");
    let is_of_other = |text: &str, before: &str, after: &str| {
        text.split_once(before)
            .and_then(|(_, rest)| rest.split_once(after))
            .is_some_and(|(name, _)| !modules.iter().any(|m| m == name))
    };
    let mut text = String::new();
    for block in whole.split_inclusive("\n}\n") {
        if is_of_other(block, "pub mod ", " {") {
            continue;
        }
        for line in block.lines().filter(|line| !is_of_other(line, "    ", "::")) {
            let line = line.replace("include!(\"", &format!("include!(\"{}/", golden.display()));
            text += &format!("{line}\n");
        }
    }
    let out = std::env::var("OUT_DIR").map_err(|_| "OUT_DIR is not set: this program is run by cargo")?;
    let out = Path::new(&out).join("scenes");
    std::fs::create_dir_all(&out).map_err(|e| format!("{}: {e}", out.display()))?;
    std::fs::write(out.join("scenes.rs"), text).map_err(|e| format!("{}: {e}", out.display()))
}
