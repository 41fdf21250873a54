//! The largest value of an event inside a step.

use qrm_core::Mechanism;

use super::EventFunction;
use crate::bounds::PeakSearch;
use crate::maximum::{corner_near, vertex_beside};
use crate::state::State;

/// The largest number of bounds for one step.
const MOST_BOUNDS: u32 = 2000;
/// The distance of the values for the second derivative, in parts of the step.
const APART: f64 = 1e-3;

/// The largest value of an event inside a step.
pub(crate) struct Largest {
    pub(crate) t: f64,
    pub(crate) value: f64,
    /// Half of the second derivative by time; zero if it is not known.
    pub(crate) half_curvature: f64,
}

impl EventFunction<'_> {
    /// The largest value of the event inside a step, not at its ends; `at` computes states of the motion inside.
    pub(crate) fn largest_inside(
        &self,
        mechanism: &dyn Mechanism,
        ends: [&State; 2],
        at: &mut dyn FnMut(f64) -> Option<State>,
    ) -> Option<Largest> {
        let mut value = |at: &State| self.value(mechanism, at).unwrap_or(f64::NAN);
        let [at_begin, at_end] = ends.map(&mut value);
        let mut solver = self.solver.as_ref().map(|solver| solver.borrow_mut());
        let (largest, t) = self.with_bounds(mechanism, |bounds| {
            let mut search = PeakSearch {
                mechanism,
                bounds: &mut bounds.function,
                solver: solver.as_deref_mut(),
                sign: 1.0,
                ends,
                best: (at_begin.max(at_end), f64::NAN),
                tie: 0.0,
                open: 0.0,
                left: &mut { MOST_BOUNDS },
                at,
                value: &mut value,
            };
            // Where the bounds do not tell, the best value is that of the parts that they told of.
            let _ = search.search();
            search.best
        })?;
        let [begin, end] = ends.map(|end| end.t);
        // Where no value inside is larger than those at the ends, its time is not a number.
        if !(begin < t && t < end && largest.is_finite()) {
            return None;
        }
        let apart = (APART * (end - begin)).min(t - begin).min(end - t);
        let mut value_at = |t: f64| at(t).map(|at| value(&at)).filter(|value| value.is_finite());
        // The bounds are those of polynomials, which differ from the motion.
        let beside = [t - apart, t + apart];
        let corner = corner_near((t, largest), beside, &mut value_at)?;
        let (t, largest) = vertex_beside(corner, beside, &mut value_at);
        let curvature = |(before, after): (f64, f64)| (0.5 * (before + after) - largest) / (apart * apart);
        let half_curvature = value_at(t - apart).zip(value_at(t + apart)).map_or(0.0, curvature);
        Some(Largest { t, value: largest, half_curvature })
    }
}
