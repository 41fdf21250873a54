//! What a crate of its own needs to have its scenes generated.

fn main() {
    let scenes = ["functions.toml", "driven.toml", "bead.toml", "loads.toml"];
    for scene in scenes {
        println!("cargo::rerun-if-changed={scene}");
    }
    #[cfg(feature = "generate")]
    if let Err(e) = qrm_codegen::generate::generate(
        &scenes.map(Into::into),
        std::env::var("OUT_DIR").expect("run by cargo").as_ref(),
    ) {
        eprintln!("{e}");
        std::process::exit(1);
    }
}
