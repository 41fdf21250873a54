//! One list of operations under construction.

use std::collections::{BTreeMap, HashMap, HashSet};

use qrm_core::Operation;

use super::place;
use crate::graph::{Graph, Id, Op, Signed};
use crate::term::Symbol;
use qrm_scene::function::Function;

/// Operations whose results have consecutive places.
pub(super) struct Section<'k> {
    /// Values that other parts of the tape compute.
    known: &'k HashMap<Id, u32>,
    /// Values that this part computes.
    pub(super) places: HashMap<Id, u32>,
    numbers: HashMap<u64, u32>,
    pub(super) operations: Vec<Operation>,
    next: u32,
}

impl<'k> Section<'k> {
    /// No operations yet; the result of the first one has the place `first`.
    pub(super) fn new(known: &'k HashMap<Id, u32>, first: u32) -> Self {
        let (places, numbers) = (HashMap::new(), HashMap::new());
        Self { known, places, numbers, operations: Vec::new(), next: first }
    }

    /// The place of an operation's result, which is its last.
    pub(super) fn push(&mut self, operation: Operation) -> u32 {
        self.operations.push(operation);
        self.next += places(&[operation]);
        self.next - 1
    }

    /// The place of a number.
    pub(super) fn number(&mut self, value: f64) -> u32 {
        if let Some(&place) = self.numbers.get(&value.to_bits()) {
            return place;
        }
        let place = self.push(Operation::Number(value));
        self.numbers.insert(value.to_bits(), place);
        place
    }

    /// The values of a graph, operands first; those that only divide a product have no place.
    pub(super) fn graph(&mut self, graph: &Graph, needed: &[Id], divisors: &HashSet<Id>) {
        let mut angles: BTreeMap<Id, [Option<Id>; 2]> = BTreeMap::new();
        for &id in needed {
            match graph.op(id) {
                Op::Call(Function::Sin, angle) => angles.entry(*angle).or_default()[0] = Some(id),
                Op::Call(Function::Cos, angle) => angles.entry(*angle).or_default()[1] = Some(id),
                _ => {}
            }
        }
        for &id in needed {
            if self.places.contains_key(&id) || self.known.contains_key(&id) || divisors.contains(&id) {
                continue;
            }
            let result = match graph.op(id) {
                Op::Call(Function::Sin | Function::Cos, angle) => match angles[angle] {
                    [Some(sine), Some(cosine)] => {
                        let place = self.push(Operation::SinCos(self.at(*angle)));
                        self.places.extend([(sine, place - 1), (cosine, place)]);
                        continue;
                    }
                    [Some(_), None] => self.push(Operation::Sin(self.at(*angle))),
                    _ => self.push(Operation::Cos(self.at(*angle))),
                },
                Op::Number(bits) => self.number(f64::from_bits(*bits)),
                Op::Input(Symbol::Pi) => self.push(Operation::Pi),
                Op::Input(symbol) => unreachable!("{symbol:?} is known"),
                Op::Sum(terms) => self.sum(terms),
                Op::Product(factors) => self.product(graph, factors, divisors),
                Op::Reciprocal(a) => self.push(Operation::Recip(self.at(*a))),
                Op::Power(a, exponent) => self.push(Operation::PowF(self.at(*a), f64::from_bits(*exponent))),
                Op::Call(function, a) => self.push(call(*function, &[self.at(*a)])),
            };
            self.places.insert(id, result);
        }
    }

    /// The place of a result.
    pub(super) fn root(&mut self, root: Signed) -> u32 {
        let place = self.at(root.id);
        if root.negative { self.push(Operation::Neg(place)) } else { place }
    }

    fn at(&self, id: Id) -> u32 {
        self.known.get(&id).copied().unwrap_or_else(|| self.places[&id])
    }

    /// A sum, its first positive term in front.
    fn sum(&mut self, terms: &[Signed]) -> u32 {
        let first = terms.iter().position(|term| !term.negative);
        let mut sum = self.at(terms[first.unwrap_or(0)].id);
        if first.is_none() {
            sum = self.push(Operation::Neg(sum));
        }
        for (_, term) in terms.iter().enumerate().filter(|(i, _)| *i != first.unwrap_or(0)) {
            let value = self.at(term.id);
            sum = self.push(if term.negative { Operation::Sub(sum, value) } else { Operation::Add(sum, value) });
        }
        sum
    }

    /// A product, its divisors behind.
    fn product(&mut self, graph: &Graph, factors: &[Id], divisors: &HashSet<Id>) -> u32 {
        let mut product: Option<u32> = None;
        for factor in factors.iter().filter(|factor| !divisors.contains(factor)) {
            let value = self.at(*factor);
            product = Some(product.map_or(value, |product| self.push(Operation::Mul(product, value))));
        }
        for factor in factors.iter().filter(|factor| divisors.contains(factor)) {
            let Op::Reciprocal(divisor) = graph.op(*factor) else { unreachable!("a divisor is a reciprocal") };
            let value = self.at(*divisor);
            let quotient = product.map_or(Operation::Recip(value), |product| Operation::Div(product, value));
            product = Some(self.push(quotient));
        }
        product.unwrap_or_else(|| unreachable!("a product has factors"))
    }
}

/// The number of places that results take.
pub(super) fn places(operations: &[Operation]) -> u32 {
    let pairs = operations.iter().filter(|operation| matches!(operation, Operation::SinCos(_))).count();
    place(operations.len() + pairs)
}

/// Reciprocals that serve one product alone: it is divided instead, unless they are `named`.
pub(super) fn divisors(graph: &Graph, needed: &[Id], roots: &[Signed], named: &HashSet<Id>) -> HashSet<Id> {
    let mut uses: HashMap<Id, usize> = HashMap::new();
    let operands = needed.iter().flat_map(|&id| graph.op(id).operands());
    for id in roots.iter().map(|root| root.id).chain(operands) {
        *uses.entry(id).or_default() += 1;
    }
    let factors = needed.iter().flat_map(|&id| match graph.op(id) {
        Op::Product(factors) => factors.as_slice(),
        _ => &[],
    });
    let computed: HashSet<Id> = needed.iter().copied().collect();
    let is_divisor = |id: &Id| matches!(graph.op(*id), Op::Reciprocal(_)) && uses[id] == 1 && !named.contains(id);
    factors.copied().filter(|id| is_divisor(id) && computed.contains(id)).collect()
}

/// The operation that a function of formulae is.
pub(super) fn call(function: Function, arguments: &[u32]) -> Operation {
    let (a, b) = (arguments[0], arguments[arguments.len() - 1]);
    match function {
        Function::Sqrt => Operation::Sqrt(a),
        Function::Sin => Operation::Sin(a),
        Function::Cos => Operation::Cos(a),
        Function::Tan => Operation::Tan(a),
        Function::Asin => Operation::Asin(a),
        Function::Acos => Operation::Acos(a),
        Function::Atan => Operation::Atan(a),
        Function::Exp => Operation::Exp(a),
        Function::Log => Operation::Ln(a),
        Function::Sinh => Operation::Sinh(a),
        Function::Cosh => Operation::Cosh(a),
        Function::Tanh => Operation::Tanh(a),
        Function::Hypot => Operation::Hypot(a, b),
        Function::Atan2 => Operation::Atan2(a, b),
        Function::Abs => Operation::Abs(a),
        Function::Sign => Operation::Sign(a),
        Function::Min => Operation::Min(a, b),
        Function::Max => Operation::Max(a, b),
    }
}
