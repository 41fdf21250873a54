//! A tape as the program from which C and MATLAB are written.

mod expression;

use std::collections::HashMap;

use qrm_core::NamedTape;
use qrm_core::named_tape::{self, Argument, Value, place};
use qrm_scene::names::module_name;
use qrm_scene::scene::Scene;

use crate::ir::{
    Builtin, Expression, Field, Function, Program, Quantity, Shape, Statement, Struct, StructKind, Variable,
};
use crate::texts;

/// The program of a scene.
pub(super) fn program(scene: &Scene, tape: &NamedTape, source: &str) -> Program {
    let quantity = |name: &str, unit: &str, doc: &str| Quantity {
        name: name.to_owned(),
        unit: unit.to_owned(),
        doc: doc.to_owned(),
    };
    let lower = Lower { tape };
    let mut functions = lower.parameters();
    functions.extend(lower.constants());
    for (name, doc) in METHODS {
        functions.push(match tape.function(name) {
            Some(own) => lower.function(own, doc, scene),
            None => lower.never(name, doc),
        });
    }
    functions.push(angles(&tape.has_angle));
    let is_printed = |own: &&named_tape::Function| !crate::rust::is_part_of_type(&own.name);
    functions.extend(tape.functions.iter().filter(is_printed).map(|own| {
        let doc = texts::function(scene, tape, own);
        lower.function(own, &doc, scene)
    }));
    Program {
        name: module_name(&scene.name),
        doc: lines(&texts::mechanism(scene, source)),
        notes: tape.notes.clone(),
        coordinates: scene.coordinates.iter().map(|c| quantity(&c.name, &c.unit, &c.doc)).collect(),
        constraints: scene.constraints.iter().map(|c| quantity(&c.name, &c.unit, &c.doc)).collect(),
        outputs: scene.outputs.iter().map(|o| quantity(&o.name, &o.unit, &o.doc)).collect(),
        has_angle: tape.has_angle.clone(),
        is_length: scene.coordinates.iter().map(|coordinate| coordinate.unit != "rad").collect(),
        structs: structs(scene, tape),
        functions,
    }
}

/// Methods in Rust, which are functions in other languages.
const METHODS: [(&str, &str); 3] = [
    ("start", "The start of the motion: given values, and first guesses of the others."),
    ("schedule", "Step and end of the motion, in s."),
    ("event", "A value that rises through zero when the stop condition becomes true; minus infinity without one."),
];

/// The lines of a documentation; formulae in it are set in by four spaces.
fn lines(doc: &str) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    let mut in_formulae = false;
    for line in doc.lines() {
        match line.starts_with("```") {
            true => in_formulae = !in_formulae,
            false if in_formulae => lines.push(format!("    {line}")),
            false => lines.push(line.to_owned()),
        }
    }
    lines
}

fn structs(scene: &Scene, tape: &NamedTape) -> Vec<Struct> {
    let kept = scene.parameters.iter().filter(|p| !p.left_out);
    let parameter = |p: &qrm_scene::scene::Parameter| Field { name: p.name.clone(), doc: vec![texts::parameter(p)] };
    let fields = |name: &str| -> Option<Vec<Field>> {
        let field = |part: &named_tape::Part| Field { name: part.name.clone(), doc: lines(&part.doc) };
        tape.function(name).map(|own| own.parts.iter().map(field).collect())
    };
    let parameters = Some(kept.map(parameter).collect());
    [
        (StructKind::Parameters, texts::PARAMETERS, parameters),
        (StructKind::Constants, texts::CONSTANTS, fields("constants")),
        (StructKind::Position, texts::POSITION, fields("position")),
    ]
    .into_iter()
    .filter_map(|(kind, doc, fields)| Some(Struct { kind, doc: vec![doc.to_owned()], fields: fields? }))
    .collect()
}

/// The function that gives sines and cosines.
fn angles(is_angle: &[bool]) -> Function {
    let mut body = Vec::new();
    for (i, is_angle) in is_angle.iter().enumerate() {
        for (field, builtin) in [("sin", Builtin::Sin), ("cos", Builtin::Cos)] {
            let value = match is_angle {
                true => Expression::Call(builtin, vec![Expression::name("q").element(i)]),
                false => Expression::Number("0.0".to_owned()),
            };
            body.push(Statement::Assign { place: Expression::name("angles").field(field).element(i), value });
        }
    }
    let q = Variable { name: "q".to_owned(), shape: Shape::Vector(is_angle.len()) };
    let angles = Variable { name: "angles".to_owned(), shape: Shape::Struct(StructKind::Angles) };
    let doc = "Sines and cosines of the coordinates that are angles; zero in the places of others.";
    Function { name: "angles".to_owned(), doc: vec![doc.to_owned()], arguments: vec![q], results: vec![angles], body }
}

/// The mechanism as an argument.
fn mechanism() -> Variable {
    Variable { name: "m".to_owned(), shape: Shape::Struct(StructKind::Mechanism) }
}

struct Lower<'t> {
    tape: &'t NamedTape,
}

/// The names that values have in a function, and which of them are used.
struct Scope<'t> {
    tape: &'t NamedTape,
    names: HashMap<u32, Expression>,
    /// The short names that the function begins with, each with its statement and whether it is used.
    bindings: Vec<(Statement, bool)>,
    /// The bindings of values.
    bound: HashMap<u32, usize>,
}

impl Lower<'_> {
    /// The functions that give the parameters: those of the scene, and with some of them replaced.
    fn parameters(&self) -> Vec<Function> {
        let Some(own) = self.tape.function("parameters") else { return Vec::new() };
        let names: Vec<&String> = self.tape.names.range(..place(self.tape.sizes()[0])).map(|(_, name)| name).collect();
        let mut replace = "replace".to_owned();
        while names.contains(&&replace) {
            replace.push('_');
        }
        let body = |is_replaced: bool| {
            let mut scope = Scope::new(self.tape);
            let inputs = self.tape.names.range(..place(names.len()));
            scope.names.extend(inputs.map(|(input, name)| (*input, Expression::name(name))));
            let mut body = Vec::new();
            for (name, value) in names.iter().zip(own.results()) {
                let value = scope.value(value);
                let value = match is_replaced {
                    true => Expression::Call(Builtin::ValueOr, vec![Expression::name(&replace).field(name), value]),
                    false => value,
                };
                body.push(Statement::Let { name: (*name).clone(), value });
            }
            let mut result = "parameters".to_owned();
            while names.contains(&&result) {
                result.push('_');
            }
            for name in &names {
                let place = Expression::name(&result).field(name);
                body.push(Statement::Assign { place, value: Expression::name(name) });
            }
            (result, body)
        };
        let function = |name: &str, doc: &[&str], is_replaced: bool| {
            let (result, body) = body(is_replaced);
            let argument = Variable { name: replace.clone(), shape: Shape::Struct(StructKind::Parameters) };
            Function {
                name: name.to_owned(),
                doc: doc.iter().map(|&line| line.to_owned()).collect(),
                arguments: if is_replaced { vec![argument] } else { Vec::new() },
                results: vec![Variable { name: result, shape: Shape::Struct(StructKind::Parameters) }],
                body,
            }
        };
        let replaced = [
            "The scene's values, but for those that `replace` has in their place; the others of it are not a number.",
            "What the scene computes from other values follows them.",
        ];
        vec![
            function("default_parameters", &["The scene's values."], false),
            function("parameters_with", &replaced, true),
        ]
    }

    /// The function that gives the constants.
    fn constants(&self) -> Option<Function> {
        let own = self.tape.function("constants")?;
        let mut scope = Scope::new(self.tape);
        scope.name_parameters(&Expression::name("p"));
        let mut body = scope.statements(own);
        let result = scope.free("constants", own);
        for part in &own.parts {
            for value in part.values.values() {
                let place = Expression::name(&result).field(&part.name);
                body.push(Statement::Assign { place, value: scope.value(*value) });
            }
        }
        Some(Function {
            name: "constants".to_owned(),
            doc: vec!["The values that depend on parameters alone.".to_owned()],
            arguments: vec![Variable { name: "p".to_owned(), shape: Shape::Struct(StructKind::Parameters) }],
            results: vec![Variable { name: result, shape: Shape::Struct(StructKind::Constants) }],
            body,
        })
    }

    /// A function whose value is minus infinity.
    fn never(&self, name: &str, doc: &str) -> Function {
        let arguments = Argument::STATE.map(|own| self.argument(own));
        Function {
            name: name.to_owned(),
            doc: vec![doc.to_owned()],
            arguments: std::iter::once(mechanism()).chain(arguments).collect(),
            results: vec![Variable { name: name.to_owned(), shape: Shape::Scalar }],
            body: vec![Statement::Return(Expression::Infinity.negative())],
        }
    }

    fn argument(&self, argument: Argument) -> Variable {
        let [_, n, m] = self.tape.sizes();
        let (name, shape) = match argument {
            Argument::Position => ("position", Shape::Struct(StructKind::Position)),
            Argument::Time => ("t", Shape::Scalar),
            Argument::Coordinates => ("q", Shape::Vector(n)),
            Argument::Rates => ("qd", Shape::Vector(n)),
            Argument::Accelerations => ("qdd", Shape::Vector(n)),
            Argument::Multipliers => ("multipliers", Shape::Vector(m)),
            Argument::Residuals => ("residuals", Shape::Vector(m)),
            Argument::Angles => ("angles", Shape::Struct(StructKind::Angles)),
        };
        Variable { name: name.to_owned(), shape }
    }

    fn function(&self, own: &named_tape::Function, doc: &str, scene: &Scene) -> Function {
        let mut scope = Scope::new(self.tape);
        if own.arguments.contains(&Argument::Position) {
            scope.name_fields();
        }
        let mechanism_name = Expression::name("m");
        scope.alias("p", StructKind::Parameters, mechanism_name.clone().field("parameters"));
        scope.name_parameters(&Expression::name("p"));
        let alias = scope.bindings.len() - 1;
        scope.bound.extend((0..place(self.tape.sizes()[0])).map(|input| (input, alias)));
        if let Some(constants) = self.tape.function("constants") {
            scope.alias("k", StructKind::Constants, mechanism_name.field("constants"));
            for part in &constants.parts {
                for value in part.values.values() {
                    scope.names.insert(*value, Expression::name("k").field(&part.name));
                    scope.bound.insert(*value, scope.bindings.len() - 1);
                }
            }
        }
        for argument in &own.arguments {
            scope.bind(*argument);
        }
        let statements = scope.statements(own);
        let parts = self.results(own, scene);
        let mut results = Vec::new();
        let mut ends = Vec::new();
        for (name, shape, values) in parts {
            let name = scope.free(&name, own);
            match (shape, values) {
                (Shape::Scalar, Values::Numbers(values)) if own.parts.len() == 1 => {
                    ends.push(Statement::Return(scope.value(values[0])));
                }
                (Shape::Struct(_), _) => {
                    for part in &own.parts {
                        for value in part.values.values() {
                            let place = Expression::name(&name).field(&part.name);
                            ends.push(Statement::Assign { place, value: scope.value(*value) });
                        }
                    }
                }
                (shape, Values::Numbers(values)) => scope.fill(&mut ends, &name, shape, &values),
                (_, Values::Booleans(values)) => {
                    for (i, value) in values.into_iter().enumerate() {
                        let place = Expression::name(&name).element(i);
                        ends.push(Statement::Assign { place, value: Expression::Boolean(value) });
                    }
                }
            }
            results.push(Variable { name, shape });
        }
        let used = scope.bindings.into_iter().filter(|(_, is_used)| *is_used).map(|(statement, _)| statement);
        Function {
            name: own.name.clone(),
            doc: lines(doc),
            arguments: self.arguments(own),
            results,
            body: used.chain(statements).chain(ends).collect(),
        }
    }

    /// The arguments of a function. Those that steps call have the same ones for all mechanisms.
    fn arguments(&self, own: &named_tape::Function) -> Vec<Variable> {
        use Argument::{Accelerations, Angles, Coordinates, Multipliers, Rates, Time};
        let arguments: &[Argument] = match &*own.name {
            "position" => &[Time, Coordinates, Angles],
            "loop_constraints" => &[Time, Coordinates],
            "power" => &[Time, Coordinates, Rates, Accelerations, Multipliers],
            _ => &own.arguments,
        };
        std::iter::once(mechanism()).chain(arguments.iter().map(|argument| self.argument(*argument))).collect()
    }

    /// Names, shapes and values of the results of a function.
    fn results(&self, own: &named_tape::Function, scene: &Scene) -> Vec<(String, Shape, Values)> {
        let [_, n, m] = self.tape.sizes();
        if own.structure.as_deref() == Some("Position") {
            return vec![("position".to_owned(), Shape::Struct(StructKind::Position), Values::Numbers(Vec::new()))];
        }
        let names: &[&str] = match &*own.name {
            "accelerations" => &["qdd", "multipliers"],
            "inverse_dynamics" => &["forces", "multipliers"],
            _ => &[],
        };
        let mut results = Vec::new();
        for (i, part) in own.parts.iter().enumerate() {
            let name = names.get(i).copied().unwrap_or(if part.name.is_empty() { &own.name } else { &part.name });
            let shape = match &part.values {
                named_tape::Shape::Scalar(_) => Shape::Scalar,
                named_tape::Shape::Vector(values) => Shape::Vector(values.len()),
                named_tape::Shape::Matrix(rows) => Shape::Matrix(rows.len(), n),
            };
            let values = part.values.values().into_iter().copied().collect();
            results.push((name.to_owned(), shape, Values::Numbers(values)));
            if own.name == "start" {
                let half = if i == 0 { 0..n } else { n..2 * n };
                let given = self.tape.given.get(half).map(<[bool]>::to_vec).unwrap_or_default();
                let name = if i == 0 { "given" } else { "given_rates" };
                results.push((name.to_owned(), Shape::Booleans(n), Values::Booleans(given)));
            }
        }
        debug_assert!(m == scene.constraints.len());
        results
    }
}

/// The values of a result.
enum Values {
    Numbers(Vec<u32>),
    Booleans(Vec<bool>),
}

impl<'t> Scope<'t> {
    fn new(tape: &'t NamedTape) -> Self {
        Self { tape, names: HashMap::new(), bindings: Vec::new(), bound: HashMap::new() }
    }

    /// Begins with a short name of a struct.
    fn alias(&mut self, name: &str, kind: StructKind, of: Expression) {
        self.bindings.push((Statement::Alias { name: name.to_owned(), kind, of }, false));
    }

    fn name_parameters(&mut self, of: &Expression) {
        let parameters = self.tape.names.range(..place(self.tape.sizes()[0]));
        self.names.extend(parameters.map(|(input, name)| (*input, of.clone().field(name))));
    }

    /// Begins with the names of the fields of a position.
    fn name_fields(&mut self) {
        let position = self.tape.function("position").map(|own| &own.parts[..]).unwrap_or_default();
        for part in position {
            for value in part.values.values() {
                self.name(*value, &part.name, Expression::name("position").field(&part.name));
            }
        }
    }

    /// Begins with the names of what an argument brings.
    fn bind(&mut self, argument: Argument) {
        let [_, n, m] = self.tape.sizes();
        let (list, count) = match argument {
            Argument::Position => return,
            Argument::Time => {
                self.names.insert(self.tape.input(argument), Expression::name("t"));
                return;
            }
            Argument::Angles => {
                for i in 0..n {
                    for (field, input) in [("sin", self.tape.sine(i)), ("cos", self.tape.sine(i) + place(n))] {
                        let name = self.tape.names[&input].clone();
                        self.name(input, &name, Expression::name("angles").field(field).element(i));
                    }
                }
                return;
            }
            Argument::Coordinates => ("q", n),
            Argument::Rates => ("qd", n),
            Argument::Accelerations => ("qdd", n),
            Argument::Multipliers => ("multipliers", m),
            Argument::Residuals => ("residuals", m),
        };
        for i in 0..count {
            let input = self.tape.input(argument) + place(i);
            let name = self.tape.names[&input].clone();
            self.name(input, &name, Expression::name(list).element(i));
        }
    }

    /// A name for a value that stands elsewhere.
    fn name(&mut self, value: u32, name: &str, stands_at: Expression) {
        self.bindings.push((Statement::Let { name: name.to_owned(), value: stands_at }, false));
        self.names.insert(value, Expression::name(name));
        self.bound.insert(value, self.bindings.len() - 1);
    }

    /// The statements of a function.
    fn statements(&mut self, own: &named_tape::Function) -> Vec<Statement> {
        let mut statements = Vec::new();
        for statement in &own.statements {
            statements.extend(statement.comment.iter().map(|text| Statement::Comment(text.clone())));
            let values = self.computed(statement.value);
            for ((name, value), at) in statement.names.iter().zip(values).zip(statement.value..) {
                statements.push(Statement::Let { name: name.clone(), value });
                self.names.insert(at, Expression::name(name));
                self.bound.remove(&at);
            }
        }
        statements
    }

    /// A name for a result that nothing else in the function has.
    fn free(&self, wish: &str, own: &named_tape::Function) -> String {
        let statements = own.statements.iter().flat_map(|statement| &statement.names);
        let bound = self.bindings.iter().map(|(statement, _)| match statement {
            Statement::Alias { name, .. } | Statement::Let { name, .. } => name,
            _ => unreachable!("functions begin with names"),
        });
        let taken: Vec<&String> = statements.chain(bound).collect();
        let arguments = ["m", "p", "t", "q", "qd", "qdd", "multipliers", "residuals", "angles", "position"];
        let is_argument = |name: &str| {
            arguments.contains(&name) && own.arguments.iter().any(|argument| argument_name(*argument) == name)
        };
        let mut name = wish.to_owned();
        while taken.contains(&&name) || is_argument(&name) {
            name.push('_');
        }
        name
    }

    /// Sets the places of a result.
    fn fill(&mut self, statements: &mut Vec<Statement>, name: &str, shape: Shape, values: &[u32]) {
        let at = |i: usize| match shape {
            Shape::Matrix(_, columns) => Expression::name(name).element(i / columns).element(i % columns),
            Shape::Vector(_) => Expression::name(name).element(i),
            _ => Expression::name(name),
        };
        let is_zero = |value: u32| self.tape.is_zero(value);
        let filled = values.iter().filter(|value| !is_zero(**value)).count();
        let is_sparse = matches!(shape, Shape::Matrix(..)) && crate::rust::is_sparse(values.len(), filled);
        if is_sparse {
            statements.push(Statement::Clear { place: Expression::name(name), shape });
        }
        for (i, value) in values.iter().enumerate() {
            if !(is_sparse && self.tape.is_zero(*value)) {
                statements.push(Statement::Assign { place: at(i), value: self.value(*value) });
            }
        }
    }

    /// A value, by name if it has one.
    fn value(&mut self, value: u32) -> Expression {
        if let Some(name) = self.names.get(&value) {
            if let Some(&binding) = self.bound.get(&value) {
                self.bindings[binding].1 = true;
            }
            return name.clone();
        }
        self.computed(value).remove(0)
    }

    /// The operation that computes a value; for a sine with its cosine, both.
    fn computed(&mut self, value: u32) -> Vec<Expression> {
        match self.tape.values()[value as usize] {
            Value::Operation(operation) => expression::expressions(operation, |operand| self.value(operand)),
            Value::Input | Value::Cosine => unreachable!("inputs and cosines have names"),
        }
    }
}

fn argument_name(argument: Argument) -> &'static str {
    match argument {
        Argument::Position => "position",
        Argument::Time => "t",
        Argument::Coordinates => "q",
        Argument::Rates => "qd",
        Argument::Accelerations => "qdd",
        Argument::Multipliers => "multipliers",
        Argument::Residuals => "residuals",
        Argument::Angles => "angles",
    }
}
