//! Loads on a mechanism, and the outputs asked of it.

use super::points::point_value;
use super::{Context, Resolver};
use crate::diagnostic::Diagnostic;
use crate::document::{Document, Identifier, LoadSyntax, OutputValue, Target};
use crate::expression::{Expression, Node};
use crate::parser::Formula;
use crate::scene::{LoadKind, Output, OutputKind, Quantity, Scene};

impl Resolver<'_> {
    pub(super) fn load(&mut self, scene: &Scene, load: &LoadSyntax) -> Option<LoadKind> {
        Some(match load {
            LoadSyntax::Force { force, target } => {
                let at = match target {
                    Target::Point(point) => self.point(point).map(|i| point_value(i, point.span.clone())),
                    Target::Body(name) => {
                        let body = self.body_named(scene, name)?;
                        if body.com.is_none() {
                            self.findings.push(
                                Diagnostic::error(
                                    format!("body `{}` has no position for a force to act on", name.name),
                                    name.span.clone(),
                                    "has no `com`",
                                )
                                .help("give the body a `com`, or name a point with `at`"),
                            );
                        }
                        body.com
                    }
                };
                let force = [self.value(&force[0], Context::Load), self.value(&force[1], Context::Load)];
                LoadKind::Force { force, at: at? }
            }
            LoadSyntax::Torque { torque, body: name } => {
                let torque = self.value(torque, Context::Load);
                let body = self.body_named(scene, name)?;
                if body.angle.is_none() {
                    self.findings.push(
                        Diagnostic::error(
                            format!("body `{}` has no angle for a torque to work on", name.name),
                            name.span.clone(),
                            "has no `angle`",
                        )
                        .help("give the body an `angle`"),
                    );
                }
                LoadKind::Torque { torque, angle: body.angle? }
            }
            LoadSyntax::Gravity(field) => {
                LoadKind::Gravity([self.value(&field[0], Context::Constant), self.value(&field[1], Context::Constant)])
            }
            LoadSyntax::Spring { along, stiffness, rest, damping } => LoadKind::Spring {
                along: self.value(along, Context::Geometry),
                stiffness: stiffness.as_ref().map(|f| self.value(f, Context::Constant)),
                rest: rest.as_ref().map(|f| self.value(f, Context::Constant)),
                damping: damping.as_ref().map(|f| self.value(f, Context::Constant)),
            },
        })
    }

    pub(super) fn outputs(&mut self, document: &Document, scene: &mut Scene) {
        for syntax in &document.outputs {
            let kind = match &syntax.value {
                OutputValue::Value(f) => Some(OutputKind::Value(self.value(f, Context::Geometry))),
                OutputValue::Rate(f) => Some(OutputKind::Rate(self.value(f, Context::Geometry))),
                OutputValue::SecondRate(f) => Some(OutputKind::SecondRate(self.value(f, Context::Geometry))),
                OutputValue::Reaction { constraint, target, along } => {
                    self.reaction(scene, constraint, target, along.as_ref())
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
