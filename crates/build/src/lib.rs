//! Generated modules of mechanisms for build scripts, and the symbolic engine that writes them.
//!
//! A build script needs three lines:
//!
//! ```ignore
//! fn main() {
//!     qrm_build::build(&["scene.toml"]);
//! }
//! ```
//!
//! The crate includes the result by `include!(concat!(env!("OUT_DIR"), "/scenes.rs"));`.
//!
//! The modules come from golden copies: generated code that is committed in a folder of the crate. If only numbers of a
//! scene have changed, they are replaced in its golden copy (module `values`). If formulae have changed, or there is no
//! golden copy, the program `qrm-engine` writes the module ([`engine`]).

pub mod engine;
mod golden_copy;
mod index;
mod modules;
mod values;

use std::env;
use std::path::{Path, PathBuf};

pub use golden_copy::GoldenCopy;
pub use modules::{Request, modules};

/// Writes the modules of scene files, whose paths are relative to the crate, into `OUT_DIR`, from where the crate
/// includes `scenes.rs`. Tells cargo when to run the script again, and prints warnings about scenes.
///
/// Golden copies in the folder `generated` of the crate make the symbolic engine unnecessary. If a scene has errors,
/// the build fails with its report.
pub fn build(scenes: &[&str]) {
    let paths: Vec<PathBuf> = scenes.iter().map(PathBuf::from).collect();
    report(out_folder().and_then(|out| {
        let request = Request { scenes: &paths, copies: Path::new("generated"), out: &out, is_compiled: &|_| true };
        modules(&request)
    }));
}

/// The output folder of a build script.
///
/// # Errors
/// The program is not run by cargo.
pub fn out_folder() -> Result<PathBuf, String> {
    env::var_os("OUT_DIR").map(PathBuf::from).ok_or_else(|| "OUT_DIR is not set: this is for build scripts".to_owned())
}

/// Reports the result of a build script: warnings, or the error with which the build fails.
pub fn report(result: Result<Vec<String>, String>) {
    print!("{}", logged(&result));
}

/// Messages for cargo, line by line. If the script itself failed, cargo would show them only after the command line and
/// all earlier output.
fn logged(result: &Result<Vec<String>, String>) -> String {
    let lines = |kind: &str, text: &str| -> String {
        text.lines().map(|line| format!("cargo::{kind}={}\n", line.strip_prefix("error: ").unwrap_or(line))).collect()
    };
    match result {
        Ok(warnings) => warnings.iter().map(|warning| lines("warning", warning)).collect(),
        Err(message) if message.trim().is_empty() => lines("error", "the build script failed"),
        Err(message) => lines("error", message),
    }
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
        assert_eq!(logged(&Err(report.to_owned())), expected);
    }
}
