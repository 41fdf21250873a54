//! Functions, each in its own file.

use std::collections::BTreeSet;

use super::builtins::{helpers, is_reserved};
use super::{Writer, check_length};
use crate::ir::{Expression, Function, Shape, Statement, StructKind, Variable};
use crate::lines;
use crate::names::Names;
use crate::untranslated::Untranslated;

impl Writer<'_> {
    /// Writes the file of a function.
    pub(super) fn function(&self, function: &Function) -> Result<String, Untranslated> {
        let names = function.local_names(is_reserved)?;
        names.iter().try_for_each(check_length)?;
        let replace = function.arguments.first().map_or("", |argument| names.get(&argument.name));
        let mut text = self.head(function, &names) + &self.help(function, replace);
        if is_parameters(function) {
            text += &self.replacement(replace);
        }
        let is_constant = |value: &Expression| *value == Expression::name("m").field("constants");
        let mut has_constants = false;
        function.body.iter().for_each(|statement| statement.visit(&mut |value| has_constants |= is_constant(value)));
        if has_constants {
            text += &format!("    k = {}_constants(p);\n", self.program.name);
        }
        let mut prepared = BTreeSet::new();
        for statement in &function.body {
            text += &self.statement(&names, function, statement, &mut prepared);
        }
        for result in function.results.iter().filter(|result| !prepared.contains(result.name.as_str())) {
            text += &self.prepare(&names, result);
        }
        if is_parameters(function) {
            text += &self.check(replace, names.get(&function.results[0].name));
        }
        Ok(text + "end\n" + &helpers(function))
    }

    /// The signature with results and arguments; the parameters come last.
    fn head(&self, function: &Function, names: &Names) -> String {
        let is_mechanism = |argument: &&Variable| argument.shape == Shape::Struct(StructKind::Mechanism);
        let others = function.arguments.iter().filter(|argument| !is_mechanism(argument));
        let mut arguments: Vec<&str> = others.map(|argument| names.get(&argument.name)).collect();
        arguments.extend(function.arguments.iter().find(is_mechanism).map(|_| "p"));
        let results: Vec<&str> = function.results.iter().map(|result| names.get(&result.name)).collect();
        let results = match &results[..] {
            [result] => (*result).to_owned(),
            results => format!("[{}]", results.join(", ")),
        };
        format!("function {results} = {}_{}({})\n", self.program.name, self.name(function), arguments.join(", "))
    }

    /// The text that `help` shows; `replace` is the name of the first argument.
    fn help(&self, function: &Function, replace: &str) -> String {
        let name = &self.program.name;
        let mut lines: Vec<String> = match is_parameters(function) {
            true => vec![
                "The parameters of the scene.".to_owned(),
                String::new(),
                format!(
                    "Fields of the struct `{replace}`, which can be left out, stand for the scene's values. What the \
                     scene"
                ),
                "computes from other values follows them.".to_owned(),
                String::new(),
                "Fields:".to_owned(),
            ],
            false => function.doc.clone(),
        };
        if is_parameters(function) {
            let parameters = self.program.structs.iter().find(|structure| structure.kind == StructKind::Parameters);
            for field in parameters.map_or(&[][..], |structure| &structure.fields) {
                lines.push(format!("    {}  {}", self.fields.get(&field.name), field.doc.join(" ")));
            }
        } else if function.arguments.iter().any(|argument| argument.shape == Shape::Struct(StructKind::Mechanism)) {
            lines.extend([String::new(), format!("`p` holds the parameters: see {name}_parameters.")]);
        }
        let title = format!("{}_{}", name.to_uppercase(), self.name(function).to_uppercase());
        let first = if lines.is_empty() { String::new() } else { lines.remove(0) };
        let mut text = format!("    %{title} {first}").trim_end().to_owned() + "\n";
        for line in lines {
            text += format!("    %   {line}").trim_end();
            text += "\n";
        }
        text
    }

    /// The beginning of the function of parameters: the replaced values are in a struct.
    fn replacement(&self, replace: &str) -> String {
        format!(
            "    if nargin < 1\n        {replace} = struct();\n    elseif ~isstruct({replace})\n        \
             error('{}_parameters: values are given as a struct, such as struct(''name'', 1)');\n    end\n",
            self.program.name
        )
    }

    /// The end of the function of parameters: unknown names are errors.
    fn check(&self, replace: &str, parameters: &str) -> String {
        format!(
            "    unknown = setdiff(fieldnames({replace}), fieldnames({parameters}));\n    \
             if ~isempty(unknown)\n        \
             error('{}_parameters: there is no parameter `%s` that can be changed', unknown{{1}});\n    end\n",
            self.program.name
        )
    }

    /// Initializes a result.
    fn prepare(&self, names: &Names, result: &Variable) -> String {
        let value = match result.shape {
            Shape::Scalar => return String::new(),
            Shape::Struct(StructKind::Angles) => {
                let zeros = empty(Shape::Vector(self.program.coordinates.len()));
                format!("struct('sin', {zeros}, 'cos', {zeros})")
            }
            shape => empty(shape),
        };
        format!("    {} = {value};\n", names.get(&result.name))
    }

    fn statement<'f>(
        &self,
        names: &Names,
        function: &'f Function,
        statement: &'f Statement,
        prepared: &mut BTreeSet<&'f str>,
    ) -> String {
        let expression = |value| self.expression(names, value);
        let line = |text: &str| lines::statement(text, " ...");
        match statement {
            Statement::Comment(text) => format!("\n    % {text}\n"),
            Statement::Alias { name, of, .. } if names.get(name) == expression(of) => String::new(),
            Statement::Alias { name, of, .. } => line(&format!("{} = {};", names.get(name), expression(of))),
            Statement::Let { name, value } => line(&format!("{} = {};", names.get(name), expression(value))),
            Statement::Clear { place, shape } => {
                prepared.extend(root(place));
                format!("    {} = {};\n", expression(place), empty(*shape))
            }
            Statement::Assign { place, value } => {
                let result = root(place).and_then(|name| function.results.iter().find(|result| result.name == name));
                let fresh = result.filter(|result| prepared.insert(&result.name));
                let before = fresh.map_or_else(String::new, |result| self.prepare(names, result));
                // All elements of lists are initially zero.
                let is_zero = *value == Expression::Number("0.0".to_owned()) || *value == Expression::Boolean(false);
                if is_zero && matches!(place, Expression::Element(..)) {
                    return before;
                }
                before + &line(&format!("{} = {};", expression(place), expression(value)))
            }
            Statement::Return(value) => {
                prepared.extend(function.results.iter().map(|result| result.name.as_str()));
                line(&format!("{} = {};", names.get(&function.results[0].name), expression(value)))
            }
        }
    }
}

/// Whether the function returns the parameters.
fn is_parameters(function: &Function) -> bool {
    function.name == "parameters_with"
}

/// The result to which an element belongs.
fn root(place: &Expression) -> Option<&str> {
    match place {
        Expression::Name(name) => Some(name),
        Expression::Element(of, _) | Expression::Field(of, _) => root(of),
        _ => None,
    }
}

/// The initial value of a shape.
fn empty(shape: Shape) -> String {
    match shape {
        Shape::Scalar => "0".to_owned(),
        Shape::Vector(count) => format!("zeros({count}, 1)"),
        Shape::Matrix(rows, columns) => format!("zeros({rows}, {columns})"),
        Shape::Booleans(count) => format!("false({count}, 1)"),
        Shape::Struct(_) => "struct()".to_owned(),
    }
}
