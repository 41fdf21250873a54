//! Runs the command as a user does, and reads what it wrote.
#![allow(dead_code, unreachable_pub, reason = "each test file uses its part")]

pub mod chains;
pub mod chromium;
pub mod live;
pub mod plain;

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use qrm_core::{Mechanism, Model, Tape};
use qrm_scene::formula_tape::event_tape;
use qrm_scene::resolve::{read_condition, read_with};
use serde_json::Value;
use tempfile::TempDir;

/// A finished run and its folder.
pub struct Run {
    pub output: Output,
    folder: TempDir,
}

/// The command, in this workspace's top folder.
pub fn qrm(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_qrm"));
    command.current_dir(env!("CARGO_MANIFEST_DIR")).args(arguments);
    command
}

/// The generated mechanism of this name.
pub fn model(name: &str) -> &'static Model {
    qrm_model::MODELS.iter().find(|model| model.description.name == name).expect("a generated scene")
}

/// The event of a condition on the names of a scene.
pub fn event(model: &Model, condition: &str) -> Tape {
    let (scene, _) = read_with("scene.toml", model.description.source, &|_| None).expect("a scene");
    event_tape(&scene, &read_condition(&scene, condition).expect("a condition"), model.named_tape())
}

/// The symbolic engine: that of `QRM_ENGINE`, or the one that was built in this clone.
fn engine() -> PathBuf {
    let built = || Path::new(env!("CARGO_MANIFEST_DIR")).join("target/engine/release/qrm-engine");
    std::env::var_os("QRM_ENGINE").map_or_else(built, PathBuf::from)
}

/// The mechanism of a scene file that is not compiled.
pub fn derived(scene: &Path) -> Model {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("scene");
    let mut engine = Command::new(engine());
    engine.arg("derive").arg(scene).arg(&file).stdin(std::fs::File::open(scene).expect("a scene"));
    let output = engine.output().expect("the engine starts");
    assert!(output.status.success(), "{}: {}", scene.display(), String::from_utf8_lossy(&output.stderr));
    let bytes = std::fs::read(file).expect("a derived scene");
    qrm_core::DerivedScene::from_bytes(&bytes).expect("whole").into_model()
}

/// The mechanism of this name, some parameters replaced.
pub fn mechanism(name: &str, replaced: &[(&str, f64)]) -> Box<dyn Mechanism> {
    model(name).mechanism(&|name| replaced.iter().find(|(replaced, _)| *replaced == name).map(|(_, value)| *value))
}

/// `qrm run ARGUMENTS --out` into a fresh folder.
pub fn run(arguments: &[&str]) -> Run {
    writing(&[&["run"], arguments].concat())
}

/// `qrm COMMAND ARGUMENTS --out` into a fresh folder.
pub fn writing(arguments: &[&str]) -> Run {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut command = qrm(arguments);
    command.arg("--out").arg(folder.path());
    Run { output: command.output().expect("the command starts"), folder }
}

/// The contents of a file of a command that succeeds.
pub fn written(arguments: &[&str], file: &str) -> Value {
    let run = writing(arguments);
    assert!(run.output.status.success(), "{}", run.stderr());
    run.json(file)
}

/// The error of a command that fails.
pub fn error(arguments: &[&str]) -> String {
    let run = writing(arguments);
    assert!(!run.output.status.success(), "{}", run.stdout());
    run.stderr()
}

/// A scene of the program with another formula for the slot of its rocker, in a file.
pub fn with_slot(scene: &str, residual: &str) -> (tempfile::TempDir, String) {
    let source = std::fs::read_to_string(format!("scenes/{scene}.toml")).expect("a scene");
    let given = "A.x - sqrt(A.x^2 + A.y^2)*cos(phi4)";
    assert!(source.contains(given));
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join(format!("{scene}.toml"));
    std::fs::write(&path, source.replace(given, residual)).expect("written");
    let path = path.display().to_string();
    (folder, path)
}

impl Run {
    pub fn status(&self) -> i32 {
        self.output.status.code().expect("the command ended by itself")
    }

    pub fn stdout(&self) -> String {
        String::from_utf8_lossy(&self.output.stdout).into_owned()
    }

    pub fn stderr(&self) -> String {
        String::from_utf8_lossy(&self.output.stderr).into_owned()
    }

    pub fn path(&self, file: &str) -> PathBuf {
        self.folder.path().join(file)
    }

    pub fn summary(&self) -> Value {
        self.json("summary.json")
    }

    pub fn json(&self, file: &str) -> Value {
        let text = std::fs::read_to_string(self.path(file)).unwrap_or_else(|e| panic!("{e}: {}", self.stderr()));
        serde_json::from_str(&text).expect("it is JSON")
    }

    pub fn trajectory(&self) -> Table {
        Table::read(&self.path("trajectory.csv"))
    }
}

/// A table of numbers; fields that are none are kept as text.
pub struct Table {
    pub columns: Vec<String>,
    pub rows: Vec<Vec<String>>,
}

impl Table {
    pub fn read(path: &Path) -> Self {
        let mut reader = csv::Reader::from_path(path).expect("a table");
        let columns = reader.headers().expect("a header").iter().map(str::to_owned).collect();
        let rows = reader.records().map(|row| row.expect("a row").iter().map(str::to_owned).collect());
        Self { columns, rows: rows.collect() }
    }

    /// A table of `tests/reference`.
    pub fn reference(name: &str) -> Self {
        Self::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/reference").join(name))
    }

    pub fn text(&self, row: usize, column: &str) -> &str {
        let place = self.columns.iter().position(|c| c == column).unwrap_or_else(|| panic!("no column {column}"));
        &self.rows[row][place]
    }

    pub fn number(&self, row: usize, column: &str) -> f64 {
        self.text(row, column).parse().unwrap_or_else(|_| panic!("{column} in row {row} is no number"))
    }

    pub fn last(&self) -> usize {
        self.rows.len() - 1
    }
}

/// Asserts that two numbers differ by no more than allowed.
#[track_caller]
pub fn near(what: &str, got: f64, expected: f64, allowed: f64) {
    assert!(
        (got - expected).abs() <= allowed,
        "{what}: {got:?} instead of {expected:?}, off by {:e}",
        (got - expected).abs()
    );
}

pub fn number(value: &Value) -> f64 {
    value.as_f64().expect("a number")
}

/// Compares a number with its value; its error may be three times the stated one, which must not be above the most.
#[track_caller]
pub fn within(found: &Value, stated: &Value, expected: f64, most: f64) {
    let (found, stated) = (number(found), number(stated));
    let error = (found - expected).abs();
    assert!(
        error <= 3.0 * stated && stated <= most,
        "{found} instead of {expected}: off by {error:e}, stated {stated:e}"
    );
}

/// Splits a line into words as a shell does, single quotes respected.
pub fn split(line: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let mut quoted = false;
    for character in line.chars() {
        match character {
            '\'' => quoted = !quoted,
            ' ' if !quoted => words.push(String::new()),
            other => words.last_mut().expect("never empty").push(other),
        }
    }
    words.retain(|word| !word.is_empty());
    words
}
