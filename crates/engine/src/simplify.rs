//! Equal forms of an expression, and the choice of the cheapest.

use symbolica::atom::{Atom, AtomCore, AtomView, Symbol as EngineSymbol};
use symbolica::{function, symbol};

use super::algebra::Algebra;
use qrm_codegen::term::Symbol;

/// The largest power of a sine or cosine that is replaced.
const LARGEST_POWER: i64 = 8;

impl Algebra<'_> {
    /// The cheapest of several equal forms: unchanged, expanded, and with sin^2 + cos^2 = 1 used in either direction.
    pub(super) fn simplify(&self, atom: &Atom) -> Atom {
        if matches!(atom.as_view(), AtomView::Num(_) | AtomView::Var(_)) {
            return atom.clone();
        }
        let atom = &atom.expand_num();
        let expanded = atom.expand();
        let cost = |form: &Atom| self.cost(form.as_view());
        let forms = [
            without_squares_of(EngineSymbol::COS, EngineSymbol::SIN, &expanded),
            without_squares_of(EngineSymbol::SIN, EngineSymbol::COS, &expanded),
            Some(expanded),
            Some(atom.clone()),
        ];
        forms.into_iter().flatten().min_by_key(cost).unwrap_or_else(|| atom.clone())
    }

    /// Simplifies radicands and denominators, so that equal ones are recognized.
    pub(super) fn simplify_inside(&self, view: AtomView) -> Atom {
        match view {
            AtomView::Add(sum) => sum.iter().fold(Atom::num(0), |sum, term| sum + self.simplify_inside(term)),
            AtomView::Mul(product) => product.iter().fold(Atom::num(1), |product, f| product * self.simplify_inside(f)),
            AtomView::Pow(power) => {
                let (base, exponent) = power.get_base_exp();
                self.power(&self.simplify(&self.simplify_inside(base)), &exponent.to_owned())
            }
            _ => view.to_owned(),
        }
    }

    /// The number of operations of an expression as written; a sine or cosine counts as ten.
    fn cost(&self, view: AtomView) -> usize {
        let all = |items: &mut dyn Iterator<Item = AtomView<'_>>| {
            let (count, cost) = items.fold((0, 0), |(count, cost), item| (count + 1, cost + self.cost(item)));
            cost + count - 1
        };
        match view {
            AtomView::Num(_) => 0,
            AtomView::Var(variable) => match self.scene_symbol(variable.get_symbol()) {
                Some(Symbol::Switch(k)) => 10 + self.cost(self.switch_argument(k).as_view()),
                None => 10,
                Some(_) => 0,
            },
            AtomView::Add(sum) => all(&mut sum.iter()),
            AtomView::Mul(product) => all(&mut product.iter()),
            AtomView::Pow(power) => {
                let (base, exponent) = power.get_base_exp();
                match (base, exponent) {
                    (AtomView::Var(base), exponent) if base.get_symbol() == EngineSymbol::E => 10 + self.cost(exponent),
                    (base, exponent) => self.cost(base) + if exponent.to_owned().is_integer() { 1 } else { 5 },
                }
            }
            AtomView::Fun(call) => 10 + call.iter().map(|argument| self.cost(argument)).sum::<usize>(),
        }
    }
}

/// The largest power of a function in an expression, up to the largest that is replaced; 1 if there is no power.
fn largest_power(view: AtomView, f: EngineSymbol) -> i64 {
    let largest =
        |items: &mut dyn Iterator<Item = AtomView<'_>>| items.map(|item| largest_power(item, f)).max().unwrap_or(1);
    match view {
        AtomView::Num(_) | AtomView::Var(_) => 1,
        AtomView::Add(sum) => largest(&mut sum.iter()),
        AtomView::Mul(product) => largest(&mut product.iter()),
        AtomView::Fun(call) => largest(&mut call.iter()),
        AtomView::Pow(power) => {
            let (base, exponent) = power.get_base_exp();
            let own = match base {
                AtomView::Fun(call) if call.get_symbol() == f => i64::try_from(exponent).unwrap_or(1),
                _ => 1,
            };
            let own = if own > LARGEST_POWER { 1 } else { own };
            largest(&mut [base, exponent].into_iter()).max(own)
        }
    }
}

/// Replaces even powers: f(x)^2 = 1 - g(x)^2 where f and g are sine and cosine. `None` if there are none.
fn without_squares_of(f: EngineSymbol, g: EngineSymbol, expanded: &Atom) -> Option<Atom> {
    let largest = largest_power(expanded.as_view(), f);
    if largest < 2 {
        return None;
    }
    let x = Atom::var(symbol!("x_"));
    let (f, g) = (function!(f, &x), function!(g, &x));
    let mut atom = expanded.clone();
    for exponent in (2..=largest).rev() {
        let square = Atom::num(1) - g.pow(Atom::num(2));
        let replacement = f.pow(Atom::num(exponent - 2)) * square;
        atom = atom.replace(f.pow(Atom::num(exponent)).to_pattern()).with(replacement.to_pattern());
    }
    Some(atom.expand())
}
