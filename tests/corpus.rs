//! Command lines that a fuzzer found, each of which takes another way through the command: exit statuses that fit, no
//! panic, and nothing in a file that is no number.

use std::path::Path;

use crate::common::qrm;

#[test]
#[ignore = "full tier: compiled"]
fn every_command_line_ends_well() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fuzz/corpus/command_line");
    let mut statuses = [0; 3];
    for entry in std::fs::read_dir(folder).expect("the corpus") {
        let bytes = std::fs::read(entry.expect("an entry").path()).expect("a file");
        let Ok(text) = String::from_utf8(bytes) else { continue };
        // No argument can hold a zero byte.
        let arguments: Vec<&str> = text.lines().filter(|argument| !argument.contains('\0')).collect();
        let out = tempfile::tempdir().expect("a temporary folder");
        let output = qrm(&arguments).arg("--out").arg(out.path()).output().expect("the command starts");
        let said = String::from_utf8_lossy(&output.stderr);
        let status = output.status.code().unwrap_or_else(|| panic!("{text}: {said}"));
        assert!((0..3).contains(&status) && !said.contains("panicked"), "{text}: {status}, {said}");
        assert!(status == 0 || !said.is_empty(), "{text}: status {status} without a word");
        statuses[status as usize] += 1;
        let rows = std::fs::read_to_string(out.path().join("trajectory.csv")).unwrap_or_default();
        let numbers = rows.split_once('\n').map_or("", |(_, rows)| rows);
        assert!(!numbers.contains("NaN") && !numbers.contains("inf"), "{text}: a row is not finite");
    }
    assert!(statuses.iter().all(|count| *count > 3), "{statuses:?}");
}
