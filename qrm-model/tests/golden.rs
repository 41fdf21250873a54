//! The golden copy is what the generator writes, byte for byte.
#![cfg(feature = "generate")]

use std::fs;
use std::path::Path;

const REFRESH: &str = "QRM_REFRESH=1 cargo test --release --package qrm-model --test golden";

#[test]
fn golden_copy_is_current() {
    let golden = Path::new(env!("CARGO_MANIFEST_DIR")).join("golden");
    let generated = Path::new(env!("QRM_GENERATED"));
    let names = |folder: &Path| -> Vec<String> {
        let entries = fs::read_dir(folder).expect("the folder exists");
        let names = entries.map(|e| e.expect("an entry").file_name().to_string_lossy().into_owned());
        let mut names: Vec<String> = names.filter(|name| name.ends_with(".rs") || name.ends_with(".md")).collect();
        names.sort();
        names
    };
    if std::env::var_os("QRM_REFRESH").is_some() {
        fs::create_dir_all(&golden).expect("the folder can be made");
        for old in names(&golden) {
            fs::remove_file(golden.join(old)).expect("an old copy can be removed");
        }
        for new in names(generated) {
            let text = fs::read(generated.join(&new)).expect("a module");
            fs::write(golden.join(&new), text).expect("a new copy can be made");
        }
    }
    assert_eq!(
        names(&golden),
        names(generated),
        "other modules are generated now; refresh the copy with\n    {REFRESH}\n"
    );
    for name in names(&golden) {
        let same = fs::read(golden.join(&name)).expect("a copy") == fs::read(generated.join(&name)).expect("a module");
        assert!(
            same,
            "golden/{name} is not what is generated now; look at the difference and refresh the copy with\n    {REFRESH}\n"
        );
    }
}
