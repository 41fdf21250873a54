//! The symbols of a scene in the engine, and the scene's formulae in terms of them.

use std::cell::RefCell;
use std::collections::HashMap;
use std::sync::Arc;

use symbolica::atom::{Atom, AtomCore, AtomView, Symbol as EngineSymbol};
use symbolica::symbol;

use super::Place;
use super::entry::{Entry, expands_too_much};
use super::number::exact;
use super::sparse::is_sparse;
use super::spline_names::{ORDERS, spline_name, splines_of};
use super::switch::Switch;
use super::translate::term;
use qrm_codegen::term::{Symbol, Term};
use qrm_scene::expression::Node;
use qrm_scene::function::Function;
use qrm_scene::resolve::all_values;
use qrm_scene::scene::{Quantity, Scene, Value};
use qrm_scene::spline::Spline;

/// The symbols of one scene, and the scene's formulae in terms of them.
pub(super) struct Algebra<'s> {
    pub(super) scene: &'s Scene,
    number: usize,
    place: &'s Place,
    symbols: HashMap<Symbol, EngineSymbol>,
    places: HashMap<EngineSymbol, Symbol>,
    points: Vec<[Atom; 2]>,
    /// Whether varying roots have names.
    pub(super) names_roots: bool,
    /// Whether formulae that would expand too much have names.
    pub(super) names_formulae: bool,
    /// Whether named quantities are variables: derivatives are those with respect to what stands in a formula.
    pub(super) names_are_variables: bool,
    /// The named quantities, each after those that it uses.
    pub(super) names: RefCell<Vec<Entry>>,
    /// The named sums by the first of their terms.
    pub(super) sums: RefCell<HashMap<Atom, Vec<usize>>>,
    /// The switches and their arguments.
    pub(super) switches: RefCell<Vec<(Switch, Atom)>>,
    /// The splines of the scene, without duplicates.
    pub(super) splines: Vec<Arc<Spline>>,
}

impl<'s> Algebra<'s> {
    /// Defines the symbols of a scene. Their order depends only on the scene, because it determines the order of terms.
    /// Quantities have names if formulae would expand too much.
    pub(super) fn new(number: usize, scene: &'s Scene, place: &'s Place) -> Self {
        // Linearized equations need higher derivatives than names support.
        let is_named = expands_too_much(scene) && !scene.run.stiff;
        Self::with(number, scene, place, is_named, false)
    }

    /// Creates the algebra of a scene in which varying roots have names.
    pub(super) fn naming_roots(number: usize, scene: &'s Scene, place: &'s Place) -> Self {
        Self::with(number, scene, place, true, false)
    }

    /// Creates the algebra of a scene in which all points, arguments and roots are variables.
    pub(super) fn with_names_as_variables(number: usize, scene: &'s Scene, place: &'s Place) -> Self {
        Self::with(number, scene, place, true, true)
    }

    fn with(number: usize, scene: &'s Scene, place: &'s Place, names_roots: bool, names_are_variables: bool) -> Self {
        let names_formulae = names_roots && (names_are_variables || expands_too_much(scene));
        let symbols: HashMap<_, _> = symbols_of(scene, names_roots, names_are_variables)
            .into_iter()
            .enumerate()
            .map(|(i, s)| (s, symbol!(format!("s{i}"))))
            .collect();
        let places = symbols.iter().map(|(s, engine)| (*engine, *s)).collect();
        let mut algebra = Self {
            scene,
            number,
            place,
            symbols,
            places,
            points: Vec::new(),
            names_roots,
            names_formulae,
            names_are_variables,
            names: RefCell::default(),
            sums: RefCell::default(),
            switches: RefCell::default(),
            splines: splines_of(scene),
        };
        algebra.name_angles();
        for point in &scene.points {
            let position = [0, 1].map(|axis| {
                algebra
                    .named_if_long(algebra.atom(&point.position[axis]), &format!("{}_{}", point.name, ["x", "y"][axis]))
            });
            algebra.points.push(position);
        }
        algebra
    }

    /// Names long angles of bodies, before they are found as arguments of sines and cosines and named as such.
    fn name_angles(&self) {
        for body in &self.scene.bodies {
            let is_plain = |angle: &&Value| !angle.names().any(|quantity| matches!(quantity, Quantity::Point(..)));
            if let Some(angle) = body.angle.as_ref().filter(is_plain) {
                drop(self.named_if_long(self.atom(angle), &format!("{}_angle", body.name)));
            }
        }
    }

    pub(super) fn engine_symbol(&self, symbol: Symbol) -> EngineSymbol {
        self.symbols.get(&symbol).copied().unwrap_or(EngineSymbol::PI)
    }

    /// The symbol of the scene for a symbol of the engine.
    pub(super) fn scene_symbol(&self, symbol: EngineSymbol) -> Option<Symbol> {
        self.places.get(&symbol).copied()
    }

    /// Whether roots have names, or there are none.
    pub(super) fn has_named_roots(&self) -> bool {
        self.names_roots || names_at_most(self.scene, false) == 0
    }

    /// A symbol as an atom; omitted parameters are zero.
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

    /// The symbol of the size of a virtual displacement.
    pub(super) fn displacement(&self) -> Atom {
        self.symbol(Symbol::Displacement)
    }

    /// The derivative with respect to the size of a virtual displacement, at size zero.
    pub(super) fn derivative_by_displacement(&self, atom: &Atom) -> Atom {
        let derivative = self.derivative(atom, Symbol::Displacement);
        let at_rest = self.at_rest(derivative.as_view());
        self.simplify_inside(at_rest.as_view())
    }

    /// An expression at zero displacement. The engine itself would mishandle roots of the fractions that appear there.
    fn at_rest(&self, view: AtomView) -> Atom {
        match view {
            AtomView::Add(sum) => sum.iter().fold(Atom::num(0), |sum, term| sum + self.at_rest(term)),
            AtomView::Mul(product) => product.iter().fold(Atom::num(1), |product, f| product * self.at_rest(f)),
            AtomView::Pow(power) => {
                let (base, exponent) = power.get_base_exp();
                self.power(&self.at_rest(base), &exponent.to_owned())
            }
            _ => view.to_owned().replace(self.displacement().to_pattern()).with(Atom::num(0).to_pattern()),
        }
    }

    /// The derivative of a potential with respect to its length, evaluated at `length`; the displacement represents the
    /// length in the potential.
    pub(super) fn slope_of_potential(&self, potential: &Atom, length: &Atom) -> Atom {
        let slope = self.derivative(potential, Symbol::Displacement);
        // The argument of a switch may contain earlier switches.
        let known = self.switches.borrow().clone();
        let mut moved: Vec<(Atom, Atom)> = vec![(self.displacement(), length.clone())];
        let at_length = |atom: &Atom, moved: &[(Atom, Atom)]| {
            moved
                .iter()
                .rev()
                .fold(atom.clone(), |atom, (from, to)| atom.replace(from.to_pattern()).with(to.to_pattern()))
        };
        for (k, (switch, argument)) in known.iter().enumerate() {
            let there = at_length(argument, &moved);
            if there != *argument {
                moved.push((self.symbol(Symbol::Switch(k)), self.switch(*switch, &self.simplify(&there))));
            }
        }
        at_length(&slope, &moved)
    }

    /// Converts a formula, with given expressions for points and coordinates.
    pub(super) fn atom_where(
        &self,
        value: &Value,
        point: impl Fn(usize, usize) -> Atom,
        coordinate: impl Fn(usize) -> Atom,
    ) -> Atom {
        self.atom_with(value, point, coordinate, &[self.displacement(), Atom::num(0)])
    }

    /// The law of a load in terms of its length and rate.
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
        let mut is_inner = vec![false; value.nodes().len()];
        for node in value.nodes() {
            if let Node::Add(a, b) | Node::Subtract(a, b) = node {
                [a, b].into_iter().for_each(|operand| is_inner[*operand] = true);
            }
        }
        let mut atoms: Vec<Atom> = Vec::with_capacity(value.nodes().len());
        for (place, node) in value.nodes().iter().enumerate() {
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
                    other => unreachable!("{other:?} is in no formula that is differentiated"),
                },
                Node::Negate(a) => -&atoms[*a],
                // The sum that contains it adds its terms: adding them one by one would normalize each partial sum.
                // Each node is an operand of one other node.
                Node::Add(..) | Node::Subtract(..) if is_inner[place] => Atom::num(0),
                Node::Add(..) | Node::Subtract(..) => {
                    let mut terms = Vec::new();
                    collect_terms(value.nodes(), place, false, &atoms, &mut terms);
                    Atom::add_many(&terms)
                }
                Node::Multiply(a, b) => &atoms[*a] * &atoms[*b],
                Node::Divide(a, b) => &atoms[*a] / &atoms[*b],
                Node::Power(a, b) => self.power(&atoms[*a], &atoms[*b]),
                Node::Call(function, arguments) => {
                    let argument = |&i: &usize| {
                        let argument = self.simplify(&atoms[i]);
                        if is_root(function) { argument } else { self.named_if_long(argument, "argument") }
                    };
                    let arguments: Vec<Atom> = arguments.iter().map(argument).collect();
                    self.call(*function, &arguments)
                }
                Node::Spline(spline, a) => {
                    let argument = self.named_if_long(self.simplify(&atoms[*a]), "argument");
                    self.spline(spline, argument)
                }
            };
            atoms.push(atom);
        }
        atoms.pop().unwrap_or_else(|| Atom::num(0))
    }

    /// The simplified atom as plain data.
    pub(super) fn simple_term(&self, atom: &Atom) -> Term {
        self.term(&self.simplify(atom))
    }

    /// An atom as plain data, without simplification.
    pub(super) fn term(&self, atom: &Atom) -> Term {
        let plain = term(atom.as_view(), &self.places, &self.splines);
        if self.switches.borrow().is_empty() {
            return plain;
        }
        plain.replacing(&|symbol| {
            let Symbol::Switch(k) = symbol else { return None };
            let (switch, argument) = self.switches.borrow()[k].clone();
            Some(switch.on_side(Term::Call(Function::Sign, Box::new(self.term(&argument)))))
        })
    }
}

/// Collects the terms of a sum and of the sums in it.
fn collect_terms(nodes: &[Node<Quantity>], place: usize, is_negative: bool, atoms: &[Atom], terms: &mut Vec<Atom>) {
    match nodes[place] {
        Node::Add(a, b) => {
            collect_terms(nodes, a, is_negative, atoms, terms);
            collect_terms(nodes, b, is_negative, atoms, terms);
        }
        Node::Subtract(a, b) => {
            collect_terms(nodes, a, is_negative, atoms, terms);
            collect_terms(nodes, b, !is_negative, atoms, terms);
        }
        _ => terms.push(if is_negative { -&atoms[place] } else { atoms[place].clone() }),
    }
}

fn is_root(function: &Function) -> bool {
    matches!(function, Function::Sqrt | Function::Hypot)
}

/// An upper bound of the number of named quantities: roots, and with `formulae` arguments, points and positions of
/// bodies.
fn names_at_most(scene: &Scene, formulae: bool) -> usize {
    let nodes = all_values(scene).into_iter().flat_map(|value| value.nodes());
    let named = |node: &Node<Quantity>| match node {
        Node::Call(function, _) if is_root(function) => 1,
        Node::Call(_, arguments) if formulae => arguments.len(),
        Node::Spline(..) if formulae => 1,
        _ => 0,
    };
    nodes.map(named).sum::<usize>() + if formulae { 2 * scene.points.len() + 3 * scene.bodies.len() } else { 0 }
}

/// Defines the largest number of symbols that any of the scenes needs, before anything else. The order of terms follows
/// the order of definitions, so the output for a scene does not depend on earlier scenes.
pub(super) fn define_symbols(scenes: &[&Scene]) {
    for name in ["x_", "asin", "acos", "atan", "sinh", "cosh", "tanh"] {
        symbol!(name);
    }
    let splines = scenes.iter().map(|scene| splines_of(scene).len()).max().unwrap_or(0);
    for (k, order) in (0..splines).flat_map(|k| (0..=ORDERS).map(move |order| (k, order))) {
        symbol!(spline_name(k, order));
    }
    // A large tree needs the symbols of slopes, one for each name and coordinate, only if its sparse elimination fails.
    // They are then defined after these, in the same order.
    let kinds = |scene: &Scene| [!scene.is_large_tree(), is_sparse(scene)];
    let count = |scene: &Scene| {
        let kinds = [false, true].into_iter().zip(kinds(scene)).filter(|(_, is_needed)| *is_needed);
        kinds.map(|(variables, _)| symbols_of(scene, true, variables).len()).max()
    };
    let most = scenes.iter().filter_map(|scene| count(scene)).max();
    (0..most.unwrap_or(0)).for_each(|i| {
        symbol!(format!("s{i}"));
    });
}

/// The symbols of a scene, in order.
fn symbols_of(scene: &Scene, names_roots: bool, names_are_variables: bool) -> Vec<Symbol> {
    let (n, m) = (scene.coordinates.len(), scene.constraints.len());
    let mut wanted: Vec<Symbol> = (0..scene.parameters.len()).map(Symbol::Parameter).collect();
    wanted.extend([Symbol::Pi, Symbol::Time, Symbol::Displacement]);
    wanted.extend((0..n).map(Symbol::Coordinate));
    wanted.extend((0..n).map(Symbol::Rate));
    wanted.extend((0..n).map(Symbol::Acceleration));
    wanted.extend((0..m).map(Symbol::Multiplier));
    let names = if names_roots { names_at_most(scene, names_are_variables || expands_too_much(scene)) } else { 0 };
    wanted.extend((0..names).map(Symbol::Named));
    if names_are_variables {
        wanted.extend((0..names).map(Symbol::NamedAcceleration));
    } else {
        wanted.extend((0..names).flat_map(|k| (0..n).map(move |i| Symbol::NamedSlope(k, i))));
    }
    wanted.extend((0..names).map(Symbol::NamedRate));
    wanted.extend((0..names).map(Symbol::NamedBias));
    let is_piecewise = |node: &&Node<Quantity>| matches!(node, Node::Call(f, _) if f.is_piecewise());
    let piecewise = all_values(scene).into_iter().flat_map(|value| value.nodes()).filter(is_piecewise).count();
    // In a potential each one may need several switches: for the length, and for several forms of the length's formula.
    wanted.extend((0..12 * piecewise).map(Symbol::Switch));
    wanted.extend(scene.normal_forces().into_iter().map(Symbol::NormalForce));
    wanted
}
