//! What the derivation needs of the engine: atoms, derivatives, normal forms.

use std::collections::HashMap;

use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::ToPrimitive;
use symbolica::atom::{Atom, AtomCore, AtomView, Symbol as EngineSymbol};
use symbolica::{function, parse, symbol};

use super::Place;
use super::translate::term;
use crate::expression::{Node, Number};
use crate::function::Function;
use crate::scene::{Quantity, Scene, Value};
use crate::term::{Symbol, Term};

/// The symbols of one scene, and its formulae in terms of them.
pub(super) struct Algebra<'s> {
    scene: &'s Scene,
    number: usize,
    place: &'s Place,
    symbols: Vec<(Symbol, EngineSymbol)>,
    places: HashMap<EngineSymbol, Symbol>,
    points: Vec<[Atom; 2]>,
}

impl<'s> Algebra<'s> {
    /// Defines the symbols of a scene, in an order that depends on nothing but the scene: the order of terms follows it.
    pub(super) fn new(number: usize, scene: &'s Scene, place: &'s Place) -> Self {
        let (n, m) = (scene.coordinates.len(), scene.constraints.len());
        let mut wanted: Vec<Symbol> = (0..scene.parameters.len()).map(Symbol::Parameter).collect();
        wanted.extend([Symbol::Pi, Symbol::Time, Symbol::Displacement]);
        wanted.extend((0..n).map(Symbol::Coordinate));
        wanted.extend((0..n).map(Symbol::Rate));
        wanted.extend((0..n).map(Symbol::Acceleration));
        wanted.extend((0..m).map(Symbol::Multiplier));
        let symbols: Vec<_> =
            wanted.into_iter().enumerate().map(|(i, s)| (s, symbol!(format!("scene{number}_{i}")))).collect();
        let places = symbols.iter().map(|(s, engine)| (*engine, *s)).collect();
        let mut algebra = Self { scene, number, place, symbols, places, points: Vec::new() };
        for point in &scene.points {
            let position = [0, 1].map(|axis| algebra.atom(&point.position[axis]));
            algebra.points.push(position);
        }
        algebra
    }

    fn engine_symbol(&self, symbol: Symbol) -> EngineSymbol {
        self.symbols.iter().find(|(s, _)| *s == symbol).map(|(_, engine)| *engine).unwrap_or(EngineSymbol::PI)
    }

    /// A symbol as an atom; parameters that are left out are zero.
    pub(super) fn symbol(&self, symbol: Symbol) -> Atom {
        match symbol {
            Symbol::Parameter(i) if self.scene.parameters[i].left_out => Atom::num(0),
            _ => Atom::var(self.engine_symbol(symbol)),
        }
    }

    /// A point's position in terms of coordinates.
    pub(super) fn point(&self, point: usize) -> &[Atom; 2] {
        &self.points[point]
    }

    /// A formula in terms of coordinates.
    pub(super) fn atom(&self, value: &Value) -> Atom {
        self.atom_where(value, |point, axis| self.points[point][axis].clone(), |i| self.symbol(Symbol::Coordinate(i)))
    }

    /// The size of a virtual displacement.
    pub(super) fn displacement(&self) -> Atom {
        self.symbol(Symbol::Displacement)
    }

    /// The derivative by the size of a virtual displacement, where there is none.
    pub(super) fn derivative_by_displacement(&self, atom: &Atom) -> Atom {
        let derivative = self.derivative(atom, Symbol::Displacement);
        let at_rest = derivative.replace(self.displacement().to_pattern()).with(Atom::num(0).to_pattern());
        self.simplify_inside(at_rest.as_view())
    }

    /// Simplifies what stands under roots and in denominators, so that equal ones are seen to be equal.
    fn simplify_inside(&self, view: AtomView) -> Atom {
        match view {
            AtomView::Add(sum) => sum.iter().fold(Atom::num(0), |sum, term| sum + self.simplify_inside(term)),
            AtomView::Mul(product) => product.iter().fold(Atom::num(1), |product, f| product * self.simplify_inside(f)),
            AtomView::Pow(power) => {
                let (base, exponent) = power.get_base_exp();
                self.simplify(&self.simplify_inside(base)).pow(exponent.to_owned())
            }
            _ => view.to_owned(),
        }
    }

    /// A formula in which points and coordinates stand for what is said.
    pub(super) fn atom_where(
        &self,
        value: &Value,
        point: impl Fn(usize, usize) -> Atom,
        coordinate: impl Fn(usize) -> Atom,
    ) -> Atom {
        if let Ok(mut place) = self.place.lock() {
            *place = (self.number, value.whole_span());
        }
        let mut atoms: Vec<Atom> = Vec::with_capacity(value.nodes().len());
        for node in value.nodes() {
            let atom = match node {
                Node::Number(number) => exact(number),
                Node::Name(quantity) => match *quantity {
                    Quantity::Parameter(i) => self.symbol(Symbol::Parameter(i)),
                    Quantity::Coordinate(i) => coordinate(i),
                    Quantity::Rate(i) => self.symbol(Symbol::Rate(i)),
                    Quantity::Point(p, axis) => point(p, axis),
                    Quantity::PointRate(p, axis) => self.rate(&self.points[p][axis]),
                    Quantity::Time => self.symbol(Symbol::Time),
                    Quantity::Pi => self.symbol(Symbol::Pi),
                    Quantity::Unknown => unreachable!("a scene with unknown names is not differentiated"),
                },
                Node::Negate(a) => -&atoms[*a],
                Node::Add(a, b) => &atoms[*a] + &atoms[*b],
                Node::Subtract(a, b) => &atoms[*a] - &atoms[*b],
                Node::Multiply(a, b) => &atoms[*a] * &atoms[*b],
                Node::Divide(a, b) => &atoms[*a] / &atoms[*b],
                Node::Power(a, b) => atoms[*a].pow(&atoms[*b]),
                Node::Call(function, arguments) => {
                    let arguments: Vec<Atom> = arguments.iter().map(|&i| self.simplify(&atoms[i])).collect();
                    self.call(*function, &arguments)
                }
            };
            atoms.push(atom);
        }
        atoms.pop().unwrap_or_else(|| Atom::num(0))
    }

    fn call(&self, f: Function, arguments: &[Atom]) -> Atom {
        let x = &arguments[0];
        match f {
            Function::Sqrt => x.sqrt(),
            Function::Sin => x.sin(),
            Function::Cos => x.cos(),
            Function::Tan => x.sin() / x.cos(),
            Function::Exp => x.exp(),
            Function::Log => x.log(),
            Function::Hypot => self.simplify(&(x * x + &arguments[1] * &arguments[1])).sqrt(),
            // The resolver has rejected every function without a derivative.
            _ => function!(symbol!(f.name()), x),
        }
    }

    /// The derivative of an atom.
    pub(super) fn derivative(&self, atom: &Atom, by: Symbol) -> Atom {
        atom.derivative(self.engine_symbol(by))
    }

    /// The derivative by every coordinate.
    pub(super) fn gradient(&self, atom: &Atom) -> Vec<Atom> {
        (0..self.scene.coordinates.len()).map(|i| self.derivative(atom, Symbol::Coordinate(i))).collect()
    }

    /// The time derivative of a function of coordinates: f_q qd.
    pub(super) fn rate(&self, atom: &Atom) -> Atom {
        self.contract(&self.gradient(atom), Symbol::Rate)
    }

    /// What the second time derivative of a function of coordinates has beside f_q qdd: (f_q qd)_q qd.
    pub(super) fn bias(&self, atom: &Atom) -> Atom {
        self.rate(&self.simplify(&self.rate(atom)))
    }

    /// The sum of components times symbols.
    pub(super) fn contract(&self, components: &[Atom], symbol: fn(usize) -> Symbol) -> Atom {
        let products = components.iter().enumerate().map(|(i, c)| c * &self.symbol(symbol(i)));
        products.fold(Atom::num(0), |sum, product| sum + product)
    }

    /// The cheapest of several equal forms: as it is, multiplied out, and with sin^2 + cos^2 = 1 used either way.
    pub(super) fn simplify(&self, atom: &Atom) -> Atom {
        let atom = &atom.expand_num();
        let expanded = atom.expand();
        let forms = [
            without_squares_of(EngineSymbol::COS, EngineSymbol::SIN, &expanded),
            without_squares_of(EngineSymbol::SIN, EngineSymbol::COS, &expanded),
            expanded,
            atom.clone(),
        ];
        let cost = |form: &Atom| self.term(form).cost();
        forms.into_iter().min_by_key(cost).unwrap_or_else(|| atom.clone())
    }

    /// The simplified atom as plain data.
    pub(super) fn simple_term(&self, atom: &Atom) -> Term {
        self.term(&self.simplify(atom))
    }

    /// An atom as plain data, as it is.
    pub(super) fn term(&self, atom: &Atom) -> Term {
        term(atom.as_view(), &self.places)
    }
}

/// Replaces even powers: f(x)^2 = 1 - g(x)^2 where f and g are sine and cosine.
fn without_squares_of(f: EngineSymbol, g: EngineSymbol, expanded: &Atom) -> Atom {
    let x = Atom::var(symbol!("x_"));
    let (f, g) = (function!(f, &x), function!(g, &x));
    let mut atom = expanded.clone();
    for exponent in (2..=8).rev() {
        let square = Atom::num(1) - g.pow(Atom::num(2));
        let replacement = f.pow(Atom::num(exponent - 2)) * square;
        atom = atom.replace(f.pow(Atom::num(exponent)).to_pattern()).with(replacement.to_pattern());
    }
    atom.expand()
}

fn exact(number: &Number) -> Atom {
    rational(&number.exact)
}

fn rational(value: &BigRational) -> Atom {
    let whole = |part: &BigInt| match part.to_i64() {
        Some(small) => Atom::num(small),
        None => parse!(part.to_string()),
    };
    whole(value.numer()) / whole(value.denom())
}
