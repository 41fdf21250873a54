//! What a crate of its own needs to have its scenes generated.

fn main() {
    qrm_build::build(&[
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
    ]);
}
