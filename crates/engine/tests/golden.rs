//! The committed copies of generated modules equal the output of the engine, byte for byte.

use std::fs;
use std::path::Path;
use std::process::Command;

const REFRESH: &str =
    "QRM_REFRESH=1 cargo test --release --manifest-path crates/engine/Cargo.toml --target-dir target/engine golden";

#[test]
fn modules_of_built_in_scenes_are_current() {
    check(".", "scenes/", "qrm-model/golden");
}

#[test]
fn modules_of_the_scenes_for_tests_are_current() {
    check("tests/functions", "", "generated");
}

#[test]
fn the_module_of_the_example_is_current() {
    check("examples/wiper", "", "generated");
}

/// Compares the copies in a folder of a clone with the output for its scenes.
fn check(folder: &str, scenes: &str, copies: &str) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(folder);
    let copies = folder.join(copies);
    let files = names(&folder.join(scenes), "toml").into_iter().filter(|name| name != "Cargo.toml");
    let out = std::env::temp_dir().join(format!(
        "qrm-golden-{}-{}",
        std::process::id(),
        scenes.len() + copies.as_os_str().len()
    ));
    let mut engine = Command::new(env!("CARGO_BIN_EXE_qrm-engine"));
    engine.current_dir(&folder).arg("generate").arg(&out).args(files.map(|name| format!("{scenes}{name}")));
    let output = engine.output().expect("the engine starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let modules = |folder: &Path| [names(folder, "rs"), names(folder, "tape"), names(folder, "md")].concat();
    if std::env::var_os("QRM_REFRESH").is_some() {
        fs::create_dir_all(&copies).expect("the folder can be made");
        modules(&copies).iter().for_each(|old| fs::remove_file(copies.join(old)).expect("an old copy can be removed"));
        for new in modules(&out) {
            fs::copy(out.join(&new), copies.join(&new)).expect("a new copy can be made");
        }
    }
    assert_eq!(
        modules(&copies),
        modules(&out),
        "other modules are generated now; refresh the copy with\n    {REFRESH}\n"
    );
    for name in modules(&copies) {
        let same = fs::read(copies.join(&name)).expect("a copy") == fs::read(out.join(&name)).expect("a module");
        assert!(
            same,
            "{name} is not what is generated now; look at the difference and refresh the copy with\n    {REFRESH}\n"
        );
    }
    fs::remove_dir_all(&out).expect("the folder can be removed");
}

/// The names of the files in a folder with this extension.
fn names(folder: &Path, extension: &str) -> Vec<String> {
    let entries = fs::read_dir(folder).into_iter().flatten().map(|entry| entry.expect("an entry").path());
    let files = entries.filter(|path| path.extension().is_some_and(|e| e == extension));
    let mut names: Vec<String> =
        files.filter_map(|path| Some(path.file_name()?.to_string_lossy().into_owned())).collect();
    names.sort();
    names
}
