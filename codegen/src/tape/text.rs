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
    field("parameters", &function(&tape.parameters));
    field("constants", &list(tape.constants, 8));
    field("dynamics", &function(&tape.dynamics));
    field("loop_constraints", &function(&tape.loop_constraints));
    field("mass_matrix", &function(&tape.mass_matrix));
    field("energy", &function(&tape.energy));
    field("power", &function(&tape.power));
    field("outputs", &function(&tape.outputs));
    let optional = |part: &Option<TapeFunction>| {
        part.as_ref().map_or_else(|| "None".to_owned(), |part| format!("Some({})", function(part)))
    };
    field("linearization", &optional(&tape.linearization));
    field("event", &optional(&tape.event));
    field("start", &function(&tape.start));
    field("given", &list(tape.given, 8));
    field("schedule", &function(&tape.schedule));
    field("kernel", &kernel(&tape.kernel));
    text + "    }\n};\n"
}

fn kernel(kernel: &TapeKernel) -> String {
    let mut text = format!("TapeKernel {{\n            operations: {},\n", kernel.operations);
    let mut field = |name: &str, value: &str| text += &format!("            {name}: {value},\n");
    field("has_angle", &list(kernel.has_angle, 12));
    field("position", &function(&kernel.position));
    field("velocity_residual", &function(&kernel.velocity_residual));
    field("correction", &function(&kernel.correction));
    field("accelerations", &function(&kernel.accelerations));
    field("multipliers", &function(&kernel.multipliers));
    field("outputs", &function(&kernel.outputs));
    text + "        }"
}

fn function(function: &TapeFunction) -> String {
    let (operations, results) = (list(function.operations, 12), list(function.results, 12));
    format!("TapeFunction {{\n            operations: {operations},\n            results: {results},\n        }}")
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
