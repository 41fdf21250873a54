//! Tells the tests whether all scenes are compiled.

fn main() {
    println!("cargo::rustc-check-cfg=cfg(all_scenes)");
    println!("cargo::rerun-if-env-changed=QRM_SCENES");
    if std::env::var_os("QRM_SCENES").is_some_and(|scenes| scenes == "all") {
        println!("cargo::rustc-cfg=all_scenes");
    }
}
