//! Functions and powers of expressions, with names for roots and signs.

use num_bigint::BigInt;
use num_rational::BigRational;
use symbolica::atom::{Atom, AtomCore};
use symbolica::{function, symbol};

use super::algebra::Algebra;
use super::number::rational;
use super::switch::Switch;
use qrm_codegen::term::{Symbol, Term};
use qrm_scene::function::Function;

impl Algebra<'_> {
    pub(super) fn call(&self, f: Function, arguments: &[Atom]) -> Atom {
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
            Function::Max => self.selected(x, &arguments[1], [Switch::Above, Switch::Below]),
            Function::Min => self.selected(x, &arguments[1], [Switch::Below, Switch::Above]),
            // The resolver has rejected all functions without a derivative.
            _ => function!(symbol!(f.name()), x),
        }
    }

    /// A power with a fixed exponent. The power of a fraction is split into those of its parts, which keeps the engine
    /// from combining them.
    pub(super) fn power(&self, base: &Atom, exponent: &Atom) -> Atom {
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

    /// The larger or smaller of two values: the sum of both, each times a switch of their difference. The other value
    /// is multiplied by zero; in `(a + b + |a - b|)/2` it would cancel, and leave its rounding errors.
    fn selected(&self, a: &Atom, b: &Atom, [first, second]: [Switch; 2]) -> Atom {
        let difference = self.simplify(&(a - b));
        a * self.switch(first, &difference) + b * self.switch(second, &difference)
    }

    /// The named sign of an expression.
    pub(super) fn sign(&self, x: &Atom) -> Atom {
        self.switch(Switch::Sign, x)
    }

    /// A named switch. Its derivative is zero wherever it exists.
    pub(super) fn switch(&self, switch: Switch, x: &Atom) -> Atom {
        let mut known = self.switches.borrow_mut();
        let place = known.iter().position(|(own, other)| *own == switch && other == x).unwrap_or_else(|| {
            known.push((switch, x.clone()));
            known.len() - 1
        });
        self.symbol(Symbol::Switch(place))
    }

    /// A root; named if roots have names and the radicand varies.
    fn root(&self, radicand: &Atom) -> Atom {
        if self.names_roots && self.coordinates(radicand).is_some_and(|count| count > 0) {
            return self.name(radicand, true, "");
        }
        self.power(radicand, &(Atom::num(1) / Atom::num(2)))
    }

    /// The argument of a switch.
    pub(super) fn switch_argument(&self, k: usize) -> Atom {
        self.switches.borrow()[k].1.clone()
    }
}
