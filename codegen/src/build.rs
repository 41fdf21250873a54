//! What the build script of a crate with scenes of its own calls.

use std::env;
use std::fs;
use std::path::{Path, PathBuf};

use crate::generate::{Generated, generate};

/// Generates the code of scene files, named from the folder of the crate, into `OUT_DIR`, from where the crate includes
/// `scenes.rs`; tells cargo when to do so again, and what looks like a mistake in a scene.
///
/// A crate that has a folder `generated` keeps a copy there, to be compiled without the symbolic engine. The
/// environment variable `QRM_REFRESH=1` has the copy written; a warning tells when it is not current.
///
/// If a scene is wrong, the build fails with its report.
pub fn build(scenes: &[&str]) {
    if let Err(message) = try_build(scenes) {
        print!("{}", logged(&message));
    }
}

/// A message as errors for cargo, line by line. A script that fails itself would have it shown below the command and all
/// that was printed before.
fn logged(message: &str) -> String {
    let of = |line: &str| format!("cargo::error={}\n", line.strip_prefix("error: ").unwrap_or(line));
    message.lines().map(of).collect()
}

fn try_build(scenes: &[&str]) -> Result<(), String> {
    let out = env::var_os("OUT_DIR").map(PathBuf::from).ok_or("OUT_DIR is not set: this is for build scripts")?;
    for scene in scenes {
        println!("cargo::rerun-if-changed={scene}");
    }
    let paths: Vec<PathBuf> = scenes.iter().map(PathBuf::from).collect();
    let generated = generate(&paths, &out).map_err(|e| e.to_string())?;
    for warning in &generated.warnings {
        for line in warning.to_string().lines() {
            println!("cargo::warning={line}");
        }
    }
    println!("cargo::rerun-if-env-changed=QRM_REFRESH");
    let copy = Path::new("generated");
    if !copy.is_dir() {
        return Ok(());
    }
    println!("cargo::rerun-if-changed=generated");
    if env::var_os("QRM_REFRESH").is_some() {
        return refresh(&generated, &out, copy);
    }
    if files(&generated).iter().any(|file| fs::read(out.join(file)).ok() != fs::read(copy.join(file)).ok()) {
        println!(
            "cargo::warning=the copy in `generated` is not what the scenes give now: QRM_REFRESH=1 cargo build renews it"
        );
    }
    Ok(())
}

fn refresh(generated: &Generated, out: &Path, copy: &Path) -> Result<(), String> {
    for file in files(generated) {
        fs::copy(out.join(&file), copy.join(&file)).map_err(|e| format!("{}: {e}", copy.join(&file).display()))?;
    }
    Ok(())
}

/// What was generated, without folders.
fn files(generated: &Generated) -> Vec<String> {
    let of_module = |name: &str| ["rs", "md"].map(|extension| format!("{name}.{extension}"));
    let modules = generated.modules.iter().flat_map(|module| of_module(&module.name));
    std::iter::once("scenes.rs".to_owned()).chain(modules).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_line_of_a_report_is_an_error_for_cargo() {
        let report =
            "error: unknown name `psy`\n  --> a.toml:1:2\n   |\n   = help: did you mean `psi`?\n\nerror: no `x`";
        let expected = "cargo::error=unknown name `psy`\ncargo::error=  --> a.toml:1:2\ncargo::error=   |\n\
                        cargo::error=   = help: did you mean `psi`?\ncargo::error=\ncargo::error=no `x`\n";
        assert_eq!(logged(report), expected);
    }
}
