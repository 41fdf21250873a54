//! MATLAB code that also runs in Octave.

mod builtins;
mod expression;
mod function;
mod run;
mod templates;

use super::File;
use super::ir::{Function, Program, StructKind};
use super::names::Names;
use crate::untranslated::Untranslated;
use builtins::is_reserved;

/// Writes the files of a program: its functions, the steps of its motion, and a script.
pub(super) fn write(program: &Program) -> Result<Vec<File>, Untranslated> {
    let writer = Writer::new(program)?;
    let mut files = Vec::new();
    for function in program.functions.iter().filter(|function| function.name != DEFAULTS) {
        files.push(writer.file(writer.name(function), writer.function(function)?)?);
    }
    for (name, text) in writer.templates() {
        files.push(writer.file(name, text)?);
    }
    files.push(writer.file("run", writer.run())?);
    Ok(files)
}

/// Writes the file of a function.
pub(super) fn write_function(program: &Program, function: &Function) -> Result<String, Untranslated> {
    Writer::new(program)?.function(function)
}

/// The function of the scene's values: its arguments, the replaced values, can be omitted.
const DEFAULTS: &str = "default_parameters";
/// The largest length of a name.
const LONGEST_NAME: usize = 63;

struct Writer<'p> {
    program: &'p Program,
    fields: Names,
}

impl<'p> Writer<'p> {
    fn new(program: &'p Program) -> Result<Self, Untranslated> {
        let fields = program.structs.iter().flat_map(|structure| &structure.fields).map(|field| field.name.as_str());
        let fields = Names::new(fields, is_reserved)?;
        fields.iter().try_for_each(check_length)?;
        Ok(Self { program, fields })
    }

    /// The suffix that turns the name of the program into the name of a function.
    fn name<'f>(&self, function: &'f Function) -> &'f str {
        if function.name == "parameters_with" { StructKind::Parameters.name() } else { &function.name }
    }

    fn file(&self, name: &str, text: String) -> Result<File, Untranslated> {
        let name = format!("{}_{name}", self.program.name);
        check_length(&name)?;
        Ok(File { name: format!("{name}.m"), text })
    }
}

/// Refuses a name that MATLAB would truncate.
fn check_length(name: &str) -> Result<(), Untranslated> {
    match name.len() <= LONGEST_NAME {
        true => Ok(()),
        false => Err(Untranslated(format!("the name `{name}`, which is longer than {LONGEST_NAME} letters"))),
    }
}
