//! A tape as Rust, several operations a line.

use std::fmt::Debug;

use qrm_core::TapeFunction;

use super::OwnedTape;

/// The longest line.
const WIDTH: usize = 120;

/// The beginning of the item.
const HEAD: &str = "
/// The functions as operations, for any kind of number.
pub static TAPE: qrm_core::Tape = {
    use qrm_core::Operation::*;
    use qrm_core::TapeFunction;
    qrm_core::Tape {
";

impl OwnedTape {
    /// The item `TAPE` of a generated module.
    pub fn text(&self) -> String {
        let tape = self.tape();
        let mut text = String::from(HEAD);
        let mut field = |name: &str, value: &str| text += &format!("        {name}: {value},\n");
        field("coordinates", &tape.coordinates.to_string());
        field("constraints", &tape.constraints.to_string());
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
        text + "    }\n};\n"
    }
}

fn function(function: &TapeFunction) -> String {
    let (operations, results) = (list(function.operations, 12), list(function.results, 12));
    format!("TapeFunction {{\n            operations: {operations},\n            results: {results},\n        }}")
}

/// A list, in lines as long as they may be.
fn list(items: &[impl Debug], indent: usize) -> String {
    let items: Vec<String> = items.iter().map(|item| format!("{item:?}")).collect();
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
