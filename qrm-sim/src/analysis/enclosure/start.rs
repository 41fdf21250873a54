//! The enclosed start of a motion.

use qrm_core::{Interval, Model, TapeSeries};

use super::linear::{Linear, applied};
use super::{Reason, Values};
use crate::run::assembled;
use crate::start::Start;

/// How much wider a box is made than the last one, and by how much at least, before it is tried.
const INFLATION: f64 = 0.1;
const SMALLEST: f64 = 1e-15;
/// Attempts to prove a box.
const ATTEMPTS: u32 = 12;

/// A box with exactly one start on the constraints for all given values: coordinates, then rates.
///
/// Values that the scene gives are those of its formulae. The others follow by the interval Newton method in the form
/// of R. Krawczyk (1969) from the start that a run has.
///
/// # Errors
/// The given values do not determine the others, or this was not proved.
pub(super) fn start(model: &Model, values: Values) -> Result<Vec<Interval>, Reason> {
    let mechanism = model.mechanism(values);
    let replace = |i: usize| super::replaced(model, values, i);
    let (tape, n) = (model.tape, model.tape.coordinates as usize);
    let Start { given, given_rates, .. } = Start::of(&*mechanism);
    let (q, _) = assembled(&*mechanism).map_err(Reason::NotAssembled)?;
    let mut formulae = TapeSeries::new(tape, tape.start, replace, [0, 0]);
    formulae.advance(0);
    let value = |i: usize| formulae.result(0, i)[0];
    let mut constraints = TapeSeries::new(tape, tape.loop_constraints, replace, [0, 0]);
    let m = tape.constraints as usize;
    let free = |given: &[bool]| -> Vec<usize> { (0..n).filter(|&i| !given[i]).collect() };
    let (free_q, free_rates) = (free(&given), free(&given_rates));
    if free_q.len() != m || free_rates.len() != m {
        return Err(Reason::NotGiven);
    }
    let mut box_of = |i: usize| if given[i] { value(i) } else { Interval::point(q[i]) };
    let mut state: Vec<Interval> = (0..n).map(&mut box_of).collect();
    let mut is_proved = m == 0;
    for _ in 0..ATTEMPTS {
        if is_proved {
            break;
        }
        let center: Vec<Interval> =
            (0..n).map(|i| if given[i] { state[i] } else { Interval::point(state[i].mid()) }).collect();
        let wider: Vec<Interval> = (0..n)
            .map(|i| {
                let more = INFLATION * state[i].width() + SMALLEST * state[i].magnitude().max(1.0);
                if given[i] { state[i] } else { state[i] + Interval::new(-more, more) }
            })
            .collect();
        let jacobian = evaluate(&mut constraints, &wider, &free_q, n, m).1;
        let Some(newton) = Linear::new(&jacobian, m) else { return Err(Reason::NotIsolated) };
        let residuals = evaluate(&mut constraints, &center, &free_q, n, m).0;
        let corrections = newton.solve(&residuals);
        is_proved = true;
        for (&i, correction) in free_q.iter().zip(corrections) {
            let next = center[i] - correction;
            is_proved &= next.is_inside(wider[i]);
            state[i] = next;
        }
    }
    if !is_proved {
        return Err(Reason::NotIsolated);
    }
    let mut rates: Vec<Interval> = (0..n).map(|i| if given_rates[i] { value(n + i) } else { Interval::ZERO }).collect();
    let columns = evaluate(&mut constraints, &state, &free_rates, n, m).1;
    let all: Vec<Interval> = (0..m * n).map(|k| constraints.result(0, m + k)[0]).collect();
    let right: Vec<Interval> = applied(&all, &rates)
        .into_iter()
        .enumerate()
        .map(|(k, rate)| -(rate + constraints.result(0, m + m * n + k)[0]))
        .collect();
    let solution = Linear::new(&columns, m).ok_or(Reason::NotIsolated)?.solve(&right);
    free_rates.iter().zip(solution).for_each(|(&i, rate)| rates[i] = rate);
    Ok([state, rates].concat())
}

/// The residuals of the constraints at the start, and their derivatives by some coordinates.
fn evaluate(
    constraints: &mut TapeSeries,
    q: &[Interval],
    by: &[usize],
    n: usize,
    m: usize,
) -> (Vec<Interval>, Vec<Interval>) {
    q.iter().enumerate().for_each(|(i, q)| constraints.set(0, 1 + i, &[*q]));
    constraints.advance(0);
    let residuals = (0..m).map(|k| constraints.result(0, k)[0]).collect();
    let columns = (0..m).flat_map(|k| by.iter().map(move |i| (k, *i)));
    (residuals, columns.map(|(k, i)| constraints.result(0, m + k * n + i)[0]).collect())
}
