//! The resolution of outputs.

use super::{Context, Resolver};
use crate::diagnostic::Diagnostic;
use crate::document::{Document, Identifier, OutputValue, Target};
use crate::expression::{Expression, Node};
use crate::parser::Formula;
use crate::scene::{Output, OutputKind, Quantity, Scene};

impl Resolver<'_> {
    /// What is named by an output's `power`.
    fn power(&mut self, document: &Document, scene: &Scene, identifier: &Identifier) -> Option<OutputKind> {
        let place = |names: &[&str]| names.iter().position(|name| *name == identifier.name);
        let constraints: Vec<&str> = scene.constraints.iter().map(|c| c.name.as_str()).collect();
        if place(&constraints).is_some() && scene.loads.iter().any(|load| load.name == identifier.name) {
            let title = format!("`{}` is a load and a constraint", identifier.name);
            let error = Diagnostic::error(title, identifier.span.clone(), "which power is meant?");
            self.findings.push(error.help("give one of them another name"));
        }
        if let Some(constraint) = place(&constraints) {
            let residual = &scene.constraints[constraint].residual;
            if !scene.depends_on_time(residual) {
                let title = format!("constraint `{}` does no work", identifier.name);
                self.findings.push(
                    Diagnostic::error(title, identifier.span.clone(), "its power is always zero")
                        .context(residual.whole_span(), "does not depend on `t`")
                        .help("name a load, or a constraint that depends on time"),
                );
            }
            return Some(OutputKind::DrivePower(constraint));
        }
        let loads: Vec<&str> = document.loads.iter().map(|(identifier, _)| identifier.name.as_str()).collect();
        self.find("load", identifier, &loads)?;
        // Loads with mistakes are not in the scene.
        scene.loads.iter().position(|load| load.name == identifier.name).map(OutputKind::LoadPower)
    }

    pub(super) fn outputs(&mut self, document: &Document, scene: &mut Scene) {
        for syntax in &document.outputs {
            let kind = match &syntax.value {
                OutputValue::Value(f) => Some(OutputKind::Value(self.value(f, Context::Load))),
                OutputValue::Rate(f) => Some(OutputKind::Rate(self.value(f, Context::Geometry))),
                OutputValue::SecondRate(f) => Some(OutputKind::SecondRate(self.value(f, Context::Geometry))),
                OutputValue::Power(name) => self.power(document, scene, name),
                OutputValue::Reaction { constraint, target, along } => {
                    self.reaction(scene, constraint, target, along.as_ref())
                }
                OutputValue::FreeBody { bodies, points, along } => self.free_body(scene, bodies, points, along),
                OutputValue::Norm(outputs) => self.norm(scene, outputs, &syntax.identifier),
                OutputValue::Joint(joint) => {
                    self.find("joint", joint, &[]);
                    None
                }
            };
            scene.outputs.extend(kind.map(|kind| Output {
                name: syntax.identifier.name.clone(),
                unit: syntax.unit.clone(),
                doc: syntax.doc.clone(),
                kind,
            }));
        }
    }

    fn free_body(
        &mut self,
        scene: &Scene,
        bodies: &[Identifier],
        points: &[Identifier],
        along: &[Formula; 2],
    ) -> Option<OutputKind> {
        let along = [self.value(&along[0], Context::Geometry), self.value(&along[1], Context::Geometry)];
        let names: Vec<&str> = scene.bodies.iter().map(|body| body.name.as_str()).collect();
        let bodies: Vec<Option<usize>> = bodies.iter().map(|body| self.find("body", body, &names)).collect();
        let points: Vec<Option<usize>> = points.iter().map(|point| self.point(point)).collect();
        let all = |places: Vec<Option<usize>>| places.into_iter().collect::<Option<Vec<usize>>>();
        Some(OutputKind::FreeBody { bodies: all(bodies)?, points: all(points)?, along })
    }

    fn norm(&mut self, scene: &Scene, outputs: &[Identifier], own: &Identifier) -> Option<OutputKind> {
        let names: Vec<&str> = scene.outputs.iter().map(|output| output.name.as_str()).collect();
        let outputs = outputs.iter().map(|output| self.find("output", output, &names)).collect::<Option<Vec<_>>>()?;
        let pair = <[usize; 2]>::try_from(outputs).ok();
        if pair.is_none() {
            let title = format!("output `{}` is not the norm of two outputs", own.name);
            let error = Diagnostic::error(title, own.span.clone(), "needs two");
            self.findings.push(error.help("write `norm = [\"OUTPUT\", \"OUTPUT\"]` with outputs above it"));
        }
        pair.map(OutputKind::Norm)
    }

    fn reaction(
        &mut self,
        scene: &Scene,
        constraint: &Identifier,
        target: &Target,
        along: Option<&[Formula; 2]>,
    ) -> Option<OutputKind> {
        let names: Vec<&str> = scene.constraints.iter().map(|c| c.name.as_str()).collect();
        let constraint = self.find("constraint", constraint, &names);
        match target {
            Target::Point(name) => {
                let along = along.map(|[x, y]| [self.value(x, Context::Geometry), self.value(y, Context::Geometry)]);
                let (constraint, point, along) = (constraint?, self.point(name)?, along?);
                let residual = &scene.constraints[constraint].residual;
                if !residual.names().any(|n| matches!(n, Quantity::Point(p, _) if *p == point)) {
                    self.findings.push(
                        Diagnostic::error(
                            format!("constraint `{}` does not act on point `{}`", names[constraint], name.name),
                            name.span.clone(),
                            "its force here is always zero",
                        )
                        .context(residual.whole_span(), "the constraint")
                        .help("name a point that occurs in the constraint's residual"),
                    );
                }
                Some(OutputKind::ReactionForce { constraint, point, along })
            }
            Target::Body(name) => {
                let body = self.body_named(scene, name)?;
                let coordinate = match body.angle.as_ref().map(Expression::nodes) {
                    Some([Node::Name(Quantity::Coordinate(i))]) => *i,
                    _ => {
                        self.findings.push(
                            Diagnostic::error(
                                format!("the angle of body `{}` is not a coordinate", name.name),
                                name.span.clone(),
                                "no moment can be told apart",
                            )
                            .help("ask for the force on a point with `at` and `along`"),
                        );
                        return None;
                    }
                };
                let constraint = constraint?;
                let residual = &scene.constraints[constraint].residual;
                if !scene.coordinates_of(residual).contains(&coordinate) {
                    self.findings.push(
                        Diagnostic::error(
                            format!("constraint `{}` does not act on body `{}`", names[constraint], name.name),
                            name.span.clone(),
                            "its moment here is always zero",
                        )
                        .context(residual.whole_span(), "the constraint")
                        .help("name a body whose angle occurs in the constraint's residual"),
                    );
                }
                Some(OutputKind::ReactionMoment { constraint, coordinate })
            }
        }
    }
}
