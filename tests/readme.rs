//! Tests that README and book show the present code, formulae, figures and output.

use crate::common;
use crate::common::{qrm, split};

const README: &str = include_str!("../README.md");
const RUNNING: &str = include_str!("../docs/running.md");
const SCENES: &str = include_str!("../docs/scenes.md");

/// The blocks of TOML in the README.
fn blocks() -> Vec<&'static str> {
    README.split("```toml\n").skip(1).map(|rest| &rest[..rest.find("```").expect("its end")]).collect()
}

#[test]
fn the_readme_is_short_and_begins_with_a_picture() {
    let picture = README.lines().position(|line| line.starts_with("![")).expect("a picture");
    assert!(README.lines().count() <= 150 && picture < 10);
}

#[test]
#[ignore = "full tier: commands"]
fn the_four_bar_runs_as_shown() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("my-four-bar.toml");
    std::fs::write(&file, blocks()[0]).expect("written");
    let output = qrm(&["run", "my-four-bar.toml"]).current_dir(folder.path()).output().expect("the command starts");
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    let shown = said.lines().filter(|line| ["  T ", "  F_", "  error"].iter().any(|start| line.starts_with(start)));
    assert_eq!(shown.clone().count(), 5, "{said}");
    for line in shown {
        assert!(README.contains(&format!("\n    {line}\n")), "{line}");
    }
}

#[test]
fn the_generated_function_is_the_generated_one() {
    let golden = include_str!("../qrm-model/golden/quick_return.rs");
    let start = README.find("```rust\n").expect("a block of Rust") + "```rust\n".len();
    let block = &README[start..start + README[start..].find("```").expect("its end")];
    assert!(golden.contains(block), "{block}");
}

#[test]
fn the_formulae_are_those_of_the_scene() {
    // In the file the equals signs stand below each other.
    let one_space = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
    let scene = one_space(include_str!("../scenes/quick-return.toml"));
    for line in blocks()[1].lines().filter(|line| line.contains('=')) {
        let formula = line.trim_end_matches(" }").trim_end_matches(',');
        assert!(scene.contains(&one_space(formula)), "{formula}");
    }
}

#[test]
fn the_figure_is_that_of_the_default_run() {
    let run = common::run(&[]);
    let drawn = std::fs::read(run.path("figures/reactions.svg")).expect("a figure");
    let same = drawn == include_bytes!("../docs/images/reactions.svg");
    assert!(same, "docs/images/reactions.svg is not what is drawn now; copy it from out/quick-return/figures");
}

#[test]
fn the_default_run_prints_what_is_shown() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let output = qrm(&[]).current_dir(folder.path()).output().expect("the command starts");
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    for line in said.lines().filter(|line| !line.starts_with("  time ") && !line.is_empty()) {
        assert!(RUNNING.contains(&format!("\n    {line}\n")), "{line}");
    }
}

#[test]
#[ignore = "full tier: commands"]
fn the_commands_shown_do_what_they_should() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    // Those of the table of scenes, but for the one that needs a build of its own.
    let in_table = SCENES.lines().filter_map(|line| line.split("| `run").nth(1)?.split('`').next());
    let commands: Vec<String> =
        in_table.map(|rest| format!("run{rest}")).filter(|command| command != "run n-four-bar-40").collect();
    let mut count = 0;
    for command in &commands {
        // The folder of the command is another one.
        let path = |word: String| match word.starts_with("scenes/") {
            true => format!("{}/{word}", env!("CARGO_MANIFEST_DIR")),
            false => word,
        };
        let arguments: Vec<String> = split(command).into_iter().map(path).collect();
        let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
        let output = qrm(&arguments).current_dir(folder.path()).output().expect("the command starts");
        assert!(output.status.success(), "{command}: {}", String::from_utf8_lossy(&output.stderr));
        count += 1;
    }
    assert!(count >= 11, "{count} commands");
}
