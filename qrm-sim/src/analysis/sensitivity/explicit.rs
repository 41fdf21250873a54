//! Steps by an explicit Runge-Kutta method on dual numbers.

use qrm_core::Scalar;

use super::equations::{DualEquations, DualState};
use super::number::{Inner, Number};
use super::slope::Slope;
use crate::integrate::{StepError, Tableau};

/// The state at `t` by one step of an explicit Runge-Kutta method.
///
/// # Errors
/// The step cannot be made.
pub(super) fn step<T: Inner>(
    tableau: &Tableau,
    equations: &mut DualEquations<T>,
    from: &DualState<T>,
    t: Number<T>,
) -> Result<DualState<T>, StepError> {
    let h = t - from.t;
    let mut slopes = vec![from.slope()];
    for stage in 1..tableau.stages {
        let at = from.place().plus(h, tableau.rows[stage].iter().copied(), &slopes);
        let node = from.t + Number::from_f64(tableau.nodes[stage]) * h;
        let [qdd, _] = equations.accelerations(node, &at.q, &at.qd)?;
        slopes.push(Slope { q: at.qd, qd: qdd });
    }
    let Slope { q, qd } = from.place().plus(h, tableau.weights.iter().copied(), &slopes);
    equations.projected(t, q, qd)
}
