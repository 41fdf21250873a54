//! Taylor series of the functions of a tape, in intervals.

use std::vec;
use std::vec::Vec;

use super::node::{Node, is_above};
use super::nodes::Nodes;
use super::{Tape, TapeFunction};
use crate::Interval;

/// Taylor coefficients of a function of a tape along a motion, one order at a time, each with derivatives.
///
/// A coefficient is an interval, followed by its derivatives in a number of directions. Arguments are numbered: time,
/// then `q`, `qd`, `qdd` and the multipliers. A caller [sets](Self::set) the coefficients of an order, and
/// [`advance`](Self::advance) computes all others of it, by the recurrences of R. E. Moore, Interval Analysis (1966).
/// Numbers of the tape are [enclosed](Interval::rounded). Absolute values and the like have a series where the sign is
/// certain.
#[derive(Clone, Debug)]
pub struct TapeSeries {
    nodes: Nodes,
    /// Value and derivatives.
    width: usize,
    /// Order by order, node by node.
    coefficients: Vec<Interval>,
}

/// The operation that has no finite value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Obstacle {
    /// The name of the operation.
    pub operation: &'static str,
    /// The number that it is applied to.
    pub operand: Interval,
}

impl TapeSeries {
    /// The series of a function up to an order, with derivatives in so many directions, and some parameters replaced by
    /// their index.
    pub fn new(
        tape: &Tape,
        function: &TapeFunction,
        replace: impl Fn(usize) -> Option<Interval>,
        [order, directions]: [usize; 2],
    ) -> Self {
        let (nodes, width) = (Nodes::new(tape, function, replace), 1 + directions);
        let mut coefficients = vec![Interval::ZERO; (order + 1) * nodes.nodes.len() * width];
        for (i, node) in nodes.nodes.iter().enumerate() {
            if let Node::Constant(value) = node {
                coefficients[i * width] = *value;
            }
        }
        Self { nodes, width, coefficients }
    }

    /// Sets the coefficient of an argument.
    pub fn set(&mut self, order: usize, argument: usize, coefficient: &[Interval]) {
        let place = (order * self.nodes.nodes.len() + argument) * self.width;
        self.coefficients[place..][..self.width].copy_from_slice(coefficient);
    }

    /// Computes the coefficients of an order from those of its arguments and from lower orders.
    pub fn advance(&mut self, order: usize) {
        for (i, node) in self.nodes.nodes.iter().enumerate() {
            if matches!(node, Node::Argument | Node::Constant(_)) {
                continue;
            }
            let place = (order * self.nodes.nodes.len() + i) * self.width;
            let (known, own) = self.coefficients.split_at_mut(place);
            let known = Known { nodes: &self.nodes, width: self.width, coefficients: known, node: i };
            known.write(*node, order, &mut own[..self.width]);
        }
    }

    /// The coefficient of a result.
    pub fn result(&self, order: usize, i: usize) -> &[Interval] {
        let place = (order * self.nodes.nodes.len() + self.nodes.results[i] as usize) * self.width;
        &self.coefficients[place..][..self.width]
    }

    /// The arguments that the function depends on.
    pub fn arguments(&self) -> Vec<usize> {
        let Nodes { nodes, results, .. } = &self.nodes;
        let mut is_used = vec![false; nodes.len()];
        let operands = nodes.iter().flat_map(|node| node.operands()).flatten();
        operands.chain(results.iter().copied()).for_each(|node| is_used[node as usize] = true);
        (0..nodes.len()).filter(|&i| is_used[i] && nodes[i] == Node::Argument).collect()
    }

    /// The degree of the function as a polynomial of its arguments and their sines and cosines; `None` if the function is
    /// no such polynomial.
    pub fn degree(&self) -> Option<u32> {
        let Nodes { nodes, results, .. } = &self.nodes;
        let mut degrees: Vec<Option<u32>> = Vec::with_capacity(nodes.len());
        for node in nodes {
            let of = |node: u32| degrees[node as usize];
            let degree = match *node {
                Node::Argument => Some(1),
                Node::Constant(_) => Some(0),
                Node::Neg(a) => of(a),
                Node::Add(a, b) | Node::Sub(a, b) => of(a).zip(of(b)).map(|(a, b)| a.max(b)),
                Node::Mul(a, b) => of(a).zip(of(b)).map(|(a, b)| a + b),
                Node::Div(a, b) if of(b) == Some(0) => of(a),
                Node::Sin(a) | Node::Cos(a) if nodes[a as usize] == Node::Argument => Some(1),
                _ if node.operands().into_iter().flatten().all(|operand| of(operand) == Some(0)) => Some(0),
                _ => None,
            };
            degrees.push(degree);
        }
        let of_results = results.iter().map(|&node| degrees[node as usize]);
        of_results.collect::<Option<Vec<u32>>>()?.into_iter().max()
    }

    /// The number of results.
    pub fn results(&self) -> usize {
        self.nodes.results.len()
    }

    /// Whether the function may jump among the values of its arguments.
    pub fn may_jump(&self) -> bool {
        let value = |node: u32| self.coefficients[node as usize * self.width];
        self.nodes.nodes.iter().any(|node| node.may_jump(value))
    }

    /// The first operation without a finite value, or with a corner, though its operands have finite values.
    pub fn obstacle(&self) -> Option<Obstacle> {
        let value = |node: u32| self.coefficients[node as usize * self.width];
        let mut nodes = self.nodes.nodes.iter().enumerate();
        nodes.find_map(|(i, node)| {
            let operand = node.operands().into_iter().flatten().last().map(value)?;
            let is_smooth = value(i as u32).is_finite() && !node.has_corner(value);
            (!is_smooth).then(|| Obstacle { operation: node.name(), operand })
        })
    }
}

/// The coefficients before that of a node.
struct Known<'a> {
    nodes: &'a Nodes,
    width: usize,
    coefficients: &'a [Interval],
    node: usize,
}

impl Known<'_> {
    fn at(&self, order: usize, node: u32) -> &[Interval] {
        &self.coefficients[(order * self.nodes.nodes.len() + node as usize) * self.width..][..self.width]
    }

    /// The order above which all coefficients of a node are zero, within those that are known.
    fn last(&self, order: usize, node: u32) -> usize {
        if self.nodes.is_constant(node) { 0 } else { order }
    }

    /// Writes the coefficient of a node.
    fn write(&self, node: Node, order: usize, own: &mut [Interval]) {
        let own_node = self.node as u32;
        let value = |node| self.at(0, node)[0];
        own.fill(Interval::ZERO);
        match node {
            Node::Argument => {}
            _ if order == 0 => {
                own[0] = node.value(value);
                self.write_derivatives(node, own);
            }
            // Along the motion the value changes at the rates of either side.
            Node::Abs(a) if order == 1 && node.has_corner(value) => {
                own.fill(Interval::ENTIRE);
                let rate = self.at(1, a)[0];
                own[0] = rate.hull(-rate);
            }
            Node::Choice(a, b, _) if order == 1 && node.has_corner(value) => {
                own.fill(Interval::ENTIRE);
                own[0] = self.at(1, a)[0].hull(self.at(1, b)[0]);
            }
            _ if node.has_corner(value) => own.fill(Interval::ENTIRE),
            Node::Constant(_) | Node::Sign(_) | Node::Floor(_) => {}
            Node::Neg(a) => subtract(own, self.at(order, a)),
            Node::Add(a, b) => {
                add(own, self.at(order, a));
                add(own, self.at(order, b));
            }
            Node::Sub(a, b) => {
                add(own, self.at(order, a));
                subtract(own, self.at(order, b));
            }
            Node::Mul(a, b) => {
                for j in order - self.last(order, a)..=self.last(order, b) {
                    add_product(own, self.at(order - j, a), self.at(j, b), Interval::ONE);
                }
            }
            Node::Div(a, b) => {
                if !self.nodes.is_constant(a) {
                    add(own, self.at(order, a));
                }
                for j in 1..=self.last(order, b) {
                    add_product(own, self.at(j, b), self.at(order - j, own_node), -Interval::ONE);
                }
                divide(own, self.at(0, b));
            }
            Node::Sqrt(a) => {
                add(own, self.at(order, a));
                for j in 1..order {
                    add_product(own, self.at(j, own_node), self.at(order - j, own_node), -Interval::ONE);
                }
                divide(own, self.at(0, own_node));
                scale(own, Interval::point(0.5));
            }
            Node::Sin(a) => self.add_integral(own, order, [a, own_node + 1], Interval::ONE),
            Node::Cos(a) => self.add_integral(own, order, [a, own_node - 1], -Interval::ONE),
            Node::Exp(a) => self.add_integral(own, order, [a, own_node], Interval::ONE),
            Node::Tanh(a) => self.add_integral(own, order, [a, own_node + 2], Interval::ONE),
            Node::Inverse(_, a, b) => {
                for j in 1..order {
                    add_product(own, self.at(j, own_node), self.at(order - j, b), whole(j));
                }
                scale(own, -Interval::ONE / whole(order));
                add(own, self.at(order, a));
                divide(own, self.at(0, b));
            }
            Node::Angle(a, b, square) => {
                for j in 1..=order {
                    add_product(own, self.at(j, a), self.at(order - j, b), whole(j));
                    add_product(own, self.at(j, b), self.at(order - j, a), -whole(j));
                }
                for j in 1..order {
                    add_product(own, self.at(j, own_node), self.at(order - j, square), -whole(j));
                }
                scale(own, Interval::ONE / whole(order));
                divide(own, self.at(0, square));
            }
            Node::Abs(a) if is_above(value(a)) => add(own, self.at(order, a)),
            Node::Abs(a) => subtract(own, self.at(order, a)),
            Node::Choice(a, _, c) if is_above(value(c)) => add(own, self.at(order, a)),
            Node::Choice(_, b, _) => add(own, self.at(order, b)),
        }
    }

    /// Adds the coefficient of the integral of `b da`, times a factor.
    fn add_integral(&self, own: &mut [Interval], order: usize, [a, b]: [u32; 2], factor: Interval) {
        for j in 1..=order {
            add_product(own, self.at(j, a), self.at(order - j, b), whole(j));
        }
        scale(own, factor / whole(order));
    }

    /// Writes the derivatives of a value.
    fn write_derivatives(&self, node: Node, own: &mut [Interval]) {
        let own_value = own[0];
        let value = |node| self.at(0, node)[0];
        let mut add_scaled = |node, factor: Interval| {
            let derivatives = own[1..].iter_mut().zip(&self.at(0, node)[1..]);
            derivatives.for_each(|(own, derivative)| *own = *own + factor * *derivative);
        };
        let one = Interval::ONE;
        match node {
            _ if node.has_corner(value) => own[1..].fill(Interval::ENTIRE),
            Node::Argument | Node::Constant(_) | Node::Sign(_) | Node::Floor(_) => {}
            Node::Neg(a) => add_scaled(a, -one),
            Node::Add(a, b) => {
                add_scaled(a, one);
                add_scaled(b, one);
            }
            Node::Sub(a, b) => {
                add_scaled(a, one);
                add_scaled(b, -one);
            }
            Node::Mul(a, b) => {
                add_scaled(a, value(b));
                add_scaled(b, value(a));
            }
            Node::Div(a, b) => {
                add_scaled(a, one / value(b));
                add_scaled(b, -own_value / value(b));
            }
            Node::Sqrt(a) => add_scaled(a, Interval::point(0.5) / own_value),
            Node::Sin(a) => add_scaled(a, value(a).sin_cos().1),
            Node::Cos(a) => add_scaled(a, -value(a).sin_cos().0),
            Node::Exp(a) => add_scaled(a, own_value),
            Node::Tanh(a) => add_scaled(a, one - own_value.square()),
            Node::Inverse(_, a, b) => add_scaled(a, one / value(b)),
            Node::Angle(a, b, square) => {
                add_scaled(a, value(b) / value(square));
                add_scaled(b, -value(a) / value(square));
            }
            Node::Abs(a) => add_scaled(a, if is_above(value(a)) { one } else { -one }),
            Node::Choice(a, b, c) => add_scaled(if is_above(value(c)) { a } else { b }, one),
        }
    }
}

fn whole(number: usize) -> Interval {
    Interval::point(number as f64)
}

fn add(own: &mut [Interval], other: &[Interval]) {
    own.iter_mut().zip(other).for_each(|(own, other)| *own = *own + *other);
}

fn subtract(own: &mut [Interval], other: &[Interval]) {
    own.iter_mut().zip(other).for_each(|(own, other)| *own = *own - *other);
}

fn scale(own: &mut [Interval], factor: Interval) {
    own.iter_mut().for_each(|own| *own = *own * factor);
}

/// Adds a product times a factor.
fn add_product(own: &mut [Interval], a: &[Interval], b: &[Interval], factor: Interval) {
    let (a0, b0) = if factor == Interval::ONE { (a[0], b[0]) } else { (a[0] * factor, b[0] * factor) };
    own[0] = own[0] + a0 * b[0];
    for ((own, da), db) in own[1..].iter_mut().zip(&a[1..]).zip(&b[1..]) {
        *own = *own + a0 * *db + b0 * *da;
    }
}

/// Divides by another coefficient.
fn divide(own: &mut [Interval], by: &[Interval]) {
    let value = own[0] / by[0];
    own[0] = value;
    for (own, by_derivative) in own[1..].iter_mut().zip(&by[1..]) {
        *own = (*own - value * *by_derivative) / by[0];
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Operation as Op, Tape, TapeFunction};
    use super::*;
    use crate::{Scalar, TapeEvaluator};

    /// A tape whose event is a function of time, which has the place 0; results of operations follow it.
    fn tape(operations: &[Op]) -> Tape {
        let results = vec![operations.iter().map(|op| if matches!(op, Op::SinCos(_)) { 2 } else { 1 }).sum()];
        Tape {
            event: Some(TapeFunction { operations: operations.to_vec().into(), results: results.into() }),
            ..Tape::default()
        }
    }

    /// The series of such a function at a time, with derivatives by time.
    fn series(operations: &[Op], t: Interval, order: usize) -> TapeSeries {
        let tape = tape(operations);
        let mut series = TapeSeries::new(&tape, tape.event.as_ref().expect("a function"), |_| None, [order, 1]);
        for k in 0..=order {
            let coefficient = [[t, Interval::ONE], [Interval::ONE, Interval::ZERO]].get(k).copied();
            series.set(k, 0, &coefficient.unwrap_or([Interval::ZERO; 2]));
            series.advance(k);
        }
        series
    }

    const FUNCTIONS: &[&[Op]] = &[
        &[Op::Number(0.75), Op::MulAdd(0, 1, 0), Op::NegMulAdd(2, 2, 1), Op::Sub(3, 0)],
        &[Op::SinCos(0), Op::Mul(1, 2), Op::Div(3, 0), Op::Neg(4)],
        &[Op::Sin(0), Op::Cos(1), Op::Add(1, 2), Op::Tan(3)],
        &[Op::Sqrt(0), Op::Exp(1), Op::Ln(2), Op::Mul(2, 3)],
        &[Op::Number(0.4), Op::Mul(1, 0), Op::Asin(2), Op::Acos(2), Op::Atan(0), Op::Div(3, 4), Op::Add(5, 6)],
        &[Op::Sinh(0), Op::Cosh(0), Op::Tanh(0), Op::Mul(1, 2), Op::Recip(3), Op::Add(4, 5)],
        &[
            Op::PowI(0, 5),
            Op::PowI(0, -3),
            Op::PowF(0, 1.7),
            Op::Pow(0, 0),
            Op::Add(1, 2),
            Op::Add(3, 4),
            Op::Mul(5, 6),
        ],
        &[
            Op::Abs(0),
            Op::Sign(0),
            Op::Number(3.0),
            Op::Min(1, 3),
            Op::Max(4, 2),
            Op::Floor(0),
            Op::Hypot(5, 3),
            Op::Add(6, 7),
        ],
        &[
            Op::Number(-0.6),
            Op::Mul(0, 0),
            Op::Atan2(1, 2),
            Op::Atan2(0, 1),
            Op::Add(3, 4),
            Op::Atan2(2, 0),
            Op::Add(5, 6),
        ],
        &[Op::Pi, Op::Neg(0), Op::Abs(2), Op::Max(2, 1), Op::Min(3, 1), Op::Mul(4, 5)],
    ];

    #[test]
    fn series_add_up_to_the_function() {
        for operations in FUNCTIONS {
            let (t, h, order) = (1.25, 0.0625, 16);
            let series = series(operations, Interval::point(t), order);
            let sum =
                (0..=order).rev().fold(Interval::ZERO, |sum, k| sum * Interval::point(h) + series.result(k, 0)[0]);
            let tape = tape(operations);
            let exact = TapeEvaluator::<Vec<f64>>::new(&tape).event(t + h, &[], &[], &[], &[]).expect("an event");
            let width = 1e-12 * exact.abs().max(1.0);
            assert!((sum.lo() - width..sum.hi() + width).contains(&exact), "{operations:?}: {sum:?} {exact}");
            assert!(sum.width() < width, "{operations:?}: {}", sum.width());
        }
    }

    #[test]
    fn a_derivative_by_the_argument_is_that_of_the_next_coefficient() {
        for operations in FUNCTIONS {
            for t in [Interval::point(1.25), Interval::new(1.25, 1.2501)] {
                let series = series(operations, t, 8);
                for k in 0..8 {
                    let [derivative, next] = [series.result(k, 0)[1], series.result(k + 1, 0)[0]];
                    let next = next * whole(k + 1);
                    assert!(derivative.intersection(next).is_some(), "{operations:?} {k}: {derivative:?} {next:?}");
                }
            }
        }
    }

    #[test]
    fn values_of_32_digits_are_contained() {
        for operations in FUNCTIONS {
            let tape = tape(operations);
            for step in 0..200 {
                let t = 1.0 + f64::from(step) / 256.0;
                let value = series(operations, Interval::point(t), 0).result(0, 0)[0];
                let exact = TapeEvaluator::<Vec<crate::DoubleDouble>>::new(&tape)
                    .event(t.into(), &[], &[], &[], &[])
                    .expect("an event");
                // The exponent 1.7 of the tape stands for the decimal.
                let slack = crate::DoubleDouble::from(1e-28);
                let above = (exact - value.lo().into() + slack).to_f64();
                let below = (crate::DoubleDouble::from(value.hi()) - exact + slack).to_f64();
                assert!(above >= 0.0 && below >= 0.0, "{operations:?} at {t}: {value:?}");
            }
        }
    }

    #[test]
    fn an_operation_without_value_is_named() {
        let of = |operations: &[Op], t: Interval| series(operations, t, 1).obstacle();
        let around = Interval::new(-0.5, 1.0);
        assert_eq!(of(&[Op::Abs(0)], around), Some(Obstacle { operation: "an absolute value", operand: around }));
        assert_eq!(of(&[Op::Sqrt(0), Op::Exp(1)], around).map(|obstacle| obstacle.operation), Some("a square root"));
        assert_eq!(
            of(&[Op::Number(1.0), Op::Div(1, 0)], around).map(|obstacle| obstacle.operation),
            Some("a quotient")
        );
        let angle = of(&[Op::Number(-1.0), Op::Atan2(0, 1)], around).map(|obstacle| obstacle.operation);
        assert_eq!(angle, Some("the angle of a vector"));
        assert_eq!(of(&[Op::Abs(0), Op::Sqrt(1)], Interval::point(2.0)), None);
    }
}
