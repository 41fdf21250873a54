fn main() {
    #[cfg(feature = "generate")]
    qrm_codegen::build::build(&["wiper.toml"]);
}
