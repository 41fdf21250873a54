//! The scenes of the tests. Two are compiled, one whose types the tests name and one whose lanes are on record; with
//! `QRM_SCENES=all` all are.

use std::path::{Path, PathBuf};

const SCENES: [&str; 13] = [
    "functions.toml",
    "driven.toml",
    "bead.toml",
    "loads.toml",
    "undefined.toml",
    "pulse.toml",
    "watt.toml",
    "stiff.toml",
    "weightless.toml",
    "redundant.toml",
    "arm.toml",
    "rubbing.toml",
    "names.toml",
];

fn main() {
    println!("cargo::rerun-if-env-changed=QRM_SCENES");
    let all = std::env::var_os("QRM_SCENES").is_some_and(|scenes| scenes == "all");
    let scenes = SCENES.map(PathBuf::from);
    qrm_build::report(qrm_build::out_folder().and_then(|out| {
        qrm_build::modules(&qrm_build::Request {
            scenes: &scenes,
            copies: Path::new("generated"),
            out: &out,
            is_compiled: &|name| all || ["functions", "rubbing"].contains(&name),
        })
    }));
}
