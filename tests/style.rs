//! The prose of documentation, help and messages: phrases that are not plain English do not return.

use std::fs;
use std::path::{Path, PathBuf};

use crate::common::qrm;

/// Phrases with a plain equivalent, such as `again` for `anew`, and `next to` for `beside`.
const PHRASES: [&str; 13] = [
    " anew",
    " beside",
    "by itself",
    "by themselves",
    "of which",
    "so many",
    "comes to",
    "became true",
    "goes on",
    "is told",
    "as far as the steps tell",
    "of a good C program's",
    "judged by a run",
];

/// Asserts that a text has none of the phrases.
fn is_plain(place: &str, text: &str) {
    for (number, line) in text.lines().enumerate() {
        for phrase in PHRASES {
            assert!(!line.contains(phrase), "{place}:{}: `{phrase}` in: {line}", number + 1);
        }
    }
}

/// The files below a folder with an ending.
fn files(folder: &Path, ending: &str) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            found.extend(files(&path, ending));
        } else if path.extension().is_some_and(|own| own == ending) {
            found.push(path);
        }
    }
    found
}

#[test]
fn documents_are_in_plain_english() {
    let top = Path::new(env!("CARGO_MANIFEST_DIR"));
    let decisions = top.join("docs/decisions");
    let mut pages = files(&top.join("docs"), "md");
    // Decisions record what was thought at their time.
    pages.retain(|page| !page.starts_with(&decisions));
    pages.push(top.join("README.md"));
    for page in pages {
        is_plain(&page.display().to_string(), &fs::read_to_string(&page).expect("a page"));
    }
}

#[test]
fn messages_are_in_plain_english() {
    let top = Path::new(env!("CARGO_MANIFEST_DIR"));
    for folder in ["src", "qrm-sim/src", "crates/scene/src", "crates/cli/src", "crates/build/src", "crates/fmu/src"] {
        for file in files(&top.join(folder), "rs") {
            let text = fs::read_to_string(&file).expect("a source");
            // Texts of messages stand between quotes; names of variables and comments do not.
            let messages: Vec<&str> = text.lines().map(quoted).collect();
            is_plain(&file.display().to_string(), &messages.join("\n"));
        }
    }
    for report in files(&top.join("crates/scene/tests/errors"), "txt") {
        is_plain(&report.display().to_string(), &fs::read_to_string(&report).expect("a report"));
    }
}

/// The part of a line from its first quote on, unless it is a comment.
fn quoted(line: &str) -> &str {
    if line.trim_start().starts_with("//") {
        return "";
    }
    line.find('"').map_or("", |begin| &line[begin..])
}

#[test]
fn help_is_in_plain_english() {
    let help = |arguments: &[&str]| {
        let output = qrm(arguments).output().expect("the command starts");
        String::from_utf8_lossy(&output.stdout).into_owned()
    };
    let all = help(&["--help"]);
    is_plain("qrm --help", &all);
    let commands = all.lines().skip_while(|line| !line.starts_with("Commands:")).skip(1);
    let names: Vec<&str> =
        commands.take_while(|line| line.starts_with("  ")).filter_map(|line| line.split_whitespace().next()).collect();
    assert!(names.len() > 15, "{names:?}");
    for name in names {
        is_plain(&format!("qrm {name} --help"), &help(&[name, "--help"]));
    }
}
