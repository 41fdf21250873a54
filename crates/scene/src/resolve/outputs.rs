//! Resolves outputs.

use super::Resolver;
use super::context::Context;
use crate::diagnostic::Diagnostic;
use crate::document::{DisplacementSyntax, Document, Identifier, OutputSyntax, OutputValue, Target};
use crate::expression::{Expression, Node};
use crate::parser::Formula;
use crate::scene::{Displacement, Output, OutputKind, Quantity, Scene, Slide, Turn, Value};
use crate::unit::Unit;

impl Resolver<'_> {
    /// Resolves an output with the key `power`: the power of a load, or of a constraint that depends on time.
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
            if !scene.depends_on_time([residual]) {
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
        // Loads with errors are not in the scene.
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
                OutputValue::FreeBody { displacements, multipliers, loads } => {
                    self.free_body(document, scene, displacements, [multipliers, loads])
                }
                OutputValue::ShakingForce([x, y]) => {
                    Some(OutputKind::ShakingForce([x, y].map(|f| self.value(f, Context::Geometry))))
                }
                OutputValue::ShakingMoment(point) => self.point(point).map(OutputKind::ShakingMoment),
                OutputValue::Norm { components, at } => {
                    let at = at.as_ref().map_or(Some(None), |at| self.point(at).map(Some));
                    let components = self.components(scene, components, &syntax.identifier);
                    at.zip(components).map(|(at, components)| OutputKind::Norm { components, at })
                }
                OutputValue::Joint { joint, .. } => {
                    self.find("joint", joint, &[]);
                    None
                }
            };
            let scale = Unit::parse(&syntax.unit).and_then(|unit| unit.inverse_factor());
            let scale = match &kind {
                Some(OutputKind::Norm { components, .. }) => {
                    self.check_unit_of_norm(syntax, components.map(|i| &*scene.outputs[i].unit));
                    None
                }
                _ => scale.map(|scale| self.value(&scale, Context::Constant)),
            };
            scene.outputs.extend(kind.map(|kind| Output {
                name: syntax.identifier.name.clone(),
                unit: syntax.unit.clone(),
                scale,
                doc: syntax.doc.clone(),
                kind,
            }));
        }
    }

    /// Reports a norm whose unit has another factor than the units of its components.
    fn check_unit_of_norm(&mut self, syntax: &OutputSyntax, components: [&str; 2]) {
        let factor = |unit: &str| Unit::parse(unit).map(|unit| unit.factor());
        if components.iter().all(|unit| factor(unit) == factor(&syntax.unit)) {
            return;
        }
        let title = format!("output `{}` has another unit than its components", syntax.identifier.name);
        let error = Diagnostic::error(title, syntax.identifier.span.clone(), format!("in `{}`", syntax.unit));
        let [x, y] = components;
        self.findings.push(error.help(format!("the components are in `{x}` and `{y}`: write one unit for all")));
    }

    fn free_body(
        &mut self,
        document: &Document,
        scene: &Scene,
        displacements: &[DisplacementSyntax],
        [multipliers, loads]: [&[(Identifier, Formula)]; 2],
    ) -> Option<OutputKind> {
        let displacements: Vec<_> = displacements.iter().map(|own| self.displacement(scene, own)).collect();
        let constraints: Vec<&str> = scene.constraints.iter().map(|c| c.name.as_str()).collect();
        // Loads with errors are not in the scene.
        let known: Vec<&str> = document.loads.iter().map(|(identifier, _)| identifier.name.as_str()).collect();
        let mut factors = |what: &str, own: &[(Identifier, Formula)], names: &[&str]| -> Vec<Option<(usize, Value)>> {
            let factor = |(name, factor): &(Identifier, Formula)| {
                let factor = self.value(factor, Context::Geometry);
                Some((self.find(what, name, names)?, factor))
            };
            own.iter().map(factor).collect()
        };
        let multipliers = factors("constraint", multipliers, &constraints);
        let loads = factors("load", loads, &known);
        Some(OutputKind::FreeBody {
            displacements: displacements.into_iter().collect::<Option<_>>()?,
            multipliers: multipliers.into_iter().collect::<Option<_>>()?,
            loads: loads.into_iter().collect::<Option<_>>()?,
        })
    }

    fn displacement(&mut self, scene: &Scene, own: &DisplacementSyntax) -> Option<Displacement> {
        let bodies: Vec<&str> = scene.bodies.iter().map(|body| body.name.as_str()).collect();
        let bodies: Vec<_> = own.bodies.iter().map(|body| self.find("body", body, &bodies)).collect();
        let points: Vec<_> = own.points.iter().map(|point| self.point(point)).collect();
        let along = own.along.as_ref().map(|along| [0, 1].map(|axis| self.value(&along[axis], Context::Geometry)));
        let coordinates: Vec<&str> = scene.coordinates.iter().map(|c| c.name.as_str()).collect();
        let turn = own.turn.as_ref().map(|(size, about, angle)| {
            let size = self.value(size, Context::Geometry);
            let about = self.point(about);
            let angle =
                angle.as_ref().map_or(Some(None), |angle| self.find("coordinate", angle, &coordinates).map(Some));
            Some(Turn { size, about: about?, angle: angle? })
        });
        let slide = own.slide.as_ref().map(|(size, coordinate)| {
            let size = self.value(size, Context::Geometry);
            Some(Slide { size, coordinate: self.find("coordinate", coordinate, &coordinates)? })
        });
        Some(Displacement {
            bodies: bodies.into_iter().collect::<Option<_>>()?,
            points: points.into_iter().collect::<Option<_>>()?,
            along,
            turn: turn.map_or(Some(None), |turn| turn.map(Some))?,
            slide: slide.map_or(Some(None), |slide| slide.map(Some))?,
        })
    }

    fn components(&mut self, scene: &Scene, outputs: &[Identifier], own: &Identifier) -> Option<[usize; 2]> {
        let names: Vec<&str> = scene.outputs.iter().map(|output| output.name.as_str()).collect();
        let outputs = outputs.iter().map(|output| self.find("output", output, &names)).collect::<Option<Vec<_>>>()?;
        let pair = <[usize; 2]>::try_from(outputs).ok();
        if pair.is_none() {
            let title = format!("output `{}` is not the norm of two outputs", own.name);
            let error = Diagnostic::error(title, own.span.clone(), "needs two");
            self.findings.push(error.help("write `norm = [\"OUTPUT\", \"OUTPUT\"]` with outputs above it"));
        }
        pair
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
                if !scene.coordinates_of([residual]).contains(&coordinate) {
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
