//! The algorithm of the assignment's script, for comparison: the motion is that of RK4 with Euclidean projection, but what it
//! stores beside the state belongs to other moments.
//!
//! Accelerations and multipliers are averages over the stages of the step that ended, and so half a step old. What is made of
//! them and of the state afterwards is a step late or differenced; that part is done where outputs are written.

use qrm_core::Mechanism;

use crate::linear::{Vector, along, largest};
use crate::motion::{Breakdown, Moment};
use crate::projection::NotConverged;
use crate::solve::{Care, Corrector, accelerations};

/// The script's tolerance for residuals, and its patience.
const CLOSED: f64 = 1e-12;
const ITERATIONS: u32 = 10;

/// The row after a step that ends at `t_next`.
///
/// # Errors
/// The step could not be made.
#[inline(never)]
pub fn advance<X: Mechanism<N, M>, const N: usize, const M: usize>(
    mechanism: &X,
    from: &Moment<N, M>,
    t_next: f64,
    care: &mut Care,
) -> Result<Moment<N, M>, Breakdown> {
    let h = t_next - from.t;
    let mut rates = [from.qd; 4];
    let mut stages = [([0.0; N], [0.0; M]); 4];
    for (stage, part) in [0.0, 0.5, 0.5, 1.0].into_iter().enumerate() {
        let (rate, acceleration) = match stage {
            0 => (from.qd, [0.0; N]),
            _ => (rates[stage - 1], stages[stage - 1].0),
        };
        let (q, qd) = (along(&from.q, part * h, &rate), along(&from.qd, part * h, &acceleration));
        let solution = accelerations(&mechanism.dynamics(from.t + part * h, &q, &qd), care)?;
        rates[stage] = qd;
        stages[stage] = (solution.qdd, solution.multipliers);
    }
    let qdd: Vector<N> = std::array::from_fn(|i| mean(stages.map(|stage| stage.0[i])));
    let multipliers: Vector<M> = std::array::from_fn(|i| mean(stages.map(|stage| stage.1[i])));
    let rate: Vector<N> = std::array::from_fn(|i| mean(rates.map(|rate| rate[i])));
    let (mut q, mut qd) = (along(&from.q, h, &rate), along(&from.qd, h, &qdd));
    let corrections = project(mechanism, t_next, &mut q, &mut qd, care)?;
    let is_finite = q.iter().chain(&qd).chain(&qdd).chain(&multipliers).all(|value| value.is_finite());
    if is_finite { Ok(Moment { t: t_next, q, qd, qdd, multipliers, corrections }) } else { Err(Breakdown::NotFinite) }
}

fn mean(k: [f64; 4]) -> f64 {
    (k[0] + 2.0 * (k[1] + k[2]) + k[3]) / 6.0
}

/// Gauss-Newton correction until the tolerance is met and no further, then of the rates once.
fn project<X: Mechanism<N, M>, const N: usize, const M: usize>(
    mechanism: &X,
    t: f64,
    q: &mut Vector<N>,
    qd: &mut Vector<N>,
    care: &mut Care,
) -> Result<u32, Breakdown> {
    let start = *q;
    let mut open = 0.0;
    for iterations in 0..=ITERATIONS {
        let closure = mechanism.closure(t, q);
        let corrector = Corrector::new(&closure.constraint_jacobian, None);
        let (constraint, residual) = largest(&closure.constraints);
        if iterations == 0 {
            open = residual;
        }
        if residual <= CLOSED {
            care.note_correction(open, &start, q);
            corrector.correct(qd, &closure.drift(qd), care);
            return Ok(iterations);
        }
        if iterations == ITERATIONS || !residual.is_finite() {
            return Err(NotConverged { constraint, residual, iterations }.into());
        }
        corrector.correct(q, &closure.constraints, care);
    }
    Ok(ITERATIONS)
}
