//! Runs MATLAB code in Octave.

use std::fs;
use std::process::Command;

use qrm_language::File;
use qrm_language::ir::{Function, Program, Shape, StructKind, Variable};

use super::states::{State, fields};

/// The results of all functions of a program in these files, in the order of the states.
pub(super) fn run(program: &Program, files: &[File], states: &[State]) -> Vec<f64> {
    let folder = super::folder();
    files.iter().for_each(|file| fs::write(folder.join(&file.name), &file.text).expect("a file"));
    let row = |state: &State| state.numbers().iter().map(|number| format!("{number:e} ")).collect::<String>() + "\n";
    fs::write(folder.join("states.txt"), states.iter().map(row).collect::<String>()).expect("a file");
    fs::write(folder.join("driver.m"), driver(program)).expect("a file");
    let mut command = Command::new("octave-cli");
    let output = command.args(["--quiet", "--norc", "driver.m"]).current_dir(&folder).output().expect("octave-cli");
    assert!(output.status.success(), "{}: {}", program.name, String::from_utf8_lossy(&output.stderr));
    let text = fs::read_to_string(folder.join("results.txt")).expect("results");
    fs::remove_dir_all(&folder).expect("the folder can be removed");
    text.lines().map(|line| line.parse().expect("a number")).collect()
}

/// A script that calls all functions at the states in a file, and writes the results to another file.
fn driver(program: &Program) -> String {
    let (n, m) = (program.coordinates.len(), program.constraints.len());
    let parameters = fields(program, StructKind::Parameters).len();
    let mut text = "1;\nfunction x = numbers(x)\n    x = cell2mat(struct2cell(x));\nend\n".to_owned();
    text += "function results = call(s)\n    t = s(1);\n";
    let mut place = 1;
    for (name, count) in [("change", parameters), ("q", n), ("qd", n), ("qdd", n), ("multipliers", m), ("residuals", m)]
    {
        text += &format!("    {name} = s({}:{});\n", place + 1, place + count);
        place += count;
    }
    let mut results = Vec::new();
    for (i, function) in program.functions.iter().enumerate() {
        text += &call(program, function, i, &mut results);
    }
    text += &format!("    results = [{}];\nend\n", results.join("; "));
    text += "states = load('-ascii', 'states.txt');\nfile = fopen('results.txt', 'w');\n";
    text + "for i = 1:size(states, 1)\n    fprintf(file, '%.17g\\n', call(states(i, :).'));\nend\nfclose(file);\n"
}

/// Calls a function; appends its results, as a column of numbers, to `written`.
fn call(program: &Program, function: &Function, number: usize, written: &mut Vec<String>) -> String {
    let name = &program.name;
    match function.name.as_str() {
        "default_parameters" => {
            written.push("defaults".to_owned());
            // Every second one is replaced.
            return format!(
                "    defaults = numbers({name}_parameters());\n    names = fieldnames({name}_parameters());\n    \
                 replace = struct();\n    for i = 1:2:numel(names)\n        replace.(names{{i}}) = defaults(i) + \
                 change(i);\n    end\n"
            );
        }
        "parameters_with" => {
            written.push("numbers(p)".to_owned());
            return format!("    p = {name}_parameters(replace);\n");
        }
        _ => {}
    }
    let is_mechanism = |argument: &&Variable| argument.shape == Shape::Struct(StructKind::Mechanism);
    let mut arguments: Vec<&str> =
        function.arguments.iter().filter(|argument| !is_mechanism(argument)).map(|argument| &*argument.name).collect();
    arguments.extend(function.arguments.iter().find(is_mechanism).map(|_| "p"));
    let mut variables = Vec::new();
    for (i, result) in function.results.iter().enumerate() {
        let variable = match result.shape {
            Shape::Struct(kind) => kind.name().to_owned(),
            _ => format!("r{number}_{i}"),
        };
        written.push(match result.shape {
            Shape::Struct(_) => format!("numbers({variable})"),
            Shape::Matrix(..) => format!("{variable}.'(:)"),
            Shape::Scalar | Shape::Vector(_) => variable.clone(),
            Shape::Booleans(_) => format!("double({variable})"),
        });
        variables.push(variable);
    }
    format!("    [{}] = {name}_{}({});\n", variables.join(", "), function.name, arguments.join(", "))
}
