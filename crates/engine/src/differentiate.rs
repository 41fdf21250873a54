//! Derivatives by the chain rule over named quantities, each differentiated once.

use std::collections::{BTreeSet, HashSet};

use symbolica::atom::{Atom, AtomCore, AtomView, Symbol as EngineSymbol};
use symbolica::{function, symbol};

use super::algebra::Algebra;
use super::entry::{COORDINATES, Entry};
use super::spline_names::{ORDERS, spline_name};
use qrm_codegen::term::{Formula, Named, NamedKind, Root, Symbol};
use qrm_scene::scene::Scene;

impl Algebra<'_> {
    /// The derivative of an expression with respect to a symbol of the engine.
    pub(super) fn derivative_by(&self, atom: &Atom, by: EngineSymbol) -> Atom {
        let mut derivative = atom.derivative(by);
        let inside = Atom::var(symbol!("x_"));
        for (k, order) in (0..self.splines.len()).flat_map(|k| (0..=ORDERS).map(move |order| (k, order))) {
            let own = Atom::var(symbol!(spline_name(k, order)));
            let unknown = function!(EngineSymbol::DERIVATIVE, Atom::num(1), own, &inside);
            let known = match order {
                ORDERS => Atom::num(0),
                order => function!(symbol!(spline_name(k, order + 1)), &inside),
            };
            derivative = derivative.replace(unknown.to_pattern()).with(known.to_pattern());
        }
        derivative
    }

    /// The symbol of a quantity, which is named if necessary. Names of roots are final only at the end.
    pub(super) fn name(&self, formula: &Atom, is_root: bool, name: &str) -> Atom {
        let formula = &if is_root { formula.clone() } else { self.in_known_sums(formula) };
        let known = self.names.borrow().iter().position(|e| e.is_root == is_root && e.formula == *formula);
        let place = known.unwrap_or_else(|| {
            let gradient = self.gradient(formula);
            let gradient = if is_root { gradient } else { gradient.iter().map(|entry| self.simplify(entry)).collect() };
            let place = self.names.borrow().len();
            let slope = |(i, entry): (usize, &Atom)| match entry.as_view() {
                AtomView::Num(number) if !is_root || number.is_zero() => entry.clone(),
                // A derivative that simplifies to zero has no symbol.
                _ if is_root && self.simplify(entry).is_zero() => Atom::num(0),
                _ => self.symbol(Symbol::NamedSlope(place, i)),
            };
            let slopes: Vec<Atom> = gradient.iter().enumerate().map(slope).collect();
            let name = if is_root { String::new() } else { self.unique(name) };
            let moving = slopes.iter().enumerate().filter(|(_, slope)| !slope.is_zero()).map(|(i, _)| i);
            let coordinates = if self.names_are_variables {
                self.coordinates_in(formula).unwrap_or_default()
            } else {
                moving.collect()
            };
            let time_derivative = self.partial_time_derivative(formula);
            let formula = formula.clone();
            if let AtomView::Add(sum) = formula.as_view()
                && !is_root
            {
                let first = sum.iter().next().map(|term| term.to_owned());
                first.into_iter().for_each(|term| self.sums.borrow_mut().entry(term).or_default().push(place));
            }
            let entry = Entry { name, is_root, formula, gradient, slopes, time_derivative, coordinates };
            self.names.borrow_mut().push(entry);
            place
        });
        self.symbol(Symbol::Named(place))
    }

    /// An unused name.
    fn unique(&self, wish: &str) -> String {
        let names = self.names.borrow();
        let is_taken = |name: &String| self.scene.names().any(|n| n == name) || names.iter().any(|e| e.name == *name);
        let numbered = (2..).map(|number| format!("{wish}_{number}"));
        std::iter::once(wish.to_owned()).chain(numbered).find(|name| !is_taken(name)).unwrap_or_default()
    }

    /// The symbol of a quantity that depends on many coordinates, if such quantities have names; otherwise the quantity
    /// itself.
    pub(super) fn named_if_long(&self, atom: Atom, name: &str) -> Atom {
        let is_symbol = matches!(atom.as_view(), AtomView::Num(_) | AtomView::Var(_));
        let most = if self.names_are_variables { 1 } else { COORDINATES };
        if is_symbol || !self.names_formulae || self.coordinates(&atom).is_none_or(|count| count <= most) {
            return atom;
        }
        self.name(&self.simplify(&atom), false, name)
    }

    /// The number of coordinates on which an expression depends, also through names.
    ///
    /// `None` if it depends on rates or on a displacement.
    pub(super) fn coordinates(&self, atom: &Atom) -> Option<usize> {
        Some(self.coordinates_in(atom)?.len())
    }

    /// The coordinates on which an expression depends, likewise.
    fn coordinates_in(&self, atom: &Atom) -> Option<HashSet<usize>> {
        let (mut found, mut pending) = (HashSet::new(), self.occurring(atom));
        while let Some(symbol) = pending.pop() {
            match symbol {
                Symbol::Parameter(_) | Symbol::Pi | Symbol::Time => {}
                Symbol::Switch(k) => pending.extend(self.occurring(&self.switch_argument(k))),
                Symbol::Coordinate(i) => {
                    found.insert(i);
                }
                Symbol::Named(k) => found.extend(&self.names.borrow()[k].coordinates),
                _ => return None,
            }
        }
        Some(found)
    }

    /// The expression with named sums in place of their terms, where names are variables.
    pub(super) fn in_known_sums(&self, atom: &Atom) -> Atom {
        let terms = |atom: &Atom| -> Vec<Atom> {
            match atom.as_view() {
                AtomView::Add(sum) => sum.iter().map(|term| term.to_owned()).collect(),
                _ => Vec::new(),
            }
        };
        let mut own: HashSet<Atom> = terms(atom).into_iter().collect();
        if !self.names_are_variables || own.len() < 3 {
            return atom.clone();
        }
        let (names, sums) = (self.names.borrow(), self.sums.borrow());
        let with = |term: &Atom| sums.get(term).into_iter().flatten().copied();
        let mut candidates: BTreeSet<usize> = own.iter().flat_map(with).collect();
        while let Some(k) = candidates.pop_first() {
            let part = terms(&names[k].formula);
            if part.len() < own.len() && part.iter().all(|term| own.contains(term)) {
                for term in &part {
                    own.remove(term);
                }
                let name = self.symbol(Symbol::Named(k));
                candidates.extend(with(&name).filter(|other| *other > k));
                own.insert(name);
            }
        }
        Atom::add_many(own.into_iter().collect::<Vec<_>>())
    }

    /// The derivatives with respect to the coordinates and names that occur, without zeros.
    pub(super) fn local_derivatives(&self, atom: &Atom) -> Vec<(Symbol, Atom)> {
        let mut occurring = self.occurring(atom);
        occurring.retain(|symbol| matches!(symbol, Symbol::Coordinate(_) | Symbol::Named(_)));
        occurring.sort_unstable();
        let by = occurring.into_iter().map(|symbol| (symbol, self.simplify(&self.derivative(atom, symbol))));
        by.filter(|(_, derivative)| !derivative.is_zero()).collect()
    }

    /// The second rate, without the parts proportional to second rates of coordinates and names.
    pub(super) fn local_bias(&self, atom: &Atom) -> Atom {
        self.rate(&self.simplify(&self.rate(atom)))
    }

    /// The second rate in terms of accelerations.
    pub(super) fn second_rate(&self, atom: &Atom) -> Atom {
        if !self.names_are_variables {
            return self.contract(&self.gradient(atom), Symbol::Acceleration) + self.bias(atom);
        }
        let acceleration = |symbol: Symbol| match symbol {
            Symbol::Named(k) => self.symbol(Symbol::NamedAcceleration(k)),
            Symbol::Coordinate(i) => self.symbol(Symbol::Acceleration(i)),
            _ => Atom::num(0),
        };
        let by = self.local_derivatives(atom);
        by.into_iter().fold(self.local_bias(atom), |sum, (symbol, by)| sum + by * acceleration(symbol))
    }

    /// The symbols that occur in an expression.
    fn occurring(&self, atom: &Atom) -> Vec<Symbol> {
        let mut found = HashSet::new();
        collect(atom.as_view(), &mut found);
        found.into_iter().filter_map(|symbol| self.scene_symbol(symbol)).collect()
    }

    /// The derivative of an expression with respect to a symbol, with names held constant.
    pub(super) fn derivative(&self, atom: &Atom, by: Symbol) -> Atom {
        let by = self.engine_symbol(by);
        // In a large mechanism, most formulae contain few coordinates.
        if atom.contains_symbol(by) { self.derivative_by(atom, by) } else { Atom::num(0) }
    }

    /// The derivatives with respect to all coordinates; empty where names are variables.
    pub(super) fn gradient(&self, atom: &Atom) -> Vec<Atom> {
        if self.names_are_variables {
            return Vec::new();
        }
        let occurring = self.occurring(atom);
        let direct = |i: usize| match occurring.contains(&Symbol::Coordinate(i)) {
            true => self.derivative_by(atom, self.engine_symbol(Symbol::Coordinate(i))),
            false => Atom::num(0),
        };
        let by_names = self.by_names(atom, &occurring);
        let names = self.names.borrow();
        let through = |i: usize| {
            let moving = by_names.iter().filter(|(k, _)| !names[*k].slopes[i].is_zero());
            moving.fold(direct(i), |sum, (k, slope)| sum + slope * &names[*k].slopes[i])
        };
        (0..self.scene.coordinates.len()).map(through).collect()
    }

    /// The derivatives with respect to the names that occur.
    fn by_names(&self, atom: &Atom, occurring: &[Symbol]) -> Vec<(usize, Atom)> {
        let name = |symbol: &Symbol| if let Symbol::Named(k) = symbol { Some(*k) } else { None };
        let mut named: Vec<usize> = occurring.iter().filter_map(name).collect();
        named.sort_unstable();
        let by = |k: usize| (k, self.derivative_by(atom, self.engine_symbol(Symbol::Named(k))));
        named.into_iter().map(by).collect()
    }

    /// The total derivative of a function of coordinates and time with respect to time: f_q qd + f_t.
    pub(super) fn rate(&self, atom: &Atom) -> Atom {
        let occurring = self.occurring(atom);
        let mut direct = self.derivative(atom, Symbol::Time);
        for symbol in &occurring {
            if let Symbol::Coordinate(i) = symbol {
                direct += self.derivative(atom, *symbol) * self.symbol(Symbol::Rate(*i));
            }
        }
        let through = |sum, (k, slope)| sum + slope * self.symbol(Symbol::NamedRate(k));
        self.by_names(atom, &occurring).into_iter().fold(direct, through)
    }

    /// The rate of an expression due to the rates of the coordinates: a prescribed motion exchanges work only with its
    /// drive.
    pub(super) fn velocity(&self, atom: &Atom) -> Atom {
        match self.names_are_variables {
            true => self.rate(atom) - self.partial_time_derivative(atom),
            false => self.contract(&self.gradient(atom), Symbol::Rate),
        }
    }

    /// The partial derivative with respect to time, f_t.
    pub(super) fn partial_time_derivative(&self, atom: &Atom) -> Atom {
        let names = self.names.borrow();
        let through = |sum: Atom, (k, slope): (usize, Atom)| {
            let over = if names[k].is_root { Atom::num(2) * self.symbol(Symbol::Named(k)) } else { Atom::num(1) };
            sum + slope * &names[k].time_derivative / over
        };
        self.by_names(atom, &self.occurring(atom)).into_iter().fold(self.derivative(atom, Symbol::Time), through)
    }

    /// The second derivative of such a function with respect to time, without f_q qdd: (f_q qd + f_t)_q qd + (f_q qd +
    /// f_t)_t.
    pub(super) fn bias(&self, atom: &Atom) -> Atom {
        let through = |sum, (k, slope)| sum + slope * self.symbol(Symbol::NamedBias(k));
        self.by_names(atom, &self.occurring(atom)).into_iter().fold(self.local_bias(atom), through)
    }

    /// The sum of products of components and symbols.
    pub(super) fn contract(&self, components: &[Atom], symbol: fn(usize) -> Symbol) -> Atom {
        let products = components.iter().enumerate().filter(|(_, c)| !c.is_zero());
        let products = products.map(|(i, c)| c * &self.symbol(symbol(i)));
        products.fold(Atom::num(0), |sum, product| sum + product)
    }

    /// The formula of a name, or the expression itself if it is not a name.
    pub(super) fn definition(&self, atom: &Atom) -> Atom {
        match self.place(atom) {
            Some(k) => self.names.borrow()[k].formula.clone(),
            None => atom.clone(),
        }
    }

    /// The derivatives of a row with respect to the coordinates, as formulae; `None` unless the row has a name.
    pub(super) fn slopes(&self, atom: &Atom) -> Option<Vec<Atom>> {
        self.place(atom).map(|k| self.names.borrow()[k].gradient.clone())
    }

    /// The index of a named formula, given its symbol.
    fn place(&self, atom: &Atom) -> Option<usize> {
        let AtomView::Var(variable) = atom.as_view() else { return None };
        match self.scene_symbol(variable.get_symbol()) {
            Some(Symbol::Named(k)) if !self.names.borrow()[k].is_root => Some(k),
            _ => None,
        }
    }

    /// The named quantities as plain data, each after those that it uses.
    pub(super) fn named(&self) -> Vec<Named> {
        let names = self.names.borrow();
        let roots = names.iter().filter(|entry| entry.is_root).count();
        let letter = root_letter(self.scene);
        let mut seen = 0;
        let mut list = Vec::new();
        let half = |atom: &Atom| self.simple_term(&(atom / Atom::num(2)));
        for entry in names.iter() {
            let formula = &entry.formula;
            list.push(if entry.is_root {
                seen += 1;
                let name = if roots == 1 { letter.to_owned() } else { format!("{letter}{seen}") };
                let kind = NamedKind::Root(Root {
                    radicand: self.simple_term(formula),
                    slopes: entry.gradient.iter().map(half).collect(),
                    half_time_derivative: half(&self.partial_time_derivative(formula)),
                    half_bias: half(&self.bias(formula)),
                });
                Named { name, kind }
            } else {
                let kind = NamedKind::Formula(Formula {
                    value: self.term(formula),
                    slopes: entry.gradient.iter().map(|slope| self.term(slope)).collect(),
                    rate: self.simple_term(&self.rate(formula)),
                    bias: self.simple_term(&self.bias(formula)),
                });
                Named { name: entry.name.clone(), kind }
            });
        }
        list
    }
}

/// A letter for roots with which no name of the scene begins.
pub(super) fn root_letter(scene: &Scene) -> &'static str {
    let is_free = |letter: &&str| !scene.names().any(|name| name.starts_with(letter));
    ["r", "s", "u", "w", "h", "z", "k"].into_iter().find(is_free).unwrap_or("root")
}

fn collect(view: AtomView, found: &mut HashSet<EngineSymbol>) {
    match view {
        AtomView::Num(_) => {}
        AtomView::Var(variable) => {
            found.insert(variable.get_symbol());
        }
        AtomView::Add(sum) => sum.iter().for_each(|term| collect(term, found)),
        AtomView::Mul(product) => product.iter().for_each(|factor| collect(factor, found)),
        AtomView::Fun(call) => call.iter().for_each(|argument| collect(argument, found)),
        AtomView::Pow(power) => {
            let (base, exponent) = power.get_base_exp();
            collect(base, found);
            collect(exponent, found);
        }
    }
}
