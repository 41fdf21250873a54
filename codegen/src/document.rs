//! Scene text to a syntax tree with places. The only module that knows TOML.

mod table;

use crate::diagnostic::{Diagnostic, Span};
use crate::names::is_identifier;
use crate::parser::{Condition, Formula};
use table::{Reader, Table};

/// A scene file as written: every formula parsed, no name looked up.
#[derive(Debug, Default)]
pub struct Document {
    /// The scene's name.
    pub name: Identifier,
    /// What the scene is, for people.
    pub doc: String,
    /// The generalized coordinates, in the order of q.
    pub coordinates: Vec<CoordinateSyntax>,
    /// `[parameters]`
    pub parameters: Vec<ParameterSyntax>,
    /// `[points]`
    pub points: Vec<(Identifier, [Formula; 2])>,
    /// `[bodies]`
    pub bodies: Vec<BodySyntax>,
    /// `[constraints]`
    pub constraints: Vec<ConstraintSyntax>,
    /// `[loads]`
    pub loads: Vec<(Identifier, LoadSyntax)>,
    /// `[initial] given`
    pub given: Vec<(Identifier, Formula)>,
    /// `[initial] solve`
    pub solve: Vec<(Identifier, Formula)>,
    /// Where the given values stand.
    pub given_span: Span,
    /// `[outputs]`
    pub outputs: Vec<OutputSyntax>,
    /// `[run]`
    pub run: RunSyntax,
}

/// A name and its place.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Identifier {
    /// The name.
    pub name: String,
    /// Where it stands.
    pub span: Span,
}

/// An entry of `coordinates`.
#[derive(Debug)]
pub struct CoordinateSyntax {
    /// Its name.
    pub identifier: Identifier,
    /// Its unit.
    pub unit: String,
    /// What it is.
    pub doc: String,
}

/// An entry of `[parameters]`.
#[derive(Debug)]
pub struct ParameterSyntax {
    /// Its name.
    pub identifier: Identifier,
    /// Its value.
    pub value: Formula,
    /// Its unit.
    pub unit: String,
    /// What it is.
    pub doc: String,
    /// Whether it is kept in the generated code even when it is zero.
    pub runtime: bool,
}

/// An entry of `[bodies]`.
#[derive(Debug)]
pub struct BodySyntax {
    /// Its name.
    pub identifier: Identifier,
    /// Mass.
    pub mass: Option<Formula>,
    /// Position of the centre of mass.
    pub com: Option<Position>,
    /// Orientation.
    pub angle: Option<Formula>,
    /// Moment of inertia about the centre of mass.
    pub inertia: Option<Formula>,
}

/// A place in the plane: a named point or two formulae.
#[derive(Debug)]
pub enum Position {
    /// The name of a point.
    Point(Identifier),
    /// Abscissa and ordinate.
    Pair([Formula; 2]),
}

/// An entry of `[constraints]`.
#[derive(Debug)]
pub struct ConstraintSyntax {
    /// Its name.
    pub identifier: Identifier,
    /// What must be zero.
    pub residual: Formula,
    /// Unit of the residual.
    pub unit: String,
    /// What it is.
    pub doc: String,
}

/// What an entry of `[loads]` says.
#[derive(Debug)]
pub enum LoadSyntax {
    /// A force on a point, or on the centre of mass of a body.
    Force {
        /// Its components.
        force: [Formula; 2],
        /// The point.
        target: Target,
    },
    /// A torque on a body.
    Torque {
        /// Its size, counter-clockwise.
        torque: Formula,
        /// The body.
        body: Identifier,
    },
    /// A field of acceleration on every mass.
    Gravity([Formula; 2]),
    /// A spring and a damper along a length or an angle.
    Spring {
        /// The length or angle.
        along: Formula,
        /// Stiffness.
        stiffness: Option<Formula>,
        /// Where the spring is slack.
        rest: Option<Formula>,
        /// Damping coefficient.
        damping: Option<Formula>,
    },
}

/// What something acts on.
#[derive(Debug)]
pub enum Target {
    /// `at = "point"`
    Point(Identifier),
    /// `on = "body"`
    Body(Identifier),
}

/// An entry of `[outputs]`.
#[derive(Debug)]
pub struct OutputSyntax {
    /// Its name.
    pub identifier: Identifier,
    /// What is computed.
    pub value: OutputValue,
    /// Its unit.
    pub unit: String,
    /// What it is.
    pub doc: String,
}

/// What an output is made of.
#[derive(Debug)]
pub enum OutputValue {
    /// A formula of coordinates.
    Value(Formula),
    /// The time derivative of one.
    Rate(Formula),
    /// The second time derivative of one.
    SecondRate(Formula),
    /// The physical force of a constraint on a point along a direction, or its moment on a body.
    Reaction {
        /// The constraint.
        constraint: Identifier,
        /// What the force acts on.
        target: Target,
        /// The direction; none for a moment.
        along: Option<[Formula; 2]>,
    },
}

/// `[run]`
#[derive(Debug, Default)]
pub struct RunSyntax {
    /// Step of the integration.
    pub step: Option<Formula>,
    /// When to stop.
    pub until: Option<Condition<String>>,
    /// When to stop at the latest.
    pub max_time: Option<Formula>,
    /// A fixed end.
    pub end_time: Option<Formula>,
    /// Where the table begins.
    pub span: Span,
}

impl Document {
    /// Reads a scene's text, and reports everything that is wrong with its form.
    pub fn parse(source: &str) -> (Self, Vec<Diagnostic>) {
        let mut reader = Reader::new(source);
        let mut document = Self::default();
        if source.trim().is_empty() {
            reader.findings.push(
                Diagnostic::whole_file("the scene is empty")
                    .help("a scene begins with `name = \"...\"` and `coordinates = [...]`"),
            );
            return (document, reader.findings);
        }
        let parsed = table::parse(source, &mut reader.findings);
        if reader.findings.is_empty() {
            document.read(&mut reader, &parsed);
        }
        (document, reader.findings)
    }

    fn read(&mut self, r: &mut Reader, root: &table::Root) {
        let mut root = root.table();
        if let Some(name) = root.required(r, "name").and_then(|v| r.text(v)) {
            if !name.name.starts_with(|c: char| c.is_ascii_alphabetic())
                || !name.name.chars().all(|c| c.is_ascii_alphanumeric() || c == '-' || c == '_')
            {
                r.findings.push(
                    Diagnostic::error(format!("`{}` cannot be the name of a scene", name.name), name.span.clone(), "")
                        .help("use letters, digits, `-` and `_`, beginning with a letter"),
                );
            }
            self.name = name;
        }
        self.doc = root.string(r, "doc");
        for value in root.required(r, "coordinates").map(|v| r.array(v)).unwrap_or_default() {
            self.coordinates.extend(coordinate(r, value));
        }
        for (identifier, value) in root.entries(r, "parameters") {
            self.parameters.extend(parameter(r, identifier, value));
        }
        for (identifier, value) in root.entries(r, "points") {
            let position = r.pair(value);
            self.points.push((identifier, position));
        }
        for (identifier, value) in root.entries(r, "bodies") {
            self.bodies.extend(body(r, identifier, value));
        }
        for (identifier, value) in root.entries(r, "constraints") {
            self.constraints.extend(constraint(r, identifier, value));
        }
        for (identifier, value) in root.entries(r, "loads") {
            if let Some(load) = load(r, &identifier, value) {
                self.loads.push((identifier, load));
            }
        }
        self.read_initial(r, &mut root);
        for (identifier, value) in root.entries(r, "outputs") {
            self.outputs.extend(output(r, identifier, value));
        }
        self.read_run(r, &mut root);
        root.finish(r);
    }

    fn read_initial(&mut self, r: &mut Reader, root: &mut Table) {
        let Some(value) = root.required(r, "initial") else { return };
        let Some(initial) = r.table("[initial]", value) else { return };
        if let Some(given) = initial.required(r, "given") {
            self.given_span = given.span();
            self.given = values(r, "given", given);
        }
        if let Some(solve) = initial.optional("solve") {
            self.solve = values(r, "solve", solve);
        }
        initial.finish(r);
    }

    fn read_run(&mut self, r: &mut Reader, root: &mut Table) {
        let Some(value) = root.required(r, "run") else { return };
        self.run.span = value.span();
        let Some(run) = r.table("[run]", value) else { return };
        self.run.step = run.required(r, "step").map(|v| r.formula(v));
        self.run.until = run.optional("until").and_then(|v| r.condition(v));
        self.run.max_time = run.optional("max_time").map(|v| r.formula(v));
        self.run.end_time = run.optional("end_time").map(|v| r.formula(v));
        run.finish(r);
    }
}

fn coordinate(r: &mut Reader, value: table::Value) -> Option<CoordinateSyntax> {
    let syntax = if value.is_table() {
        let table = r.table("a coordinate", value)?;
        let identifier = table.required(r, "name").and_then(|v| r.text(v));
        let (unit, doc) = (table.string(r, "unit"), table.string(r, "doc"));
        table.finish(r);
        CoordinateSyntax { identifier: identifier?, unit, doc }
    } else {
        CoordinateSyntax { identifier: r.text(value)?, unit: String::new(), doc: String::new() }
    };
    r.check_name(&syntax.identifier, "coordinate");
    Some(syntax)
}

fn parameter(r: &mut Reader, identifier: Identifier, value: table::Value) -> Option<ParameterSyntax> {
    if !value.is_table() {
        let value = r.formula(value);
        return Some(ParameterSyntax { identifier, value, unit: String::new(), doc: String::new(), runtime: false });
    }
    let table = r.table(&format!("parameter `{}`", identifier.name), value)?;
    let value = table.required(r, "value").map_or_else(table::placeholder, |v| r.formula(v));
    let (unit, doc) = (table.string(r, "unit"), table.string(r, "doc"));
    let runtime = table.optional("runtime").is_some_and(|v| r.boolean(v));
    table.finish(r);
    Some(ParameterSyntax { identifier, value, unit, doc, runtime })
}

fn body(r: &mut Reader, identifier: Identifier, value: table::Value) -> Option<BodySyntax> {
    let table = r.table(&format!("body `{}`", identifier.name), value)?;
    let syntax = BodySyntax {
        mass: table.optional("mass").map(|v| r.formula(v)),
        com: table.optional("com").and_then(|v| {
            if v.is_array() { Some(Position::Pair(r.pair(v))) } else { r.text(v).map(Position::Point) }
        }),
        angle: table.optional("angle").map(|v| r.formula(v)),
        inertia: table.optional("inertia").map(|v| r.formula(v)),
        identifier,
    };
    table.string(r, "doc");
    table.finish(r);
    Some(syntax)
}

fn constraint(r: &mut Reader, identifier: Identifier, value: table::Value) -> Option<ConstraintSyntax> {
    let table = r.table(&format!("constraint `{}`", identifier.name), value)?;
    let residual = table.required(r, "residual").map_or_else(table::placeholder, |v| r.formula(v));
    let (unit, doc) = (table.string(r, "unit"), table.string(r, "doc"));
    table.finish(r);
    Some(ConstraintSyntax { identifier, residual, unit, doc })
}

fn load(r: &mut Reader, identifier: &Identifier, value: table::Value) -> Option<LoadSyntax> {
    let table = r.table(&format!("load `{}`", identifier.name), value)?;
    table.string(r, "doc");
    let kind = table.one_of(r, &["force", "torque", "gravity", "along"], "along = '...', spring = '...', rest = '...', damper = '...'")?;
    let load = match kind {
        "force" => {
            let force = table.required(r, "force").map(|v| r.pair(v))?;
            let target = table.target(r);
            target.map(|target| LoadSyntax::Force { force, target })
        }
        "torque" => {
            let torque = table.required(r, "torque").map(|v| r.formula(v))?;
            let body = table.required(r, "on").and_then(|v| r.text(v));
            body.map(|body| LoadSyntax::Torque { torque, body })
        }
        "gravity" => table.required(r, "gravity").map(|v| LoadSyntax::Gravity(r.pair(v))),
        _ => {
            let along = table.required(r, "along").map(|v| r.formula(v))?;
            let stiffness = table.optional("spring").map(|v| r.formula(v));
            let rest = table.optional("rest").map(|v| r.formula(v));
            let damping = table.optional("damper").map(|v| r.formula(v));
            if stiffness.is_none() && damping.is_none() {
                let help = "add `spring = '...'` or `damper = '...'`";
                r.findings.push(
                    Diagnostic::error(format!("load `{}` has no size", identifier.name), identifier.span.clone(), "")
                        .help(help),
                );
            }
            Some(LoadSyntax::Spring { along, stiffness, rest, damping })
        }
    };
    table.finish(r);
    load
}

fn output(r: &mut Reader, identifier: Identifier, value: table::Value) -> Option<OutputSyntax> {
    if !value.is_table() {
        let value = OutputValue::Value(r.formula(value));
        return Some(OutputSyntax { identifier, value, unit: String::new(), doc: String::new() });
    }
    let table = r.table(&format!("output `{}`", identifier.name), value)?;
    let (unit, doc) = (table.string(r, "unit"), table.string(r, "doc"));
    let kind = table.one_of(r, &["value", "rate", "second_rate", "reaction"], "")?;
    let asked = table.required(r, kind)?;
    let value = match kind {
        "value" => Some(OutputValue::Value(r.formula(asked))),
        "rate" => Some(OutputValue::Rate(r.formula(asked))),
        "second_rate" => Some(OutputValue::SecondRate(r.formula(asked))),
        _ => {
            let constraint = r.text(asked);
            let target = table.target(r);
            let along = match target {
                Some(Target::Point(_)) => table.required(r, "along").map(|v| r.pair(v)),
                _ => table.optional("along").map(|v| r.pair(v)),
            };
            constraint.zip(target).map(|(constraint, target)| OutputValue::Reaction { constraint, target, along })
        }
    };
    table.finish(r);
    Some(OutputSyntax { identifier, value: value?, unit, doc })
}

fn values(r: &mut Reader, what: &str, value: table::Value) -> Vec<(Identifier, Formula)> {
    let Some(table) = r.table(what, value) else { return Vec::new() };
    table.all().into_iter().map(|(identifier, value)| (identifier, r.formula(value))).collect()
}

impl Reader<'_> {
    /// Reports a name that could not stand in a formula.
    fn check_name(&mut self, identifier: &Identifier, what: &str) {
        if !is_identifier(&identifier.name) {
            self.findings.push(
                Diagnostic::error(
                    format!("`{}` cannot be the name of a {what}", identifier.name),
                    identifier.span.clone(),
                    "not a name",
                )
                .help("use letters, digits and `_`, beginning with a letter"),
            );
        }
    }
}
