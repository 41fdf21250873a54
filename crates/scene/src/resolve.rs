//! Resolves a syntax tree into a scene: looks up every name, checks every rule of the format, and reports all errors.

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
mod run;
mod scope;
mod start;
mod usage;
mod values;

pub(crate) use check::misfit;
pub use run::constant_condition;
pub use usage::all_values;
pub use usage::motion_values;

use crate::declarations::Declarations;
use crate::diagnostic::{Diagnostic, Report};
use crate::document::{Document, Identifier};
use crate::evaluate::parameter_values;
use crate::linkage;
use crate::parser::Condition;
use crate::scene::{Body, Constraint, Load, Near, Parameter, Quantity, Scene};
use context::Context;
use points::point_order;
use scope::{Kind, Scope};

/// Reads a scene. `path` is used in messages only.
///
/// # Errors
/// A report of all errors of the scene.
pub fn read(path: &str, source: &str) -> Result<(Scene, Report), Report> {
    read_with(path, source, &|_| None)
}

/// Reads a scene in which some parameters have other values.
///
/// # Errors
/// A report of all errors of the scene with these values.
pub fn read_with(path: &str, source: &str, replace: &dyn Fn(&str) -> Option<f64>) -> Result<(Scene, Report), Report> {
    let (mut document, mut findings) = Document::parse(source);
    if limits::are_too_many(&document, &mut findings) {
        return Err(Report::new(path, source, findings));
    }
    linkage::expand(&mut document, &mut findings);
    let has_unread_declarations = document.has_unread_declarations;
    let is_well_formed = document.is_well_formed;
    let has_unknown = !findings.is_empty();
    let mut resolver =
        Resolver { source, scope: Scope::default(), findings, has_unread_declarations, is_well_formed, has_unknown };
    let scene = resolver.scene(&document, replace);
    let report = Report::new(path, source, resolver.findings);
    if report.has_errors() { Err(report) } else { Ok((scene, report)) }
}

/// Reads a condition on the names of a scene, such as an argument of the command line.
///
/// # Errors
/// A report of its errors.
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
    let mut resolver = Resolver {
        source: text,
        scope,
        findings,
        has_unread_declarations: false,
        is_well_formed: true,
        has_unknown: false,
    };
    let condition = match crate::parser::parse_condition(text, 0, &declarations(scene)) {
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

/// The names that conditions may contain, with their units.
fn declarations(scene: &Scene) -> Declarations {
    let mut declarations = Declarations::default();
    scene.coordinates.iter().for_each(|own| declarations.declare_coordinate(&own.name, &own.unit));
    scene.parameters.iter().for_each(|own| declarations.declare_parameter(&own.name, &own.unit));
    declarations.declare_energies();
    scene.outputs.iter().for_each(|own| declarations.declare(&own.name, &own.unit));
    declarations
}

struct Resolver<'a> {
    source: &'a str,
    scope: Scope,
    findings: Vec<Diagnostic>,
    /// Whether names may seem unknown because their declaration could not be read.
    has_unread_declarations: bool,
    /// Whether all parts of the scene are present under unique names, and the start is valid.
    is_well_formed: bool,
    /// Whether some name could not be looked up.
    has_unknown: bool,
}

impl Resolver<'_> {
    fn scene(&mut self, document: &Document, replace: &dyn Fn(&str) -> Option<f64>) -> Scene {
        let found = self.findings.len();
        self.declare(document);
        self.is_well_formed &= self.findings.len() == found;
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
            near: self.near(document),
            has_links: !document.links.is_empty(),
        };
        for (identifier, load) in &document.loads {
            if let Some(kind) = self.load(document, &scene, &identifier.name, load) {
                scene.loads.push(Load { name: identifier.name.clone(), kind });
            }
        }
        self.outputs(document, &mut scene);
        if !self.has_unread_declarations {
            number_parameters(&mut scene, replace);
            check::parts(document, &scene, self.source, &mut self.findings);
            friction::check(document, &scene, &mut self.findings);
            self.check_joints(document, &scene);
            self.check_extremes(document, &scene, replace);
        }
        if self.is_well_formed {
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

    fn near(&mut self, document: &Document) -> Vec<Near> {
        let mut found = Vec::new();
        for near in &document.near {
            let place = near.place.each_ref().map(|part| self.value(part, Context::Constant));
            let place_of = |point: &String| self.scope.points().position(|name| name == point);
            let links = near.links.iter().map(|points| points.iter().filter_map(place_of).collect()).collect();
            let joint = near.joint.name.clone();
            found.extend(place_of(&near.point).map(|point| Near { joint, point, links, place }));
        }
        found
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
}

/// Computes the values of parameters, and marks those that are omitted: the value is zero and cannot be anything else.
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
