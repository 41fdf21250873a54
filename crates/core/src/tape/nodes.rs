//! A function of a tape in the few operations whose Taylor series follow by recurrences.

use core::slice;
use std::vec;
use std::vec::Vec;

use super::node::{Inverse, Node};
use super::operation::places;
use super::{Operation, Tape, TapeFunction};
use crate::Interval;

/// The nodes of a function of a tape.
#[derive(Clone, Debug)]
pub(super) struct Nodes {
    /// The arguments come first: time, `q`, `qd`, `qdd`, the multipliers.
    pub(super) nodes: Vec<Node>,
    /// The nodes of the results.
    pub(super) results: Vec<u32>,
    /// The node of each place of the tape.
    at: Vec<u32>,
}

impl Nodes {
    /// The nodes of a function, with some parameters replaced by their index.
    pub(super) fn new(tape: &Tape, function: &TapeFunction, replace: impl Fn(usize) -> Option<Interval>) -> Self {
        let own = tape.arguments();
        let arguments = own.sin - own.t;
        let is_used = used_places(tape, function);
        let at = vec![0; is_used.len()];
        let mut nodes = Self { nodes: vec![Node::Argument; arguments], results: Vec::new(), at };
        for argument in 0..arguments {
            nodes.at[own.t + argument] = argument as u32;
        }
        let values: Vec<Option<Interval>> = (0..own.t).map(replace).collect();
        if (0..own.t).any(|i| is_used[i] && values[i].is_none()) {
            nodes.take_parameters(tape, &values);
        } else {
            for i in (0..own.t).filter(|i| is_used[*i]) {
                nodes.at[i] = values[i].map_or(0, |value| nodes.push(Node::Constant(value)));
            }
        }
        for (mut next, operations) in [(own.constants, &tape.constants), (own.end, &function.operations)] {
            for operation in operations.iter() {
                let end = next + places(slice::from_ref(operation));
                if is_used[next..end].contains(&true) {
                    nodes.take(next, *operation);
                }
                next = end;
            }
        }
        nodes.results = function.results.iter().map(|&place| nodes.at[place as usize]).collect();
        nodes
    }

    /// Adds the parameters, where they have no other values those that the scene computes from parameters before them.
    fn take_parameters(&mut self, tape: &Tape, values: &[Option<Interval>]) {
        let (mut next, mut rest) = (tape.arguments().end, &tape.parameters.operations[..]);
        for (i, &result) in tape.parameters.results.iter().enumerate() {
            while next <= result as usize
                && let Some((operation, others)) = rest.split_first()
            {
                self.take(next, *operation);
                next += places(slice::from_ref(operation));
                rest = others;
            }
            self.at[i] = values[i].map_or(self.at[result as usize], |value| self.push(Node::Constant(value)));
        }
    }

    /// Whether a node depends on parameters alone.
    pub(super) fn is_constant(&self, node: u32) -> bool {
        matches!(self.nodes[node as usize], Node::Constant(_))
    }

    /// Adds an operation of the tape, whose first result has the place `next`.
    fn take(&mut self, next: usize, operation: Operation) {
        use Operation as Op;
        let operation = operation.map(|place| self.at[place as usize]);
        let node = match operation {
            Op::Number(number) => self.push(Node::Constant(Interval::rounded(number))),
            Op::Pi => self.push(Node::Constant(Interval::pi())),
            Op::Neg(a) => self.push(Node::Neg(a)),
            Op::Add(a, b) => self.push(Node::Add(a, b)),
            Op::Sub(a, b) => self.push(Node::Sub(a, b)),
            Op::Mul(a, b) => self.push(Node::Mul(a, b)),
            Op::Div(a, b) => self.push(Node::Div(a, b)),
            Op::Recip(a) => self.recip(a),
            Op::Sqrt(a) => self.push(Node::Sqrt(a)),
            Op::Sin(a) => self.sin_cos(a)[0],
            Op::Cos(a) => self.sin_cos(a)[1],
            Op::SinCos(a) => {
                let [sine, cosine] = self.sin_cos(a);
                self.at[next] = sine;
                self.at[next + 1] = cosine;
                return;
            }
            Op::Tan(a) => {
                let [sine, cosine] = self.sin_cos(a);
                self.push(Node::Div(sine, cosine))
            }
            Op::Asin(a) => self.asin(a),
            Op::Acos(a) => {
                let (quarter, angle) = (self.push(Node::Constant(Interval::pi() * Interval::point(0.5))), self.asin(a));
                self.push(Node::Sub(quarter, angle))
            }
            Op::Atan(a) => {
                let (one, square) = (self.push(Node::Constant(Interval::ONE)), self.push(Node::Mul(a, a)));
                let slope = self.push(Node::Add(one, square));
                self.push(Node::Inverse(Inverse::Atan, a, slope))
            }
            Op::Exp(a) => self.push(Node::Exp(a)),
            Op::Ln(a) => self.push(Node::Inverse(Inverse::Ln, a, a)),
            Op::Sinh(a) => self.hyperbolic(a)[0],
            Op::Cosh(a) => self.hyperbolic(a)[1],
            Op::Tanh(a) => {
                let one = self.push(Node::Constant(Interval::ONE));
                let tangent = self.push(Node::Tanh(a));
                let square = self.push(Node::Mul(tangent, tangent));
                self.push(Node::Sub(one, square));
                tangent
            }
            Op::Abs(a) => self.push(Node::Abs(a)),
            Op::Sign(a) => self.push(Node::Sign(a)),
            Op::Floor(a) => self.push(Node::Floor(a)),
            Op::Min(a, b) => {
                let difference = self.push(Node::Sub(b, a));
                self.push(Node::Choice(a, b, difference))
            }
            Op::Max(a, b) => {
                let difference = self.push(Node::Sub(a, b));
                self.push(Node::Choice(a, b, difference))
            }
            Op::Hypot(a, b) => {
                let square = self.square_of_length(a, b);
                self.push(Node::Sqrt(square))
            }
            Op::Atan2(a, b) => {
                let square = self.square_of_length(a, b);
                self.push(Node::Angle(a, b, square))
            }
            Op::PowI(a, exponent) => self.whole_power(a, exponent),
            Op::PowF(a, exponent) => {
                let exponent = self.push(Node::Constant(Interval::rounded(exponent)));
                self.power(a, exponent)
            }
            Op::Pow(a, b) => self.power(a, b),
            Op::MulAdd(a, b, c) => {
                let product = self.push(Node::Mul(a, b));
                self.push(Node::Add(product, c))
            }
            Op::NegMulAdd(a, b, c) => {
                let product = self.push(Node::Mul(a, b));
                self.push(Node::Sub(c, product))
            }
        };
        self.at[next] = node;
    }

    /// Adds a node; a constant if its operands are constants.
    fn push(&mut self, node: Node) -> u32 {
        let constant = |a: u32| match self.nodes[a as usize] {
            Node::Constant(value) => Some(value),
            _ => None,
        };
        let value = node.value(|a| constant(a).unwrap_or(Interval::ENTIRE));
        let node = if value.is_finite() && node.operands().into_iter().flatten().all(|a| constant(a).is_some()) {
            Node::Constant(value)
        } else {
            node
        };
        self.nodes.push(node);
        (self.nodes.len() - 1) as u32
    }

    fn square_of_length(&mut self, a: u32, b: u32) -> u32 {
        let squares = [a, b].map(|x| self.push(Node::Mul(x, x)));
        self.push(Node::Add(squares[0], squares[1]))
    }

    fn recip(&mut self, a: u32) -> u32 {
        let one = self.push(Node::Constant(Interval::ONE));
        self.push(Node::Div(one, a))
    }

    fn sin_cos(&mut self, a: u32) -> [u32; 2] {
        [self.push(Node::Sin(a)), self.push(Node::Cos(a))]
    }

    fn asin(&mut self, a: u32) -> u32 {
        let (one, square) = (self.push(Node::Constant(Interval::ONE)), self.push(Node::Mul(a, a)));
        let rest = self.push(Node::Sub(one, square));
        let slope = self.push(Node::Sqrt(rest));
        self.push(Node::Inverse(Inverse::Asin, a, slope))
    }

    /// Hyperbolic sine and cosine.
    fn hyperbolic(&mut self, a: u32) -> [u32; 2] {
        let (half, growing) = (self.push(Node::Constant(Interval::point(0.5))), self.push(Node::Exp(a)));
        let falling = self.recip(growing);
        [Node::Sub(growing, falling), Node::Add(growing, falling)].map(|twice| {
            let twice = self.push(twice);
            self.push(Node::Mul(half, twice))
        })
    }

    fn whole_power(&mut self, a: u32, exponent: i32) -> u32 {
        let mut power = self.push(Node::Constant(Interval::ONE));
        for bit in (0..u32::BITS).rev().skip_while(|bit| exponent.unsigned_abs() >> bit == 0) {
            power = self.push(Node::Mul(power, power));
            if exponent.unsigned_abs() >> bit & 1 == 1 {
                power = self.push(Node::Mul(power, a));
            }
        }
        if exponent < 0 { self.recip(power) } else { power }
    }

    fn power(&mut self, a: u32, exponent: u32) -> u32 {
        let logarithm = self.push(Node::Inverse(Inverse::Ln, a, a));
        let product = self.push(Node::Mul(exponent, logarithm));
        self.push(Node::Exp(product))
    }
}

impl Tape {
    /// The numbers of the parameters that a function uses.
    pub fn parameters_of(&self, function: &TapeFunction) -> impl Iterator<Item = usize> {
        let is_used = used_places(self, function);
        (0..self.arguments().t).filter(move |i| is_used[*i])
    }
}

/// Whether a function uses each place of its tape.
fn used_places(tape: &Tape, function: &TapeFunction) -> Vec<bool> {
    let own = tape.arguments();
    let mut is_used = vec![false; tape.places().max(own.end + places(&function.operations))];
    function.results.iter().for_each(|place| is_used[*place as usize] = true);
    mark_used(&mut is_used, own.end, &function.operations);
    mark_used(&mut is_used, own.constants, &tape.constants);
    is_used
}

/// Marks the places that operations before those of marked places use; the first result has the place `first`.
fn mark_used(is_used: &mut [bool], first: usize, operations: &[Operation]) {
    let mut next = first + places(operations);
    for operation in operations.iter().rev() {
        let end = next;
        next -= places(slice::from_ref(operation));
        if is_used[next..end].contains(&true) {
            operation.for_each_operand(&mut |place| is_used[place as usize] = true);
        }
    }
}
