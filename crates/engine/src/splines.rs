//! Splines as functions of the engine, one for each derivative.

use std::sync::Arc;

use symbolica::atom::Atom;
use symbolica::{function, symbol};

use super::algebra::Algebra;
use super::spline_names::spline_name;
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
}
