//! The book: its pages are there, its commands work, and every key of a scene has the report that it gives when it is
//! wrong.

use std::fs;
use std::path::{Path, PathBuf};

use crate::common::{qrm, split};

/// The pages of the book, with their names.
fn pages() -> Vec<(String, String)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs");
    let mut files: Vec<PathBuf> = Vec::new();
    for folder in [folder.clone(), folder.join("decisions")] {
        files.extend(fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").path()));
    }
    files.retain(|path| path.extension().is_some_and(|ending| ending == "md"));
    files.sort();
    let name = |path: &PathBuf| path.strip_prefix(&folder).expect("inside").display().to_string();
    files.iter().map(|path| (name(path), fs::read_to_string(path).expect("a page"))).collect()
}

#[test]
fn every_page_is_in_the_table_of_contents() {
    let pages = pages();
    let contents = &pages.iter().find(|(name, _)| name == "SUMMARY.md").expect("a table of contents").1;
    for (name, _) in pages.iter().filter(|(name, _)| name != "SUMMARY.md") {
        assert!(contents.contains(&format!("({name})")), "{name}");
    }
    assert_eq!(contents.matches(".md)").count(), pages.len() - 1, "a page that is not there");
}

/// Places and tests of promises, a file and a function each, are there.
#[test]
fn promises_are_kept_where_they_say() {
    let top = Path::new(env!("CARGO_MANIFEST_DIR"));
    let page = fs::read_to_string(top.join("docs/guarantees.md")).expect("the page");
    let places: Vec<_> = page.split('`').skip(1).step_by(2).filter_map(|code| code.split_once("::")).collect();
    for (file, name) in &places {
        let source = fs::read_to_string(top.join(file)).unwrap_or_else(|e| panic!("{file}: {e}"));
        let begins = |words: &str| source.match_indices(words).any(|(i, _)| !continues(&source[i + words.len()..]));
        let kinds = ["fn", "def", "struct"];
        assert!(kinds.iter().any(|kind| begins(&format!("{kind} {name}"))), "{file} has no `{name}`");
    }
    assert!(places.len() > 100, "{} places", places.len());
}

/// Whether a text begins in the middle of a name.
fn continues(rest: &str) -> bool {
    rest.starts_with(|c: char| c.is_alphanumeric() || c == '_')
}

#[test]
fn what_is_included_is_there() {
    let mut count = 0;
    for (name, text) in pages() {
        let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs").join(&name);
        for rest in text.split("{{#include ").skip(1) {
            let file = rest.split(['}', ':']).next().expect("a name");
            assert!(page.with_file_name(file).is_file(), "{name} includes {file}");
            count += 1;
        }
    }
    assert!(count > 100, "{count} files");
}

/// Commands that the tests cannot run by themselves stand in `.ci/run` or `.ci/groups`, word for word.
#[test]
#[ignore = "full tier: commands"]
fn the_commands_shown_do_what_they_should() {
    let ci = concat!(include_str!("../.ci/run"), include_str!("../.ci/groups"));
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (mut run, mut elsewhere) = (0, 0);
    for (name, text) in pages() {
        for line in text.lines().filter_map(|line| line.strip_prefix("    ")) {
            if let Some(command) = line.strip_prefix("cargo run --release -- ") {
                let arguments = split(command);
                let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
                let output = qrm(&arguments).current_dir(folder.path()).output().expect("the command starts");
                assert!(output.status.success(), "{name}: {line}: {}", String::from_utf8_lossy(&output.stderr));
                run += 1;
            } else if is_command(line) {
                assert!(ci.lines().any(|step| step.trim() == line.trim()), "{name}: nothing runs `{}`", line.trim());
                elsewhere += 1;
            }
        }
    }
    assert!(run >= 20 && elsewhere >= 8, "{run} commands here, {elsewhere} in CI");
}

fn is_command(line: &str) -> bool {
    let line = line.trim_start();
    ["cargo ", "python3 ", "examples/", "docs/", "QRM_", "sbatch ", "qrm "].iter().any(|start| line.starts_with(start))
}

/// Keys that sections can have, as the messages of the reader list them.
#[test]
fn every_key_has_the_error_that_it_gives() {
    let errors = Path::new(env!("CARGO_MANIFEST_DIR")).join("crates/scene/tests/errors");
    let page = &pages().into_iter().find(|(name, _)| name == "scene-errors.md").expect("the page").1;
    let mut reports = String::new();
    for rest in page.split("{{#include ../crates/scene/tests/errors/").skip(1) {
        reports += &fs::read_to_string(errors.join(rest.split('}').next().expect("a name"))).expect("a report");
    }
    let keys: Vec<&str> = KEYS.split_whitespace().collect();
    for key in keys {
        let is_named = |quote: &str| reports.contains(&format!("{quote}{key}{quote}"));
        let is_shown = reports.lines().any(|line| line.contains(" | ") && line.contains(key));
        assert!(is_named("`") || is_shown, "no report shows `{key}`");
    }
}

const KEYS: &str = "name doc coordinates parameters tables links joints points bodies constraints loads initial \
    outputs drawing reference extreme run unit value runtime x y mass com angle inertia residual force torque at on \
    gravity along between spring rest damper potential friction slip given solve rate second_rate power reaction link \
    block pivot guide path actuator cam belt radii crossed internal profile t accuracy values set end_time step until \
    max_time stiff revolute weld rod length bar direction joint norm free_body gear rack ratio triangle sides moment \
    drive shaking_force shaking_moment inverse mu normal spline";
