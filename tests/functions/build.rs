//! What a crate of its own needs to have its scene generated.

fn main() {
    println!("cargo::rerun-if-changed=functions.toml");
    #[cfg(feature = "generate")]
    if let Err(e) = qrm_codegen::generate::generate(
        &["functions.toml".into()],
        std::env::var("OUT_DIR").expect("run by cargo").as_ref(),
    ) {
        eprintln!("{e}");
        std::process::exit(1);
    }
}
