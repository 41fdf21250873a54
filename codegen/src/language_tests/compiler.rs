//! Compilers of C.

use std::fs;
use std::io::Write;
use std::path::PathBuf;
use std::process::{Command, Stdio};

use super::states::State;
use qrm_language::File;

// Products and sums are rounded separately, like in the interpreter.
const FLAGS: [&str; 7] = ["-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic", "-O1", "-ffp-contract=off"];

pub(super) struct Compiler {
    pub(super) name: &'static str,
}

pub(super) const COMPILERS: [Compiler; 2] = [Compiler { name: "gcc" }, Compiler { name: "clang" }];

impl Compiler {
    /// Compiles this code with this main file, and returns the numbers that the program prints.
    pub(super) fn run(&self, name: &str, files: &[File], main: &str, states: &[State]) -> Vec<f64> {
        let folder = super::folder();
        let file = |name: &str| folder.join(name);
        files.iter().for_each(|written| fs::write(file(&written.name), &written.text).expect("a file"));
        let sources = [file(&format!("{name}.c")), file("main.c")];
        fs::write(&sources[1], main).expect("a source");
        let program = file("program");
        let mut command = Command::new(self.name);
        let output = command.args(FLAGS).args(&sources).arg("-o").arg(&program).arg("-lm").output().expect(self.name);
        assert!(output.status.success(), "{name}: {}", String::from_utf8_lossy(&output.stderr));
        let numbers = numbers(&program, states);
        fs::remove_dir_all(&folder).expect("the folder can be removed");
        numbers
    }
}

fn numbers(program: &PathBuf, states: &[State]) -> Vec<f64> {
    let mut child =
        Command::new(program).stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().expect("the program runs");
    let mut input = child.stdin.take().expect("an input");
    let text: String = states.iter().flat_map(State::numbers).map(|number| format!("{number:e}\n")).collect();
    let writer = std::thread::spawn(move || input.write_all(text.as_bytes()));
    let output = child.wait_with_output().expect("an output");
    writer.join().expect("a thread").expect("all states are read");
    assert!(output.status.success(), "the program ends with {}", output.status);
    let text = String::from_utf8(output.stdout).expect("text");
    text.lines().map(|line| line.parse().expect("a number")).collect()
}
