//! Tests that the README shows the present code, formulae, figures and output.

use crate::common;
use crate::common::{qrm, split};

const README: &str = include_str!("../README.md");

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
    let start = README.find("```toml\n").expect("a block of TOML") + "```toml\n".len();
    let block = &README[start..start + README[start..].find("```").expect("its end")];
    for line in block.lines().filter(|line| line.contains('=')) {
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
        assert!(README.contains(&format!("\n    {line}\n")), "{line}");
    }
}

#[test]
#[ignore = "full tier: commands"]
fn the_commands_shown_do_what_they_should() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let shown = README.lines().filter_map(|line| line.trim().strip_prefix("cargo run --release -- "));
    // Those of the table of scenes, but for the one that needs a build of its own.
    let in_table = README.lines().filter_map(|line| line.split("| `run").nth(1)?.split('`').next());
    let in_table: Vec<String> =
        in_table.map(|rest| format!("run{rest}")).filter(|command| command != "run n-four-bar-40").collect();
    assert!(in_table.len() >= 11, "{in_table:?}");
    let commands = shown.chain(in_table.iter().map(String::as_str));
    let mut count = 0;
    for command in commands {
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
    assert!(count >= 4, "{count} commands");
}
