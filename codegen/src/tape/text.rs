//! A tape as Rust, several operations a line.

use std::fmt::Debug;

use qrm_core::{Tape, TapeFunction, TapeKernel};

/// The longest line.
const WIDTH: usize = 120;

/// The beginning of the item.
const HEAD: &str = "
/// The functions as operations, for any kind of number.
pub static TAPE: qrm_core::Tape = {
    use qrm_core::Operation::*;
    use qrm_core::{TapeFunction, TapeKernel};
    qrm_core::Tape {
";

/// The item `TAPE` of a generated module.
pub fn text(tape: &Tape) -> String {
    let mut text = String::from(HEAD);
    let mut field = |name: &str, value: &str| text += &format!("        {name}: {value},\n");
    field("coordinates", &tape.coordinates.to_string());
    field("constraints", &tape.constraints.to_string());
    field("is_driven", &tape.is_driven.to_string());
    field("parameters", &function(&tape.parameters, 8));
    field("constants", &list(tape.constants, 8));
    field("dynamics", &function(&tape.dynamics, 8));
    field("loop_constraints", &function(&tape.loop_constraints, 8));
    field("mass_matrix", &function(&tape.mass_matrix, 8));
    field("energy", &function(&tape.energy, 8));
    field("power", &function(&tape.power, 8));
    field("outputs", &function(&tape.outputs, 8));
    let optional = |part: &Option<TapeFunction>| {
        part.as_ref().map_or_else(|| "None".to_owned(), |part| format!("Some({})", function(part, 8)))
    };
    field("linearization", &optional(&tape.linearization));
    field("event", &optional(&tape.event));
    field("switching_functions", &function(&tape.switching_functions, 8));
    field("linear_in_time", &tape.linear_in_time.to_string());
    field("tanh_arguments", &function(&tape.tanh_arguments, 8));
    field("start", &function(&tape.start, 8));
    field("given", &list(tape.given, 8));
    field("schedule", &function(&tape.schedule, 8));
    field("kernel", &kernel(&tape.kernel));
    text + "    }\n};\n"
}

fn kernel(kernel: &TapeKernel) -> String {
    let mut text = format!("TapeKernel {{\n            operations: {},\n", kernel.operations);
    let mut field = |name: &str, value: &str| text += &format!("            {name}: {value},\n");
    field("has_angle", &list(kernel.has_angle, 12));
    field("position", &function(&kernel.position, 12));
    field("velocity_residual", &function(&kernel.velocity_residual, 12));
    field("correction", &function(&kernel.correction, 12));
    field("accelerations", &function(&kernel.accelerations, 12));
    field("multipliers", &function(&kernel.multipliers, 12));
    field("outputs", &function(&kernel.outputs, 12));
    text + "        }"
}

/// A function, in a field that stands `indent` spaces from the margin.
fn function(function: &TapeFunction, indent: usize) -> String {
    let (operations, results) = (list(function.operations, indent + 4), list(function.results, indent + 4));
    let (inner, outer) = (" ".repeat(indent + 4), " ".repeat(indent));
    format!("TapeFunction {{\n{inner}operations: {operations},\n{inner}results: {results},\n{outer}}}")
}

/// A list, in lines as long as they may be.
fn list(items: &[impl Debug], indent: usize) -> String {
    let text = |item| format!("{item:?}").replace("(inf)", "(f64::INFINITY)");
    let items: Vec<String> = items.iter().map(text).collect();
    let whole = items.join(", ");
    // In front stands the name of a field.
    if indent + "operations: &[],".len() + whole.len() <= WIDTH {
        return format!("&[{whole}]");
    }
    let indent = " ".repeat(indent);
    let (mut text, mut line) = (String::from("&["), String::new());
    for item in items {
        if line.is_empty() || line.len() + item.len() + 2 > WIDTH {
            text += &line;
            line = format!("\n{indent}    {item},");
        } else {
            line += &format!(" {item},");
        }
    }
    format!("{text}{line}\n{indent}]")
}
