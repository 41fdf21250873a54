//! Splines as functions of the engine, one for each derivative.

use std::sync::Arc;

use symbolica::atom::{Atom, AtomCore, Symbol as EngineSymbol};
use symbolica::{function, symbol};

use super::algebra::Algebra;
use super::spline_names::{ORDERS, spline_name};
use qrm_scene::spline::Spline;

impl Algebra<'_> {
    /// A spline at an argument.
    pub(super) fn spline(&self, spline: &Arc<Spline>, argument: Atom) -> Atom {
        let place = self
            .splines
            .iter()
            .position(|own| own == spline)
            .unwrap_or_else(|| unreachable!("all splines of a scene are known"));
        function!(symbol!(spline_name(place, 0)), argument)
    }

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
}
