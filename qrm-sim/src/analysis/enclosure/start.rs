//! The enclosed start of a motion.

use qrm_core::{Interval, Model, TapeSeries};

use super::linear::IntervalLinearSolver;
use super::manifold::{Linearized, Manifold};
use super::matrix::{IntervalMatrix, negative};
use super::{NoSeries, Reason, Values, replaced};
use crate::position::{Start, assemble};

/// The relative and the absolute amount by which a box is widened before each attempt.
const INFLATION: f64 = 0.1;
const SMALLEST: f64 = 1e-15;
/// The number of attempts to prove a box.
const ATTEMPTS: u32 = 12;

/// Finds a box with exactly one start on the constraints for all given values: coordinates, then rates.
///
/// Given values are those of the scene's formulae. The others follow by the interval Newton method in the form of R.
/// Krawczyk (1969), starting from the start of a run.
///
/// # Errors
/// The given values do not determine the others, or the proof failed.
pub(super) fn start(model: &Model, values: Values, manifold: &mut Manifold) -> Result<Vec<Interval>, Reason> {
    let mechanism = model.mechanism(values);
    let Start { given, given_rates, .. } = Start::new(&*mechanism);
    let (q, _) = assemble(&*mechanism, Start::new(&*mechanism)).map_err(Reason::NotAssembled)?;
    let [n, m] = manifold.sizes();
    let free = |given: &[bool]| -> Vec<usize> { (0..n).filter(|&i| !given[i]).collect() };
    let (free_q, free_rates) = (free(&given), free(&given_rates));
    if free_q.len() != m || free_rates.len() != m {
        return Err(Reason::NotGiven);
    }
    let mut formulae = TapeSeries::new(model.tape(), &model.tape().start, |i| replaced(model, values, i), [0, 0]);
    formulae.advance(0);
    let value = |i: usize| formulae.result(0, i)[0];
    let given_q = (0..n).map(|i| if given[i] { value(i) } else { Interval::point(q[i]) });
    let given_rates = (0..n).map(|i| if given_rates[i] { value(n + i) } else { Interval::ZERO });
    let state: Vec<Interval> = given_q.chain(given_rates).collect();
    let Some(mut state) = position(manifold, state, &free_q) else {
        let obstacle = manifold.obstacle().map(NoSeries::Operation);
        return Err(obstacle.map_or(Reason::NotIsolated, Reason::NoSeries));
    };
    let Linearized { residuals, jacobian } = manifold.linearized(Interval::ZERO, &state);
    let matrix = IntervalMatrix::from_fn(m, m, |k, j| jacobian.at(m + k, n + free_rates[j]));
    let rates = IntervalLinearSolver::new(&matrix).ok_or(Reason::NotIsolated)?.solve(&negative(&residuals[m..]));
    free_rates.iter().zip(rates).for_each(|(&i, rate)| state[n + i] = rate);
    Ok(state)
}

/// Replaces the free coordinates of a state by a box that contains exactly one position for all given ones.
fn position(manifold: &mut Manifold, mut state: Vec<Interval>, free: &[usize]) -> Option<Vec<Interval>> {
    for _ in 0..ATTEMPTS {
        let (mut center, mut wider) = (state.clone(), state.clone());
        for &i in free {
            let more = INFLATION * state[i].width() + SMALLEST * state[i].magnitude().max(1.0);
            center[i] = Interval::point(state[i].mid());
            wider[i] = state[i] + Interval::new(-more, more);
        }
        let jacobian = manifold.linearized(Interval::ZERO, &wider).jacobian;
        let matrix = IntervalMatrix::from_fn(free.len(), free.len(), |k, j| jacobian.at(k, free[j]));
        let residuals = manifold.linearized(Interval::ZERO, &center).residuals;
        let corrections = IntervalLinearSolver::new(&matrix)?.solve(&residuals[..free.len()]);
        free.iter().zip(corrections).for_each(|(&i, correction)| state[i] = center[i] - correction);
        if free.iter().all(|&i| state[i].is_inside(wider[i])) {
            return Some(state);
        }
    }
    None
}
