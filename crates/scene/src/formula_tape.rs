//! Converts the formulae of a scene into operations of a tape.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use qrm_core::named_tape::{self, Argument, ResultField, Shape, Statement};
use qrm_core::{NamedTape, Operation, Tape};

use crate::expression::Node;
use crate::lexer::Comparison;
use crate::parser::Condition;
use crate::scene::{Quantity, Scene, Value};

/// The tape of a condition: its event rises through zero when the condition becomes true. It has the parameters of the
/// scene's tape.
pub fn event_tape(scene: &Scene, condition: &Condition<Quantity>, tape: &NamedTape) -> Tape {
    let mut tape = tape.clone();
    let event = event(scene, condition, &mut tape);
    tape.functions.retain(|function| function.name == "parameters");
    tape.functions.push(event);
    tape.placed()
}

/// The function that rises through zero when a condition becomes true. The tape has the scene's outputs and energies.
pub fn event(scene: &Scene, condition: &Condition<Quantity>, tape: &mut NamedTape) -> named_tape::Function {
    let mut formula = Formula::new(scene, tape);
    let difference = formula.value(&condition.difference);
    let names = formula.names;
    let rising = match condition.comparison {
        Comparison::GreaterOrEqual => difference,
        Comparison::LessOrEqual => tape.negative(difference),
    };
    named_tape::Function {
        name: "event".to_owned(),
        arguments: Argument::STATE.to_vec(),
        statements: statements(tape, rising, names),
        parts: vec![ResultField { name: String::new(), doc: String::new(), values: Shape::Scalar(rising) }],
        ..Default::default()
    }
}

/// A converter of a scene's formulae into operations of a tape.
pub struct Formula<'s> {
    scene: &'s Scene,
    tape: &'s mut NamedTape,
    /// The names of coordinates of points, and of their rates.
    names: BTreeMap<u32, Vec<String>>,
    /// Coordinates of points, and their rates.
    points: HashMap<Quantity, u32>,
}

impl<'s> Formula<'s> {
    /// Starts the formulae of a function.
    pub fn new(scene: &'s Scene, tape: &'s mut NamedTape) -> Self {
        Self { scene, tape, names: BTreeMap::new(), points: HashMap::new() }
    }

    /// Converts a formula; returns the index of its value.
    ///
    /// # Panics
    /// If the formula is empty, or is the law of a load.
    pub fn value(&mut self, value: &Value) -> u32 {
        let value = &value.without_splines();
        let mut values: Vec<u32> = Vec::with_capacity(value.nodes().len());
        for node in value.nodes() {
            let at = |i: &usize| values[*i];
            let result = match node {
                Node::Number(number) => self.tape.number(number.value),
                Node::Name(quantity) => self.quantity(*quantity),
                Node::Negate(a) => self.tape.negative(at(a)),
                Node::Add(a, b) => self.tape.operation(Operation::Add(at(a), at(b))),
                Node::Subtract(a, b) => self.tape.operation(Operation::Sub(at(a), at(b))),
                Node::Multiply(a, b) => self.tape.operation(Operation::Mul(at(a), at(b))),
                Node::Divide(a, b) => self.tape.operation(Operation::Div(at(a), at(b))),
                Node::Power(a, b) => self.tape.operation(match &value.nodes()[*b] {
                    Node::Number(n) if n.value.fract() == 0.0 && n.value <= 1024.0 =>
                    {
                        #[expect(clippy::cast_possible_truncation, reason = "whole and small, as just checked")]
                        Operation::PowI(at(a), n.value as i32)
                    }
                    _ => Operation::Pow(at(a), at(b)),
                }),
                Node::Call(function, arguments) => {
                    let arguments: Vec<u32> = arguments.iter().map(at).collect();
                    self.tape.operation(function.operation(&arguments))
                }
                Node::Spline(..) => unreachable!("splines are written out"),
            };
            values.push(result);
        }
        values.pop().unwrap_or_else(|| unreachable!("a formula is not empty"))
    }

    fn quantity(&mut self, quantity: Quantity) -> u32 {
        let at = |argument, i| self.tape.input(argument) + named_tape::place(i);
        match quantity {
            Quantity::Parameter(i) => self.parameter(i),
            Quantity::Coordinate(i) => at(Argument::Coordinates, i),
            Quantity::Rate(i) => at(Argument::Rates, i),
            Quantity::Acceleration(i) => at(Argument::Accelerations, i),
            Quantity::Multiplier(i) => at(Argument::Multipliers, i),
            Quantity::Time => at(Argument::Time, 0),
            Quantity::Pi => self.tape.operation(Operation::Pi),
            Quantity::Point(..) | Quantity::PointRate(..) => self.point(quantity),
            Quantity::Output(i) => self.result("outputs", i),
            Quantity::KineticEnergy => self.result("energy", 0),
            Quantity::PotentialEnergy => self.result("energy", 1),
            Quantity::Energy => {
                let [kinetic, potential] = [0, 1].map(|i| self.result("energy", i));
                self.tape.operation(Operation::Add(kinetic, potential))
            }
            // Scenes with unknown names are rejected earlier.
            Quantity::Stretch | Quantity::StretchRate | Quantity::Unknown => {
                unreachable!("they occur in loads alone")
            }
        }
    }

    /// The index of a parameter; zero if the tape omits it.
    fn parameter(&mut self, parameter: usize) -> u32 {
        let ([parameters, ..], name) = (self.tape.sizes(), &self.scene.parameters[parameter].name);
        let input = (0..named_tape::place(parameters)).find(|input| self.tape.names.get(input) == Some(name));
        input.unwrap_or_else(|| self.tape.number(0.0))
    }

    /// A result of a function of the tape.
    fn result(&self, function: &str, i: usize) -> u32 {
        let result = self.tape.function(function).and_then(|function| function.results().nth(i));
        result.unwrap_or_else(|| unreachable!("the tape has {function}"))
    }

    /// Converts a coordinate of a point, or its rate, and names it.
    fn point(&mut self, quantity: Quantity) -> u32 {
        if let Some(&value) = self.points.get(&quantity) {
            return value;
        }
        let (point, name, value) = match quantity {
            Quantity::PointRate(point, axis) => {
                let position = self.point(Quantity::Point(point, axis));
                let rate = self.tape.rate(position);
                let rate = rate.unwrap_or_else(|| unreachable!("points depend on time and coordinates alone"));
                (point, ["x_dot", "y_dot"][axis], rate)
            }
            Quantity::Point(point, axis) => {
                let scene = self.scene;
                (point, ["x", "y"][axis], self.value(&scene.points[point].position[axis]))
            }
            _ => unreachable!("a point"),
        };
        self.points.insert(quantity, value);
        if self.tape.is_computed(value) {
            let name = format!("{}_{name}", self.scene.points[point].name);
            self.names.entry(value).or_insert_with(|| vec![name]);
        }
        value
    }
}

/// The statements that lead to a value: values with a name, here or in the functions of outputs and energies, and
/// values that are used more than once.
fn statements(tape: &NamedTape, root: u32, mut names: BTreeMap<u32, Vec<String>>) -> Vec<Statement> {
    let needed = tape.needed(std::iter::once(root));
    let is_constant = tape.are_constant();
    let is_needed: BTreeSet<u32> = needed.iter().copied().filter(|value| !is_constant[*value as usize]).collect();
    for function in ["outputs", "energy"].iter().filter_map(|name| tape.function(name)) {
        for statement in &function.statements {
            if (0..).take(statement.names.len()).any(|i| is_needed.contains(&(statement.value + i))) {
                names.entry(statement.value).or_insert_with(|| statement.names.clone());
            }
        }
    }
    let mut uses: HashMap<u32, usize> = HashMap::new();
    for value in &is_needed {
        if let named_tape::Value::Operation(operation) = tape.values()[*value as usize] {
            operation.for_each_operand(|operand| *uses.entry(operand).or_default() += 1);
        }
    }
    let is_named = |names: &BTreeMap<u32, Vec<String>>, value: u32| {
        names.contains_key(&value) || value > 0 && names.get(&(value - 1)).is_some_and(|own| own.len() > 1)
    };
    for value in &is_needed {
        let is_shared = uses.get(value).is_some_and(|uses| *uses > 1);
        if is_shared && tape.is_computed(*value) && !is_named(&names, *value) {
            names.insert(*value, vec!["shared".to_owned()]);
        }
    }
    let mut taken: BTreeSet<String> = tape.names.values().cloned().collect();
    let mut unique = |name: String| {
        let numbered = (2..).map(|i| format!("{name}_{i}"));
        let free = std::iter::once(name.clone()).chain(numbered).find(|name| !taken.contains(name));
        let free = free.unwrap_or_else(|| unreachable!("numbers do not end"));
        taken.insert(free.clone());
        free
    };
    names
        .into_iter()
        .filter(|(value, names)| (0..).take(names.len()).any(|i| is_needed.contains(&(value + i))))
        .map(|(value, names)| Statement { comment: None, value, names: names.into_iter().map(&mut unique).collect() })
        .collect()
}
