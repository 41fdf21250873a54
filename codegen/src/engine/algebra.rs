//! What the derivation needs of the engine: atoms, derivatives, normal forms.

use std::cell::RefCell;
use std::collections::HashMap;
use std::sync::Once;

use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::ToPrimitive;
use symbolica::atom::{Atom, AtomCore, AtomView, Symbol as EngineSymbol};
use symbolica::{function, parse, symbol};

use super::Place;
use super::translate::term;
use crate::term::{Symbol, Term};
use qrm_scene::expression::{Node, Number};
use qrm_scene::function::Function;
use qrm_scene::resolve::all_values;
use qrm_scene::scene::{Quantity, Scene, Value};

/// The symbols of one scene, and its formulae in terms of them.
pub(super) struct Algebra<'s> {
    scene: &'s Scene,
    number: usize,
    place: &'s Place,
    symbols: HashMap<Symbol, EngineSymbol>,
    places: HashMap<EngineSymbol, Symbol>,
    points: Vec<[Atom; 2]>,
    /// What stands under the roots that have names; `None` if roots have no names.
    radicands: Option<RefCell<Vec<Atom>>>,
    /// What the signs are taken of.
    signs: RefCell<Vec<Atom>>,
}

impl<'s> Algebra<'s> {
    /// Defines the symbols of a scene, in an order that depends on nothing but the scene: the order of terms follows it.
    pub(super) fn new(number: usize, scene: &'s Scene, place: &'s Place) -> Self {
        Self::with(number, scene, place, None)
    }

    /// The same, where roots of what varies stand as symbols of their own.
    pub(super) fn naming_roots(number: usize, scene: &'s Scene, place: &'s Place) -> Self {
        Self::with(number, scene, place, Some(RefCell::default()))
    }

    fn with(number: usize, scene: &'s Scene, place: &'s Place, radicands: Option<RefCell<Vec<Atom>>>) -> Self {
        let (n, m) = (scene.coordinates.len(), scene.constraints.len());
        let mut wanted: Vec<Symbol> = (0..scene.parameters.len()).map(Symbol::Parameter).collect();
        wanted.extend([Symbol::Pi, Symbol::Time, Symbol::Displacement]);
        wanted.extend((0..n).map(Symbol::Coordinate));
        wanted.extend((0..n).map(Symbol::Rate));
        wanted.extend((0..n).map(Symbol::Acceleration));
        wanted.extend((0..m).map(Symbol::Multiplier));
        if radicands.is_some() {
            let is_root = |node: &&Node<Quantity>| matches!(node, Node::Call(Function::Sqrt | Function::Hypot, _));
            let roots = all_values(scene).into_iter().flat_map(|value| value.nodes()).filter(is_root).count();
            wanted.extend((0..roots).map(Symbol::Root));
            wanted.extend((0..roots).flat_map(|k| (0..n).map(move |i| Symbol::RootSlope(k, i))));
            wanted.extend((0..roots).map(Symbol::RootRate));
            wanted.extend((0..roots).map(Symbol::RootBias));
        }
        let has_sign = |node: &&Node<Quantity>| matches!(node, Node::Call(f, _) if f.is_piecewise());
        let signs = all_values(scene).into_iter().flat_map(|value| value.nodes()).filter(has_sign).count();
        // In a potential each may stand for several: of the length, and of what the length is, in more than one form.
        wanted.extend((0..6 * signs).map(Symbol::Sign));
        static DEFINED: Once = Once::new();
        DEFINED.call_once(define_symbols);
        let symbols: HashMap<_, _> =
            wanted.into_iter().enumerate().map(|(i, s)| (s, symbol!(format!("s{i}")))).collect();
        let places = symbols.iter().map(|(s, engine)| (*engine, *s)).collect();
        let mut algebra =
            Self { scene, number, place, symbols, places, points: Vec::new(), radicands, signs: RefCell::default() };
        for point in &scene.points {
            let position = [0, 1].map(|axis| algebra.atom(&point.position[axis]));
            algebra.points.push(position);
        }
        algebra
    }

    fn engine_symbol(&self, symbol: Symbol) -> EngineSymbol {
        self.symbols.get(&symbol).copied().unwrap_or(EngineSymbol::PI)
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

    /// The derivative of a potential by the length it depends on, which is a displacement in it, where that is `length`.
    pub(super) fn slope_of_potential(&self, potential: &Atom, length: &Atom) -> Atom {
        let slope = self.derivative(potential, Symbol::Displacement);
        // A sign may be taken of others, which come before it.
        let known = self.signs.borrow().clone();
        let mut moved: Vec<(Atom, Atom)> = vec![(self.displacement(), length.clone())];
        let at_length = |atom: &Atom, moved: &[(Atom, Atom)]| {
            moved
                .iter()
                .rev()
                .fold(atom.clone(), |atom, (from, to)| atom.replace(from.to_pattern()).with(to.to_pattern()))
        };
        for (k, argument) in known.iter().enumerate() {
            let there = at_length(argument, &moved);
            if there != *argument {
                moved.push((self.symbol(Symbol::Sign(k)), self.sign(&self.simplify(&there))));
            }
        }
        at_length(&slope, &moved)
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
        self.atom_with(value, point, coordinate, &[self.displacement(), Atom::num(0)])
    }

    /// The law of a load in terms of the length that it acts along and its rate.
    pub(super) fn law(&self, value: &Value, stretch: &[Atom; 2]) -> Atom {
        let coordinate = |i| self.symbol(Symbol::Coordinate(i));
        self.atom_with(value, |point, axis| self.points[point][axis].clone(), coordinate, stretch)
    }

    fn atom_with(
        &self,
        value: &Value,
        point: impl Fn(usize, usize) -> Atom,
        coordinate: impl Fn(usize) -> Atom,
        stretch: &[Atom; 2],
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
                    Quantity::Stretch => stretch[0].clone(),
                    Quantity::StretchRate => stretch[1].clone(),
                    Quantity::Time => self.symbol(Symbol::Time),
                    Quantity::Pi => self.symbol(Symbol::Pi),
                    Quantity::Unknown => unreachable!("a scene with unknown names is not differentiated"),
                },
                Node::Negate(a) => -&atoms[*a],
                Node::Add(a, b) => &atoms[*a] + &atoms[*b],
                Node::Subtract(a, b) => &atoms[*a] - &atoms[*b],
                Node::Multiply(a, b) => &atoms[*a] * &atoms[*b],
                Node::Divide(a, b) => &atoms[*a] / &atoms[*b],
                Node::Power(a, b) => self.power(&atoms[*a], &atoms[*b]),
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
            Function::Sqrt => self.root(x),
            Function::Sin => x.sin(),
            Function::Cos => x.cos(),
            Function::Tan => x.sin() / x.cos(),
            Function::Exp => x.exp(),
            Function::Log => x.log(),
            Function::Hypot => self.root(&self.simplify(&(x * x + &arguments[1] * &arguments[1]))),
            Function::Sign => self.sign(x),
            Function::Abs => x * self.sign(x),
            Function::Max => (x + &arguments[1] + self.distance(x, &arguments[1])) / Atom::num(2),
            Function::Min => (x + &arguments[1] - self.distance(x, &arguments[1])) / Atom::num(2),
            // The resolver has rejected every function without a derivative.
            _ => function!(symbol!(f.name()), x),
        }
    }

    /// A power with a fixed exponent; of a fraction, that of its parts, which the engine keeps apart only then.
    fn power(&self, base: &Atom, exponent: &Atom) -> Atom {
        if matches!(self.term(exponent), Term::Number(exponent) if exponent.is_integer()) {
            return base.pow(exponent);
        }
        let base = self.simplify(base);
        match self.term(&base) {
            Term::Number(number) if !number.is_integer() => {
                let part = |part: &BigInt| rational(&BigRational::from(part.clone())).pow(exponent);
                part(number.numer()) / part(number.denom())
            }
            _ => base.pow(exponent),
        }
    }

    /// The hyperbolic tangent.
    pub(super) fn tanh(&self, x: &Atom) -> Atom {
        self.call(Function::Tanh, &[self.simplify(x)])
    }

    /// The absolute value of a difference.
    fn distance(&self, a: &Atom, b: &Atom) -> Atom {
        let difference = self.simplify(&(a - b));
        &difference * self.sign(&difference)
    }

    /// A sign, under its name: it has no derivative but where it jumps.
    fn sign(&self, x: &Atom) -> Atom {
        let mut known = self.signs.borrow_mut();
        let place = known.iter().position(|other| other == x).unwrap_or_else(|| {
            known.push(x.clone());
            known.len() - 1
        });
        self.symbol(Symbol::Sign(place))
    }

    /// A root, under its name if roots have names and what stands under it varies.
    fn root(&self, radicand: &Atom) -> Atom {
        let names = self.radicands.as_ref().filter(|_| self.varies(radicand));
        let half = Atom::num(1) / Atom::num(2);
        let Some(mut known) = names.map(RefCell::borrow_mut) else { return self.power(radicand, &half) };
        let place = known.iter().position(|r| r == radicand).unwrap_or_else(|| {
            known.push(radicand.clone());
            known.len() - 1
        });
        self.symbol(Symbol::Root(place))
    }

    /// What stands under the roots that have names.
    pub(super) fn radicands(&self) -> Vec<Atom> {
        self.radicands.as_ref().map(|r| r.borrow().clone()).unwrap_or_default()
    }

    fn varies(&self, atom: &Atom) -> bool {
        self.term(atom).any_symbol(&|symbol| matches!(symbol, Symbol::Coordinate(_) | Symbol::Root(_)))
    }

    /// The derivative of an atom.
    pub(super) fn derivative(&self, atom: &Atom, by: Symbol) -> Atom {
        let by = self.engine_symbol(by);
        // Most formulae of a large mechanism do without most of its coordinates.
        if atom.contains_symbol(by) { atom.derivative(by) } else { Atom::num(0) }
    }

    /// The derivative by every coordinate.
    pub(super) fn gradient(&self, atom: &Atom) -> Vec<Atom> {
        if matches!(atom.as_view(), AtomView::Num(_)) {
            return vec![Atom::num(0); self.scene.coordinates.len()];
        }
        let direct = |i| self.derivative(atom, Symbol::Coordinate(i));
        let through =
            |i: usize| self.by_roots(atom).fold(Atom::num(0), |sum, (k, slope)| sum + slope * self.root_slope(k, i));
        (0..self.scene.coordinates.len()).map(|i| direct(i) + through(i)).collect()
    }

    /// The derivative of a named root by a coordinate: a symbol, unless it is zero.
    fn root_slope(&self, k: usize, i: usize) -> Atom {
        let radicand = self.radicands.as_ref().and_then(|known| known.borrow().get(k).cloned());
        let moves = |radicand: Atom| self.gradient(&radicand)[i] != Atom::num(0);
        if radicand.is_some_and(moves) { self.symbol(Symbol::RootSlope(k, i)) } else { Atom::num(0) }
    }

    /// The derivatives by the named roots that occur.
    fn by_roots(&self, atom: &Atom) -> impl Iterator<Item = (usize, Atom)> {
        let known = self.radicands.as_ref().map_or(0, |known| known.borrow().len());
        let by = |k: usize| (k, self.derivative(atom, Symbol::Root(k)));
        (0..known).map(by).filter(|(_, slope)| *slope != Atom::num(0))
    }

    /// The time derivative of a function of coordinates and time: f_q qd + f_t.
    pub(super) fn rate(&self, atom: &Atom) -> Atom {
        let direct = |i| self.derivative(atom, Symbol::Coordinate(i));
        let direct: Vec<Atom> = (0..self.scene.coordinates.len()).map(direct).collect();
        let direct = self.contract(&direct, Symbol::Rate) + self.derivative(atom, Symbol::Time);
        let through = |sum, (k, slope)| sum + slope * self.symbol(Symbol::RootRate(k));
        self.by_roots(atom).fold(direct, through)
    }

    /// The same with the coordinates held: f_t.
    pub(super) fn drift(&self, atom: &Atom) -> Atom {
        let through = |sum: Atom, (k, slope): (usize, Atom)| {
            let radicand = self.radicands.as_ref().and_then(|known| known.borrow().get(k).cloned());
            let drift = radicand.map_or_else(|| Atom::num(0), |radicand| self.drift(&radicand));
            sum + slope * drift / (Atom::num(2) * self.symbol(Symbol::Root(k)))
        };
        self.by_roots(atom).fold(self.derivative(atom, Symbol::Time), through)
    }

    /// What the second time derivative of such a function has beside f_q qdd: (f_q qd + f_t)_q qd + (f_q qd + f_t)_t.
    pub(super) fn bias(&self, atom: &Atom) -> Atom {
        let through = |sum, (k, slope)| sum + slope * self.symbol(Symbol::RootBias(k));
        self.by_roots(atom).fold(self.rate(&self.simplify(&self.rate(atom))), through)
    }

    /// The sum of components times symbols.
    pub(super) fn contract(&self, components: &[Atom], symbol: fn(usize) -> Symbol) -> Atom {
        let zero = Atom::num(0);
        let products = components.iter().enumerate().filter(|(_, c)| **c != zero);
        let products = products.map(|(i, c)| c * &self.symbol(symbol(i)));
        products.fold(Atom::num(0), |sum, product| sum + product)
    }

    /// The cheapest of several equal forms: as it is, multiplied out, and with sin^2 + cos^2 = 1 used either way.
    pub(super) fn simplify(&self, atom: &Atom) -> Atom {
        if matches!(atom.as_view(), AtomView::Num(_) | AtomView::Var(_)) {
            return atom.clone();
        }
        let atom = &atom.expand_num();
        let expanded = atom.expand();
        let term = self.term(&expanded);
        let cost = |form: &Atom| self.term(form).cost();
        if !term.has_square() {
            return if term.cost() <= cost(atom) { expanded } else { atom.clone() };
        }
        let forms = [
            without_squares_of(EngineSymbol::COS, EngineSymbol::SIN, &expanded),
            without_squares_of(EngineSymbol::SIN, EngineSymbol::COS, &expanded),
            expanded,
            atom.clone(),
        ];
        forms.into_iter().min_by_key(cost).unwrap_or_else(|| atom.clone())
    }

    /// The simplified atom as plain data.
    pub(super) fn simple_term(&self, atom: &Atom) -> Term {
        self.term(&self.simplify(atom))
    }

    /// An atom as plain data, as it is.
    pub(super) fn term(&self, atom: &Atom) -> Term {
        let plain = term(atom.as_view(), &self.places);
        if self.signs.borrow().is_empty() {
            return plain;
        }
        plain.replacing(&|symbol| {
            let Symbol::Sign(k) = symbol else { return None };
            let argument = self.signs.borrow()[k].clone();
            Some(Term::Call(Function::Sign, Box::new(self.term(&argument))))
        })
    }
}

/// So many symbols are there before anything else.
const SYMBOLS: usize = 4096;

/// The order of terms follows the order in which symbols were defined: they are the same for every scene, so that what is written
/// of one does not depend on those before it.
fn define_symbols() {
    for name in ["x_", "asin", "acos", "atan", "sinh", "cosh", "tanh"] {
        symbol!(name);
    }
    (0..SYMBOLS).for_each(|i| {
        symbol!(format!("s{i}"));
    });
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
