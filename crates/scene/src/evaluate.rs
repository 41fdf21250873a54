//! Evaluates formulae directly from the scene, with automatic differentiation and without the symbolic engine.

use num_dual::Dual2;

use crate::expression::{Expression, Node};
use crate::function::Differentiable;
use crate::scene::{Quantity, Scene, Value};

/// The value of `expression`, where `lookup` gives the values of names.
pub fn evaluate<N, D: Differentiable>(expression: &Expression<N>, mut lookup: impl FnMut(&N) -> D) -> D {
    evaluate_in(&mut Vec::with_capacity(expression.nodes().len()), expression, &mut lookup)
}

/// Evaluates `expression` like [`evaluate`], with a buffer for intermediate values that the caller keeps.
pub fn evaluate_in<N, D: Differentiable>(
    values: &mut Vec<D>,
    expression: &Expression<N>,
    lookup: &mut impl FnMut(&N) -> D,
) -> D {
    values.clear();
    for node in expression.nodes() {
        values.push(evaluate_node(node, values, lookup));
    }
    values.last().copied().unwrap_or_else(|| D::from(f64::NAN))
}

/// The value of a formula of numbers and parameters.
pub fn constant<D: Differentiable>(value: &Value, parameters: &[D]) -> D {
    evaluate(value, |quantity| match quantity {
        Quantity::Parameter(i) => parameters[*i],
        Quantity::Pi => pi(),
        _ => D::from(f64::NAN),
    })
}

/// The ratio of a circle's circumference to its diameter, in the precision of the number.
fn pi<D: Differentiable>() -> D {
    D::from(std::f64::consts::PI) + 1.224_646_799_147_353_2e-16
}

/// The values of the operations that depend only on names with a known value.
pub fn known_values<N>(expression: &Expression<N>, mut lookup: impl FnMut(&N) -> Option<f64>) -> Vec<Option<f64>> {
    let mut known: Vec<Option<f64>> = Vec::with_capacity(expression.nodes().len());
    let mut values: Vec<f64> = Vec::with_capacity(expression.nodes().len());
    for node in expression.nodes() {
        let operands_known = node.operands().iter().all(|&operand| known[operand].is_some());
        let name = match node {
            Node::Name(name) => lookup(name),
            _ => None,
        };
        let is_known = operands_known && (name.is_some() || !matches!(node, Node::Name(_)));
        values.push(evaluate_node(node, &values, &mut |_| name.unwrap_or(f64::NAN)));
        known.push(is_known.then(|| values[values.len() - 1]));
    }
    known
}

/// The value of one node of an expression, given those of the nodes before it.
pub fn evaluate_node<N, D: Differentiable>(node: &Node<N>, values: &[D], lookup: &mut impl FnMut(&N) -> D) -> D {
    match node {
        // The second part vanishes in a double, but not in a double-double number.
        Node::Number(number) => D::from(number.value) + number.rest,
        Node::Name(name) => lookup(name),
        Node::Negate(a) => -values[*a],
        Node::Add(a, b) => values[*a] + values[*b],
        Node::Subtract(a, b) => values[*a] - values[*b],
        Node::Multiply(a, b) => values[*a] * values[*b],
        Node::Divide(a, b) => values[*a] / values[*b],
        Node::Power(a, b) => power(values[*a], values[*b]),
        Node::Call(function, arguments) => {
            // No function takes more than two arguments.
            let argument = |i: usize| values[arguments[i.min(arguments.len() - 1)]];
            function.evaluate(&[argument(0), argument(1)])
        }
        Node::Spline(spline, a) => spline.value(0, values[*a]),
    }
}

/// A power with a constant exponent; integer exponents also allow negative bases.
fn power<D: Differentiable>(base: D, exponent: D) -> D {
    let n = exponent.re();
    if n.fract() == 0.0 && n.abs() <= 1024.0 {
        #[expect(clippy::cast_possible_truncation, reason = "whole and small, as just checked")]
        return base.powi(n as i32);
    }
    base.powf(n)
}

/// The values of all names of a scene's formulae in one state.
#[derive(Clone, Debug)]
pub struct State<D> {
    /// Parameters.
    pub parameters: Vec<D>,
    /// Time.
    pub time: D,
    /// Generalized coordinates.
    pub coordinates: Vec<D>,
    /// The rates of the generalized coordinates.
    pub rates: Vec<D>,
    points: Vec<[D; 2]>,
    point_rates: Vec<[D; 2]>,
}

impl<D: Differentiable> State<D> {
    /// Creates the state with these coordinates and rates; points follow from them.
    pub fn new(scene: &Scene, parameters: &[f64], time: D, coordinates: Vec<D>, rates: Vec<D>) -> Self {
        let parameters: Vec<D> = parameters.iter().map(|&p| D::from(p)).collect();
        let points = Vec::with_capacity(scene.points.len());
        let mut state = Self { parameters, time, coordinates, rates, points, point_rates: Vec::new() };
        for point in &scene.points {
            let position = [state.value(&point.position[0]), state.value(&point.position[1])];
            state.points.push(position);
        }
        state
    }

    /// The value of a formula.
    pub fn value(&self, value: &Value) -> D {
        evaluate(value, |quantity| self.quantity(*quantity))
    }

    /// The value of a load's law for a length and its rate.
    pub fn law(&self, value: &Value, [stretch, rate]: [D; 2]) -> D {
        evaluate(value, |quantity| match quantity {
            Quantity::Stretch => stretch,
            Quantity::StretchRate => rate,
            other => self.quantity(*other),
        })
    }

    /// Copies the state with one point moved and everything else fixed.
    #[must_use]
    pub fn with_point(&self, point: usize, position: [D; 2]) -> Self {
        let mut moved = self.clone();
        moved.points[point] = position;
        moved
    }

    /// The position of a point.
    pub fn point(&self, point: usize) -> [D; 2] {
        self.points[point]
    }

    /// The value of a name; not a number for names that have no value in a state.
    pub fn quantity(&self, quantity: Quantity) -> D {
        match quantity {
            Quantity::Parameter(i) => self.parameters[i],
            Quantity::Coordinate(i) => self.coordinates[i],
            Quantity::Rate(i) => self.rates[i],
            Quantity::Point(i, axis) => self.points[i][axis],
            Quantity::PointRate(i, axis) => self.point_rates[i][axis],
            Quantity::Time => self.time,
            Quantity::Pi => pi(),
            // Laws of loads and conditions provide these values themselves.
            Quantity::Stretch
            | Quantity::StretchRate
            | Quantity::Acceleration(_)
            | Quantity::Multiplier(_)
            | Quantity::Output(_)
            | Quantity::KineticEnergy
            | Quantity::PotentialEnergy
            | Quantity::Energy
            | Quantity::Unknown => D::from(f64::NAN),
        }
    }
}

impl<D: Differentiable> State<D> {
    /// Creates a state of plain numbers, which also contains the rates of points.
    pub fn plain(scene: &Scene, parameters: &[f64], time: D, q: &[D], qd: &[D]) -> Self {
        let moving = State::along(scene, parameters, time, q, qd, &vec![D::from(0.0); q.len()]);
        let mut state = Self::new(scene, parameters, time, q.to_vec(), qd.to_vec());
        state.point_rates = moving.points.iter().map(|point| point.map(|c| c.v1)).collect();
        state
    }
}

impl<D: Differentiable> State<Dual2<D>> {
    /// Creates a state that moves with rates `qd` and accelerations `qdd`: each value carries its first two time
    /// derivatives.
    pub fn along(scene: &Scene, parameters: &[f64], time: D, q: &[D], qd: &[D], qdd: &[D]) -> Self {
        let [zero, one] = [0.0, 1.0].map(D::from);
        let coordinates = (0..q.len()).map(|i| Dual2::new(q[i], qd[i], qdd[i])).collect();
        let rates = (0..q.len()).map(|i| Dual2::new(qd[i], qdd[i], zero)).collect();
        Self::new(scene, parameters, Dual2::new(time, one, zero), coordinates, rates)
    }
}

/// The values of a scene's parameters, some of them replaced; dependent parameters are recomputed.
pub fn parameter_values<D: Differentiable>(scene: &Scene, replace: impl Fn(&str) -> Option<D>) -> Vec<D> {
    let mut values: Vec<D> = Vec::with_capacity(scene.parameters.len());
    for parameter in &scene.parameters {
        let value = replace(&parameter.name).unwrap_or_else(|| constant(&parameter.formula, &values));
        values.push(value);
    }
    values
}
