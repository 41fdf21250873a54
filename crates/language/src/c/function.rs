//! Functions.

use super::comment::comment;
use super::reserved_words::is_reserved;
use super::{Writer, is_own_macro};
use crate::ir::{Expression, Function, Shape, Statement};
use crate::lines;
use crate::names::Names;
use crate::untranslated::Untranslated;

impl Writer<'_> {
    pub(super) fn signature(&self, function: &Function) -> Result<String, Untranslated> {
        let names = self.local_names(function)?;
        let mut arguments: Vec<String> = Vec::new();
        for argument in &function.arguments {
            let constant = if argument.shape == Shape::Scalar { "" } else { "const " };
            arguments.push(format!("{constant}{}", self.declaration(argument.shape, names.get(&argument.name))));
        }
        if !function.returns_scalar() {
            for result in &function.results {
                let pointer = if result.shape == Shape::Scalar { "*" } else { "" };
                let name = format!("{pointer}{}", names.get(&result.name));
                arguments.push(self.declaration(result.shape, &name));
            }
        }
        let of = if function.returns_scalar() { "double" } else { "void" };
        Ok(lines::signature(&format!("{of} {}_{}", self.program.name, function.name), &arguments))
    }

    fn local_names(&self, function: &Function) -> Result<Names, Untranslated> {
        function.local_names(|name| is_reserved(name) || is_own_macro(self.program, name))
    }

    fn declaration(&self, shape: Shape, name: &str) -> String {
        match shape {
            Shape::Scalar => format!("double {name}"),
            Shape::Vector(count) => format!("double {name}[{}]", count.max(1)),
            Shape::Matrix(rows, columns) => format!("double {name}[{}][{}]", rows.max(1), columns.max(1)),
            Shape::Booleans(count) => format!("int {name}[{}]", count.max(1)),
            Shape::Struct(kind) => format!("{} *{name}", self.structure(kind)),
        }
    }

    /// Writes the source of a function.
    pub(super) fn function(&self, function: &Function, is_inline: bool) -> Result<String, Untranslated> {
        let names = self.local_names(function)?;
        let inline = if is_inline { "INLINE " } else { "" };
        let mut text = format!("{}{inline}{}\n{{\n", comment(&function.doc), self.signature(function)?);
        for name in unused(function) {
            text += &format!("    (void){};\n", names.get(name));
        }
        for statement in &function.body {
            text += &self.statement(&names, function, statement);
        }
        Ok(text + "}\n")
    }

    fn statement(&self, names: &Names, function: &Function, statement: &Statement) -> String {
        let expression = |value| self.expression(names, value);
        match statement {
            Statement::Comment(text) => format!("\n    {}", comment(&[text])),
            Statement::Alias { name, kind, of } => {
                let (structure, name) = (self.structure(*kind), names.get(name));
                format!("    const {structure} *{name} = &{};\n", expression(of))
            }
            Statement::Let { name, value } => {
                lines::statement(&format!("const double {} = {};", names.get(name), expression(value)), "")
            }
            Statement::Clear { place, shape } => clear(&expression(place), *shape),
            Statement::Assign { place, value } => {
                let is_number = |name: &str| {
                    function.results.iter().any(|result| result.name == name && result.shape == Shape::Scalar)
                };
                let pointer = match place {
                    Expression::Name(name) if is_number(name) => "*",
                    _ => "",
                };
                lines::statement(&format!("{pointer}{} = {};", expression(place), expression(value)), "")
            }
            Statement::Return(value) => lines::statement(&format!("return {};", expression(value)), ""),
        }
    }
}

/// Arguments and results that no statement uses.
fn unused(function: &Function) -> impl Iterator<Item = &str> {
    let arguments = function.arguments.iter().map(|argument| argument.name.as_str());
    let results = function.results.iter().map(|result| result.name.as_str()).filter(|_| !function.returns_scalar());
    arguments.chain(results).filter(|name| !function.mentions(name))
}

/// Sets all elements to zero.
fn clear(place: &str, shape: Shape) -> String {
    match shape {
        Shape::Vector(count) => {
            format!("    for (int i = 0; i < {count}; i++) {{\n        {place}[i] = 0.0;\n    }}\n")
        }
        Shape::Matrix(rows, columns) => format!(
            "    for (int i = 0; i < {rows}; i++) {{\n        for (int j = 0; j < {columns}; j++) {{\n            \
             {place}[i][j] = 0.0;\n        }}\n    }}\n"
        ),
        Shape::Scalar | Shape::Booleans(_) | Shape::Struct(_) => format!("    {place} = 0.0;\n"),
    }
}
