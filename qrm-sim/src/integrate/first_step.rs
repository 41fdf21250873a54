//! The length of the first step.

use qrm_core::Mechanism;

use super::step_error::StepError;
use super::step_formula::{Evaluator, Task};
use crate::state::State;

/// The largest number of guesses of the first step.
const FIRST_GUESSES: usize = 6;
/// The ratio of a guess to the one before.
const SHORTER_GUESS: f64 = 0.01;

/// The length of the first step, from the sizes of state, rates and their change (Hairer, Norsett, Wanner I, II.4).
///
/// # Errors
/// The accelerations near the start are not determined.
pub(super) fn first_step(
    mechanism: &dyn Mechanism,
    (task, order): (&Task, i32),
    first: &State,
    evaluator: &mut Evaluator,
) -> Result<f64, StepError> {
    let n = first.q.len();
    let at_first = (&first.q[..], &first.qd[..]);
    let scales: Vec<[f64; 2]> = (0..n).map(|i| task.error_scales(mechanism, i, first, at_first)).collect();
    let norm = |of_q: &[f64], of_qd: &[f64]| {
        let squares =
            scales.iter().zip(of_q.iter().zip(of_qd)).map(|([q, qd], (x, v))| (x / q).powi(2) + (v / qd).powi(2));
        (squares.sum::<f64>() / (2.0 * n.max(1) as f64)).sqrt()
    };
    let (size, speed) = (norm(&first.q, &first.qd), norm(&first.qd, &first.qdd));
    let guess = if size < 1e-5 || speed < 1e-5 { 1e-6 } else { 0.01 * size / speed };
    let mut guess = guess.min(task.end_time - first.t);
    let mut later = first.clone();
    for left in (0..FIRST_GUESSES).rev() {
        let along = |x: &[f64], v: &[f64]| -> Vec<f64> { x.iter().zip(v).map(|(x, v)| x + guess * v).collect() };
        (later.t, later.q, later.qd) = (first.t + guess, along(&first.q, &first.qd), along(&first.qd, &first.qdd));
        *evaluator.evaluations += 1;
        match evaluator.solver.complete(mechanism, &mut later) {
            Ok(()) => break,
            Err(reason) if left == 0 => return Err(reason),
            // Forces may have no solution there.
            Err(_) => guess *= SHORTER_GUESS,
        }
    }
    let change = |a: &[f64], b: &[f64]| -> Vec<f64> { a.iter().zip(b).map(|(a, b)| (a - b) / guess).collect() };
    let bend = norm(&change(&later.qd, &first.qd), &change(&later.qdd, &first.qdd));
    let largest = speed.max(bend);
    let second =
        if largest <= 1e-15 { (guess * 1e-3).max(1e-6) } else { (0.01 / largest).powf(1.0 / f64::from(order)) };
    Ok((100.0 * guess).min(second).min(task.end_time - first.t))
}
