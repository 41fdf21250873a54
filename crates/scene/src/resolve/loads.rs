//! Resolves loads.

use super::Resolver;
use super::context::Context;
use super::friction::owner;
use super::points::point_value;
use crate::diagnostic::Diagnostic;
use crate::diagnostic::Span;
use crate::document::{Along, Document, FrictionSyntax, LoadSyntax, SpringSyntax, Target};
use crate::expression::Node;
use crate::function::Function;
use crate::linkage::unknown_frame;
use crate::parser::Formula;
use crate::scene::{Friction, LoadKind, Quantity, Scene, Value};

impl Resolver<'_> {
    pub(super) fn load(
        &mut self,
        document: &Document,
        scene: &Scene,
        name: &str,
        load: &LoadSyntax,
    ) -> Option<LoadKind> {
        Some(match load {
            LoadSyntax::Force { force, frame, target } => {
                // Frames of links have been resolved with the links.
                if let Some(frame) = frame.as_ref().filter(|_| document.links.is_empty()) {
                    self.findings.push(unknown_frame(frame, std::iter::empty()));
                }
                let (at, body) = match target {
                    Target::Point(point) => (self.point(point).map(|i| point_value(i, point.span.clone())), None),
                    Target::Body(name) => {
                        let body = self.body_named(scene, name)?;
                        let number = scene.bodies.iter().position(|other| other.name == body.name);
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
                        (body.com, number)
                    }
                };
                let force = [self.value(&force[0], Context::Load), self.value(&force[1], Context::Load)];
                LoadKind::Force { force, at: at?, body }
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
                        .help("give the body an `angle`; a link has one where its joints let it turn"),
                    );
                }
                let number = scene.bodies.iter().position(|other| other.name == body.name)?;
                LoadKind::Torque { torque, angle: body.angle?, body: number }
            }
            LoadSyntax::Gravity(field) => {
                LoadKind::Gravity([self.value(&field[0], Context::Constant), self.value(&field[1], Context::Constant)])
            }
            LoadSyntax::Spring(spring) => self.spring(document, name, spring)?,
        })
    }

    fn spring(&mut self, document: &Document, name: &str, spring: &SpringSyntax) -> Option<LoadKind> {
        let along = match &spring.along {
            Along::Formula(along) => Some(self.value(along, Context::Geometry)),
            Along::Between(from, to) => {
                let (p, q) = (self.point(from), self.point(to));
                p.zip(q).map(|(p, q)| distance(p, q, from.span.start..to.span.end))
            }
        };
        let mut optional = |f: &Option<Formula>, context| f.as_ref().map(|formula| self.value(formula, context));
        let [stiffness, rest, damping] =
            [&spring.stiffness, &spring.rest, &spring.damping].map(|f| optional(f, Context::Constant));
        let (potential, force) =
            (optional(&spring.potential, Context::Potential), optional(&spring.force, Context::Law));
        let friction = spring.friction.as_ref().map(|own| self.friction(document, name, own));
        let friction = friction.map_or(Some(None), |friction| friction.map(Some));
        Some(LoadKind::Spring { along: along?, stiffness, rest, damping, potential, force, friction: friction? })
    }

    fn friction(&mut self, document: &Document, name: &str, own: &FrictionSyntax) -> Option<Friction> {
        let (size, slip) = (self.value(&own.size, Context::Law), self.value(&own.slip, Context::Constant));
        let outputs: Vec<&str> = document.outputs.iter().map(|output| output.identifier.name.as_str()).collect();
        let normal = own.normal.as_ref().map_or(Some(None), |name| self.find("output", name, &outputs).map(Some));
        Some(Friction { size, slip, normal: normal?, owner: owner(document, name) })
    }
}

/// `hypot(Q.x - P.x, Q.y - P.y)`
fn distance(p: usize, q: usize, span: Span) -> Value {
    let mut value = Value::new();
    let mut push = |node| value.push(node, span.clone());
    let differences = [0, 1].map(|axis| {
        let ends = [p, q].map(|point| push(Node::Name(Quantity::Point(point, axis))));
        push(Node::Subtract(ends[1], ends[0]))
    });
    push(Node::Call(Function::Hypot, differences.to_vec()));
    value
}
