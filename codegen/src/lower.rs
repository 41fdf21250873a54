//! Converts terms into a [`Graph`]: collects constants, factors out common factors, and computes equal parts once.

mod monomials;

use std::collections::{BTreeMap, HashMap};

use crate::graph::{Graph, Id, Op, Signed};
use crate::term::{Named, Symbol, Term};
use qrm_scene::expression::{Expression, Node, to_f64};
use qrm_scene::function::Function;
use qrm_scene::spline::Spline;

/// Builds a graph from terms.
#[derive(Debug, Default)]
pub struct Lowering {
    /// The graph.
    pub graph: Graph,
    done: HashMap<Term, Signed>,
    /// Symbols bound to earlier values.
    pub bound: HashMap<Symbol, Signed>,
    /// Reciprocals of earlier values.
    pub inverses: HashMap<Id, Id>,
    /// Whether sines and cosines of sums of coordinates are computed from those of the coordinates.
    pub adds_angles: bool,
    /// The sums with such sines and cosines.
    angle_sums: BTreeMap<Id, [Signed; 2]>,
    /// The sines and cosines of named angles, by the values of their names.
    pub named_angles: BTreeMap<Id, [Signed; 2]>,
}

impl Lowering {
    /// Continues with a graph without its bindings. A kernel receives the sines and cosines of the coordinates, and
    /// computes those of sums from them.
    pub fn from_kernel(graph: Graph) -> Self {
        Self { graph, adds_angles: true, ..Self::default() }
    }

    /// The value of a term.
    pub fn term(&mut self, term: &Term) -> Signed {
        if let Some(&done) = self.done.get(term) {
            return done;
        }
        let value = match term {
            Term::Number(number) => self.graph.number(to_f64(number)),
            Term::Symbol(symbol) => self.symbol(*symbol),
            Term::Sum(terms) => self.sum(terms),
            Term::Product(_) | Term::Power(..) => {
                let monomial = self.monomial(term);
                Signed { negative: monomial.negative, id: self.graph.product(monomial.factors) }
            }
            Term::Spline(spline, order, argument) => {
                let argument = self.term(argument);
                self.spline(spline, *order, argument)
            }
            Term::Call(function, argument) => {
                let argument = self.term(argument);
                let argument = self.positive(argument);
                let sum = self.adds_angles.then(|| self.sine_and_cosine_of_sum(argument)).flatten();
                match (function, sum) {
                    (Function::Sin, Some([sine, _])) => sine,
                    (Function::Cos, Some([_, cosine])) => cosine,
                    _ => Signed { negative: false, id: self.graph.add(Op::Call(*function, argument)) },
                }
            }
        };
        self.done.insert(term.clone(), value);
        value
    }

    /// Binds the symbols of named quantities to their values.
    pub fn define(&mut self, names: &[Named]) {
        for (place, named) in names.iter().enumerate() {
            for (symbol, term) in named.definitions(place) {
                let value = self.term(&term);
                self.bound.insert(symbol, value);
            }
        }
    }

    /// The sine and cosine of a sum of coordinates and named angles from those of its terms; `None` for other values.
    pub fn sine_and_cosine_of_sum(&mut self, angle: Id) -> Option<[Signed; 2]> {
        if let Some(sum) = self.named_angles.get(&angle).or_else(|| self.angle_sums.get(&angle)) {
            return Some(*sum);
        }
        let Op::Sum(terms) = self.graph.op(angle).clone() else { return None };
        let is_coordinate = |term: &Signed| matches!(self.graph.op(term.id), Op::Input(Symbol::Coordinate(_)));
        let is_named = terms.iter().any(|term| self.named_angles.contains_key(&term.id));
        if !terms.iter().all(|term| is_coordinate(term) || self.named_angles.contains_key(&term.id)) {
            return None;
        }
        let mut sum: Option<[Signed; 2]> = None;
        for term in terms {
            let [sine, cosine] = match self.named_angles.get(&term.id) {
                Some(known) => *known,
                None => [Function::Sin, Function::Cos]
                    .map(|f| Signed { negative: false, id: self.graph.add(Op::Call(f, term.id)) }),
            };
            let own = [if term.negative { sine.negated() } else { sine }, cosine];
            sum = Some(match sum {
                None => own,
                Some([sine, cosine]) => {
                    let sines = [self.product(sine, own[1]), self.product(cosine, own[0])];
                    let cosines = [self.product(cosine, own[1]), self.product(sine, own[0]).negated()];
                    [self.graph.sum(sines.to_vec()), self.graph.sum(cosines.to_vec())]
                }
            });
        }
        sum.inspect(|sum| {
            // Named angles name their sines and cosines themselves.
            if !is_named {
                self.angle_sums.insert(angle, *sum);
            }
        })
    }

    /// The sines and cosines of sums of coordinates, with names such as `sin_a_plus_b`.
    pub fn angle_sums(&self, name_of: impl Fn(usize) -> String) -> Vec<(String, Signed)> {
        let name_of_sum = |angle: Id| {
            let Op::Sum(terms) = self.graph.op(angle) else { return String::new() };
            let terms = terms.iter().enumerate().map(|(place, term)| {
                let sign = match (place, term.negative) {
                    (0, false) => "",
                    (0, true) => "minus_",
                    (_, false) => "_plus_",
                    (_, true) => "_minus_",
                };
                let name = match self.graph.op(term.id) {
                    Op::Input(Symbol::Coordinate(i)) => name_of(*i),
                    _ => String::new(),
                };
                format!("{sign}{name}")
            });
            terms.collect::<String>()
        };
        let named = self.angle_sums.iter().flat_map(|(angle, sum)| {
            ["sin", "cos"].into_iter().zip(sum).map(|(what, value)| (format!("{what}_{}", name_of_sum(*angle)), *value))
        });
        named.collect()
    }

    /// A spline expressed by step functions between the pieces.
    fn spline(&mut self, spline: &Spline, order: usize, argument: Signed) -> Signed {
        let mut written = Expression::new();
        let place = written.push(Node::Name(()), 0..0);
        spline.append(order, &mut written, place, &(0..0));
        let mut values: Vec<Signed> = Vec::with_capacity(written.nodes().len());
        for node in written.nodes() {
            let value = match node {
                Node::Number(number) => self.graph.number(number.value),
                Node::Negate(a) => values[*a].negated(),
                Node::Add(a, b) => self.total(vec![values[*a], values[*b]]),
                Node::Subtract(a, b) => self.total(vec![values[*a], values[*b].negated()]),
                Node::Multiply(a, b) => self.product(values[*a], values[*b]),
                Node::Divide(a, b) => {
                    let over = Signed { negative: values[*b].negative, id: self.reciprocal(values[*b].id) };
                    self.product(values[*a], over)
                }
                Node::Call(function, arguments) => {
                    let all: Vec<Id> = arguments.iter().map(|a| self.positive(values[*a])).collect();
                    self.piecewise(*function, &all)
                }
                Node::Name(()) => argument,
                Node::Power(..) | Node::Spline(..) => unreachable!("a spline is written without them"),
            };
            values.push(value);
        }
        values[values.len() - 1]
    }

    /// The maximum or minimum of two values through the sign of their difference, or a piecewise function of one value.
    fn piecewise(&mut self, function: Function, arguments: &[Id]) -> Signed {
        let plain = |id: Id| Signed { negative: false, id };
        let [a, b] = arguments[..] else { return plain(self.graph.add(Op::Call(function, arguments[0]))) };
        let difference = self.total(vec![plain(a), plain(b).negated()]);
        let difference = self.positive(difference);
        let sign = plain(self.graph.add(Op::Call(Function::Sign, difference)));
        let sign = if function == Function::Min { sign.negated() } else { sign };
        let half = self.graph.number(0.5);
        // The other value is multiplied by zero; in a sum of both it would cancel, and leave its rounding errors.
        let part = |lower: &mut Self, value: Id, sign: Signed| {
            let half_sign = lower.product(half, sign);
            let chosen = lower.total(vec![half, half_sign]);
            lower.product(plain(value), chosen)
        };
        let parts = vec![part(self, a, sign), part(self, b, sign.negated())];
        self.total(parts)
    }

    fn product(&mut self, a: Signed, b: Signed) -> Signed {
        Signed { negative: a.negative ^ b.negative, id: self.graph.product(vec![a.id, b.id]) }
    }

    fn symbol(&mut self, symbol: Symbol) -> Signed {
        self.bound.get(&symbol).copied().unwrap_or_else(|| self.graph.input(symbol))
    }

    /// A value that includes its sign.
    pub fn positive(&mut self, value: Signed) -> Id {
        if value.negative { self.graph.add(Op::Sum(vec![value])) } else { value.id }
    }

    /// One over a value.
    pub fn reciprocal(&mut self, value: Id) -> Id {
        self.inverses.get(&value).copied().unwrap_or_else(|| self.graph.add(Op::Reciprocal(value)))
    }
}
