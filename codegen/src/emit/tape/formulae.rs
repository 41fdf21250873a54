//! Formulae of the scene as operations: values of parameters, the start, the schedule, the stop condition.

use std::collections::HashMap;

use proc_macro2::TokenStream;
use qrm_core::Operation;

use super::section::{Section, call};
use super::{argument_place, place};
use crate::emit::plain::Plain;
use crate::term::Symbol;
use qrm_scene::expression::Node;
use qrm_scene::lexer::Comparison;
use qrm_scene::parser::Condition;
use qrm_scene::scene::{Parameter, Quantity, Scene, Value};

/// The places of what the scene names.
pub(super) struct Names<'s> {
    scene: &'s Scene,
    /// The places of parameters; those that are left out have none.
    parameters: HashMap<usize, u32>,
}

impl<'s> Names<'s> {
    pub(super) fn new(scene: &'s Scene) -> Self {
        let kept = scene.parameters.iter().enumerate().filter(|(_, p)| !p.left_out);
        Self { scene, parameters: kept.zip(0..).map(|((i, _), place)| (i, place)).collect() }
    }

    /// The parameters that have a place, in the order of their places.
    pub(super) fn kept(&self) -> impl Iterator<Item = &'s Parameter> + use<'s> {
        self.scene.parameters.iter().filter(|p| !p.left_out)
    }

    /// The place of a parameter or an argument.
    pub(super) fn symbol(&self, symbol: Symbol) -> Option<u32> {
        match symbol {
            Symbol::Parameter(i) => self.parameters.get(&i).copied(),
            other => argument_place(self.parameters.len(), self.scene.coordinates.len(), other),
        }
    }

    /// The place after all arguments.
    pub(super) fn first_constant(&self) -> u32 {
        place(self.parameters.len() + 1 + 3 * self.scene.coordinates.len() + self.scene.constraints.len())
    }
}

/// A part of a formula: numbers are written down when they are needed as an operand.
#[derive(Clone, Copy)]
enum Part {
    Number(f64),
    Place(u32),
}

impl Section<'_> {
    /// The place of a formula's value.
    pub(super) fn formula(&mut self, names: &Names, value: &Value) -> u32 {
        let part = self.part(names, &HashMap::new(), value);
        self.operand(part)
    }

    /// The place of a value that rises through zero when a condition becomes true.
    pub(super) fn condition(&mut self, names: &Names, condition: &Condition<Quantity>) -> u32 {
        let plain = Plain { scene: names.scene, parameters: TokenStream::new(), number: TokenStream::new() };
        let mut points = HashMap::new();
        for quantity in plain.quantities(&condition.difference) {
            if let Quantity::Point(point, axis) = quantity {
                let position = self.part(names, &points, &names.scene.points[point].position[axis]);
                points.insert((point, axis), position);
            }
        }
        let difference = self.part(names, &points, &condition.difference);
        let difference = self.operand(difference);
        match condition.comparison {
            Comparison::GreaterOrEqual => difference,
            Comparison::LessOrEqual => self.push(Operation::Neg(difference)),
        }
    }

    fn operand(&mut self, part: Part) -> u32 {
        match part {
            Part::Number(value) => self.number(value),
            Part::Place(place) => place,
        }
    }

    fn part(&mut self, names: &Names, points: &HashMap<(usize, usize), Part>, value: &Value) -> Part {
        let mut parts: Vec<Part> = Vec::with_capacity(value.nodes().len());
        for node in value.nodes() {
            let part = match node {
                Node::Number(number) => Part::Number(number.value),
                Node::Name(quantity) => self.name(names, points, *quantity),
                Node::Power(a, b) => {
                    let base = self.operand(parts[*a]);
                    Part::Place(match value.nodes()[*b] {
                        Node::Number(ref n) if n.value.fract() == 0.0 && n.value <= 1024.0 => {
                            self.push(Operation::PowI(base, n.value as i32))
                        }
                        _ => {
                            let exponent = self.operand(parts[*b]);
                            self.push(Operation::Pow(base, exponent))
                        }
                    })
                }
                other => {
                    let operands: Vec<u32> = other.operands().into_iter().map(|i| self.operand(parts[i])).collect();
                    let (a, b) = (operands[0], operands[operands.len() - 1]);
                    Part::Place(self.push(match other {
                        Node::Add(..) => Operation::Add(a, b),
                        Node::Subtract(..) => Operation::Sub(a, b),
                        Node::Multiply(..) => Operation::Mul(a, b),
                        Node::Divide(..) => Operation::Div(a, b),
                        Node::Call(function, _) => call(*function, &operands),
                        _ => Operation::Neg(a),
                    }))
                }
            };
            parts.push(part);
        }
        parts.pop().unwrap_or_else(|| unreachable!("a formula has a value"))
    }

    fn name(&mut self, names: &Names, points: &HashMap<(usize, usize), Part>, quantity: Quantity) -> Part {
        let symbol = match quantity {
            Quantity::Parameter(i) => Symbol::Parameter(i),
            Quantity::Coordinate(i) => Symbol::Coordinate(i),
            Quantity::Rate(i) => Symbol::Rate(i),
            Quantity::Time => Symbol::Time,
            Quantity::Pi => return Part::Place(self.push(Operation::Pi)),
            Quantity::Point(point, axis) => return points[&(point, axis)],
            // The resolver lets no rate of a point into these formulae, and no scene with unknown names gets here.
            Quantity::PointRate(..) | Quantity::Stretch | Quantity::StretchRate | Quantity::Unknown => {
                unreachable!("they occur in loads alone")
            }
        };
        // A parameter that is left out is zero.
        names.symbol(symbol).map_or(Part::Number(0.0), Part::Place)
    }
}
