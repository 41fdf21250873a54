//! Syntax tree to scene: every name is looked up, every rule of the format checked, all mistakes reported at once.

mod check;
mod context;
mod drawing;
mod extremes;
mod friction;
mod joints;
mod limits;
mod loads;
mod outputs;
mod points;
mod references;
mod scope;
mod start;
mod usage;

pub use usage::all_values;
pub use usage::motion_values;

use std::collections::HashSet;

use crate::diagnostic::{Diagnostic, MAX_SHOWN, Report, errors};
use crate::document::{Document, Identifier, Position};
use crate::evaluate::parameter_values;
use crate::expression::Node;
use crate::linkage;
use crate::names::suggestion;
use crate::parser::{Condition, Formula};
use crate::scene::{Body, Constraint, Load, Parameter, Quantity, Run, Scene, Value};
use context::Context;
use points::{point_order, point_value};
use scope::{Kind, Scope};

/// Reads a scene. `path` is only for the messages.
///
/// # Errors
/// A report of everything that is wrong with the scene.
pub fn read(path: &str, source: &str) -> Result<(Scene, Report), Report> {
    read_with(path, source, &|_| None)
}

/// Reads a scene in which some parameters have other values.
///
/// # Errors
/// A report of everything that is wrong with the scene, or with these values in it.
pub fn read_with(path: &str, source: &str, replace: &dyn Fn(&str) -> Option<f64>) -> Result<(Scene, Report), Report> {
    let (mut document, mut findings) = Document::parse(source);
    if limits::are_too_many(&document, &mut findings) {
        return Err(Report::new(path, source, findings));
    }
    linkage::expand(&mut document, &mut findings);
    let lost_names = document.lost_names;
    let is_whole = document.is_whole;
    let has_unknown = !findings.is_empty();
    let mut resolver = Resolver { source, scope: Scope::default(), findings, lost_names, is_whole, has_unknown };
    let scene = resolver.scene(&document, replace);
    let report = Report::new(path, source, resolver.findings);
    if report.has_errors() { Err(report) } else { Ok((scene, report)) }
}

/// Reads a condition on the names of a scene, as the command line gives it.
///
/// # Errors
/// A report of what is wrong with it.
pub fn read_condition(scene: &Scene, text: &str) -> Result<Condition<Quantity>, Report> {
    let mut scope = Scope::default();
    let nowhere = |name: &str| Identifier { name: name.to_owned(), span: 0..0 };
    let mut ignored = Vec::new();
    for (i, coordinate) in scene.coordinates.iter().enumerate() {
        scope.declare(&nowhere(&coordinate.name), Kind::Coordinate(i), &mut ignored);
    }
    for (i, parameter) in scene.parameters.iter().enumerate() {
        scope.declare(&nowhere(&parameter.name), Kind::Parameter(i), &mut ignored);
    }
    for (i, point) in scene.points.iter().enumerate() {
        scope.declare(&nowhere(&point.name), Kind::Point(i), &mut ignored);
    }
    scope.declare_results(
        scene.coordinates.iter().map(|coordinate| &*coordinate.name),
        scene.constraints.iter().map(|constraint| &*constraint.name),
        scene.outputs.iter().map(|output| &*output.name),
    );
    let findings = Vec::new();
    let mut resolver =
        Resolver { source: text, scope, findings, lost_names: false, is_whole: true, has_unknown: false };
    let condition = match crate::parser::parse_condition(text, 0, &[]) {
        Ok(condition) => Some(resolver.condition(&condition)),
        Err(finding) => {
            resolver.findings.push(finding);
            None
        }
    };
    match condition {
        Some(condition) if resolver.findings.is_empty() => Ok(condition),
        _ => Err(Report::new("--until", text, resolver.findings)),
    }
}

struct Resolver<'a> {
    source: &'a str,
    scope: Scope,
    findings: Vec<Diagnostic>,
    /// Whether names may seem unknown because their declaration could not be read.
    lost_names: bool,
    /// Whether every part of the scene is there under a name of its own, and the start is sound.
    is_whole: bool,
    /// Whether something could not be looked up.
    has_unknown: bool,
}

impl Resolver<'_> {
    fn scene(&mut self, document: &Document, replace: &dyn Fn(&str) -> Option<f64>) -> Scene {
        let found = self.findings.len();
        self.declare(document);
        self.is_whole &= self.findings.len() == found;
        let parameters = self.parameters(document);
        let points = self.points(document);
        let bodies: Vec<Body> = document.bodies.iter().map(|body| self.body(body)).collect();
        let constraints = self.constraints(document);
        let mut scene = Scene {
            name: document.name.name.clone(),
            name_span: document.name.span.clone(),
            doc: document.doc.clone(),
            coordinates: self.coordinates(document),
            parameters,
            points,
            bodies,
            constraints,
            loads: Vec::new(),
            outputs: Vec::new(),
            drawing: self.drawing(document),
            references: self.references(document),
            extremes: self.extremes(document),
            run: self.run(document),
            four_bars: document.four_bars.clone(),
        };
        for (identifier, load) in &document.loads {
            if let Some(kind) = self.load(document, &scene, &identifier.name, load) {
                scene.loads.push(Load { name: identifier.name.clone(), kind });
            }
        }
        self.outputs(document, &mut scene);
        if !self.lost_names {
            number_parameters(&mut scene, replace);
            check::parts(document, &scene, &mut self.findings);
            friction::check(document, &scene, &mut self.findings);
            self.check_joints(document, &scene);
            self.check_extremes(document, &scene, replace);
        }
        if self.is_whole {
            check::whole(document, &scene, &mut self.findings);
            if !self.has_unknown {
                usage::used(document, &scene, &mut self.findings);
                limits::sizes(&scene, &mut self.findings);
            }
        }
        scene
    }

    fn declare(&mut self, document: &Document) {
        for (i, coordinate) in document.coordinates.iter().enumerate() {
            self.scope.declare(&coordinate.identifier, Kind::Coordinate(i), &mut self.findings);
        }
        for (i, parameter) in document.parameters.iter().enumerate() {
            self.scope.declare(&parameter.identifier, Kind::Parameter(i), &mut self.findings);
        }
        let order = point_order(document);
        if let Err(circle) = &order {
            let names: Vec<&str> = circle.iter().map(|&i| document.points[i].0.name.as_str()).collect();
            let span = document.points[circle[0]].0.span.clone();
            self.findings.push(
                Diagnostic::error(
                    "points defined in a circle",
                    span,
                    format!("{} -> {}", names.join(" -> "), names[0]),
                )
                .help("define one of them by coordinates and parameters alone"),
            );
        }
        for table in &document.tables {
            self.scope.declare_table(table, document, &mut self.findings);
        }
        let order = order.unwrap_or_else(|_| (0..document.points.len()).collect());
        for (place, &i) in order.iter().enumerate() {
            self.scope.declare(&document.points[i].0, Kind::Point(place), &mut self.findings);
        }
        self.scope.declare_results(
            document.coordinates.iter().map(|coordinate| &*coordinate.identifier.name),
            document.constraints.iter().map(|constraint| &*constraint.identifier.name),
            document.outputs.iter().map(|output| &*output.identifier.name),
        );
    }

    fn parameters(&mut self, document: &Document) -> Vec<Parameter> {
        let mut parameters: Vec<Parameter> = Vec::new();
        for (i, syntax) in document.parameters.iter().enumerate() {
            self.scope.parameter_limit = i;
            let formula = self.value(&syntax.value, Context::Constant);
            let text = self.source.get(formula.whole_span()).unwrap_or_default().trim().to_owned();
            parameters.push(Parameter {
                name: syntax.identifier.name.clone(),
                unit: syntax.unit.clone(),
                doc: syntax.doc.clone(),
                formula,
                text,
                value: 0.0,
                runtime: syntax.runtime,
                left_out: false,
            });
        }
        self.scope.parameter_limit = usize::MAX;
        parameters
    }

    fn body(&mut self, syntax: &crate::document::BodySyntax) -> Body {
        let com = syntax.com.as_ref().and_then(|position| self.position(position, Context::Geometry));
        Body {
            name: syntax.identifier.name.clone(),
            mass: syntax.mass.as_ref().map(|f| self.value(f, Context::Constant)),
            com,
            angle: syntax.angle.as_ref().map(|f| self.value(f, Context::Geometry)),
            inertia: syntax.inertia.as_ref().map(|f| self.value(f, Context::Constant)),
        }
    }

    fn position(&mut self, position: &Position, context: Context) -> Option<[Value; 2]> {
        match position {
            Position::Point(point) => self.point(point).map(|i| point_value(i, point.span.clone())),
            Position::Pair([x, y]) => Some([self.value(x, context), self.value(y, context)]),
        }
    }

    fn constraints(&mut self, document: &Document) -> Vec<Constraint> {
        let mut constraints = Vec::new();
        for syntax in &document.constraints {
            let residual = self.value(&syntax.residual, Context::Geometry);
            constraints.push(Constraint {
                name: syntax.identifier.name.clone(),
                span: residual.whole_span(),
                residual,
                unit: syntax.unit.clone(),
                one_sided: syntax.one_sided,
                is_drive: syntax.is_drive,
                doc: syntax.doc.clone(),
            });
        }
        constraints
    }

    fn run(&mut self, document: &Document) -> Run {
        let run = &document.run;
        let missing = || {
            let mut value = Value::new();
            value.push(Node::Number(crate::expression::Number::whole(1)), run.span.clone());
            value
        };
        let mut constant = |f: &Option<Formula>| f.as_ref().map(|f| self.value(f, Context::Constant));
        let step = constant(&run.step).unwrap_or_else(missing);
        let (max_time, end_time) = (constant(&run.max_time), constant(&run.end_time));
        let until = run.until.as_ref().map(|condition| self.condition(condition));
        let wrong = match (&until, &max_time, &end_time) {
            (Some(_), _, Some(_)) => Some((
                "[run] has both `until` and `end_time`",
                "two ends",
                "`until` goes with `max_time`, `end_time` stands alone",
            )),
            (Some(_), None, None) => Some((
                "[run] has `until` but no `max_time`",
                "could run for ever",
                "add `max_time`: a mechanism that stalls never meets its stop condition",
            )),
            (None, Some(_), _) => Some((
                "[run] has `max_time` but no `until`",
                "nothing to wait for",
                "write `end_time` alone, or add `until = '...'` to `max_time`",
            )),
            (None, None, None) => Some((
                "[run] does not say when to end",
                "no end",
                "add `end_time = ...`, or `until = '...'` with `max_time = ...`",
            )),
            (Some(_), Some(_), None) | (None, None, Some(_)) => None,
        };
        if let (Some((title, label, help)), true) = (wrong, run.is_whole) {
            self.findings.push(Diagnostic::error(title, run.span.clone(), label).help(help));
        }
        Run {
            step,
            until,
            end_time: max_time.or(end_time).unwrap_or_else(missing),
            stiff: run.stiff.is_some(),
            inverse: run.inverse.is_some(),
        }
    }

    fn condition(&mut self, condition: &Condition<String>) -> Condition<Quantity> {
        let before = self.findings.len();
        let difference = self.value(&condition.difference, Context::Condition);
        let is_constant = difference.names().all(|name| matches!(name, Quantity::Parameter(_) | Quantity::Pi));
        if is_constant && self.findings.len() == before {
            self.findings.push(
                Diagnostic::error("the stop condition never changes", difference.whole_span(), "nothing moves in it")
                    .help("compare coordinates, points, their rates, outputs or the time `t`"),
            );
        }
        Condition { difference, comparison: condition.comparison }
    }

    /// Looks up every name of a formula and checks what its context forbids.
    fn value(&mut self, formula: &Formula, context: Context) -> Value {
        let mut left = MAX_SHOWN.saturating_sub(errors(&self.findings));
        let (scope, findings, has_unknown) = (&self.scope, &mut self.findings, &mut self.has_unknown);
        let mut reported: HashSet<String> = HashSet::new();
        let value = formula.map(|name, span| {
            // What could not be read was reported where it was read, and of very many errors not all are shown.
            if name.is_empty() || left == 0 {
                *has_unknown |= left == 0;
                return Quantity::Unknown;
            }
            scope.look_up(name, span.clone(), context).unwrap_or_else(|finding| {
                *has_unknown = true;
                // A name that is used again in the same formula is not wrong twice.
                if (scope.knows(name) || !self.lost_names) && reported.insert(name.clone()) {
                    findings.push(finding);
                    left -= 1;
                }
                Quantity::Unknown
            })
        });
        if !matches!(context, Context::Constant | Context::Profile | Context::Picture | Context::Condition) {
            check::differentiable(&value, context == Context::Geometry, &mut self.findings);
        }
        value
    }

    fn find(&mut self, what: &str, identifier: &Identifier, names: &[&str]) -> Option<usize> {
        let place = names.iter().position(|name| *name == identifier.name);
        self.has_unknown |= place.is_none();
        if place.is_none() && !self.lost_names {
            let title = format!("unknown {what} `{}`", identifier.name);
            self.findings.push(Diagnostic::error(title, identifier.span.clone(), "not known").help(near_or_all(
                what,
                &identifier.name,
                names,
            )));
        }
        place
    }

    fn point(&mut self, identifier: &Identifier) -> Option<usize> {
        let names: Vec<String> = self.scope.points().map(str::to_owned).collect();
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        self.find("point", identifier, &names)
    }

    fn body_named(&mut self, scene: &Scene, identifier: &Identifier) -> Option<Body> {
        let names: Vec<&str> = scene.bodies.iter().map(|b| b.name.as_str()).collect();
        self.find("body", identifier, &names).map(|i| scene.bodies[i].clone())
    }
}

/// Help for an unknown name.
fn near_or_all(what: &str, name: &str, known: &[&str]) -> String {
    suggestion(name, known.iter().copied(), || match known {
        [] => format!("the scene has no {what}"),
        _ => format!("known: {}", known.join(", ")),
    })
}

/// Gives parameters their numbers, and tells which of them are left out: those that are zero and can only be zero.
fn number_parameters(scene: &mut Scene, replace: &dyn Fn(&str) -> Option<f64>) {
    let values = parameter_values(scene, replace);
    for (i, value) in values.into_iter().enumerate() {
        let is_fixed = scene.parameters[i].formula.names().all(|name| match name {
            Quantity::Parameter(other) => scene.parameters[*other].left_out,
            _ => true,
        });
        let parameter = &mut scene.parameters[i];
        parameter.value = value;
        parameter.left_out = value == 0.0 && !parameter.runtime && is_fixed;
    }
}
