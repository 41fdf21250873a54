fn main() {
    qrm_build::build(&["wiper.toml"]);
}
