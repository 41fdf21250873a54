//! Converts the functions of a tape into functions of a program.

use qrm_core::NamedTape;
use qrm_core::named_tape::{self, Argument, place};
use qrm_scene::scene::Scene;

use super::scope::Scope;
use crate::ir::{Builtin, Expression, Function, Shape, Statement, StructKind, Variable};
use crate::texts;

pub(super) struct Lower<'t> {
    pub(super) tape: &'t NamedTape,
}

impl Lower<'_> {
    /// The functions for the parameters: those of the scene, and those with some values replaced.
    pub(super) fn parameters(&self) -> Vec<Function> {
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

    /// The function for the constants.
    pub(super) fn constants(&self) -> Option<Function> {
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

    /// A function that always returns minus infinity.
    pub(super) fn never(&self, name: &str, doc: &str) -> Function {
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

    pub(super) fn function(&self, own: &named_tape::Function, doc: &str, scene: &Scene) -> Function {
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
            doc: texts::lines(doc),
            arguments: self.arguments(own),
            results,
            body: used.chain(statements).chain(ends).collect(),
        }
    }

    /// The arguments of a function. Functions that steps call have the same arguments for all mechanisms.
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

/// The mechanism as an argument.
fn mechanism() -> Variable {
    Variable { name: "m".to_owned(), shape: Shape::Struct(StructKind::Mechanism) }
}
