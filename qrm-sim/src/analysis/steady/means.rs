//! Means of outputs over a motion.

use qrm_core::Mechanism;

use crate::integrate::{Integrator, MethodSettings, StepError, quintic};
use crate::quadrature::gauss_legendre;
use crate::solve::Solver;
use crate::state::State;

/// The number of nodes in a piece.
const NODES: usize = 3;
/// A piece is halved until that changes its integral by less than this part of the output's size over a part of a step.
const RESOLVED: f64 = 1e-12;
/// The most pieces that are halved, and the most halvings of a piece.
const MOST_PIECES: u32 = 20_000;
const MOST_HALVINGS: u32 = 40;

/// The number of parts of a step, between whose ends the motion is a polynomial of degree 5.
const PARTS: u32 = 8;

/// The means of all outputs over a motion from a state to a time, and their errors.
///
/// Pieces within steps are integrated by Gauss's formula of order 6. Steps end at corners and jumps of loads; pieces are
/// halved where outputs have others.
///
/// # Errors
/// The motion does not come to its end.
pub(super) fn output_means(
    mechanism: &dyn Mechanism,
    settings: MethodSettings,
    first: &State,
    end_time: f64,
) -> Result<Vec<(f64, f64)>, StepError> {
    let mut sums = Sums::new(mechanism);
    // The first pass finds the steps.
    let (mut from, mut to) = (first.clone(), first.clone());
    let mut integrator = Integrator::new(mechanism, settings, first, end_time)?;
    integrator.advance(mechanism, &from, end_time, &mut to)?;
    let steps = integrator.steps().to_vec();
    let mut integrator = Integrator::new(mechanism, settings, first, end_time)?;
    to.clone_from(first);
    for [begin, end] in steps {
        // A step begins behind the corner or jump at the end of the last one.
        for part in 0..=PARTS {
            let part = f64::from(part) / f64::from(PARTS);
            let t = if part < 1.0 { begin + (end - begin) * part } else { end }.min(end_time);
            if t > to.t {
                std::mem::swap(&mut from, &mut to);
                integrator.advance(mechanism, &from, t, &mut to)?;
                sums.add([&from, &to]);
            }
        }
    }
    Ok(sums.means(end_time - first.t))
}

/// The integrals so far.
struct Sums<'m> {
    mechanism: &'m dyn Mechanism,
    /// Completes states inside pieces.
    solver: Solver,
    nodes: [(f64, f64); NODES],
    sums: Vec<Sum>,
    /// The pieces that may still be halved: outputs that are rounding errors need ever more.
    left: u32,
}

/// The integral of an output so far, its error, and the largest size of the output.
#[derive(Clone, Copy, Debug, Default)]
struct Sum {
    integral: f64,
    error: f64,
    size: f64,
}

impl<'m> Sums<'m> {
    fn new(mechanism: &'m dyn Mechanism) -> Self {
        let count = mechanism.description().outputs.len();
        Self {
            mechanism,
            solver: Solver::new(mechanism),
            nodes: gauss_legendre::<NODES>(),
            sums: vec![Sum::default(); count],
            left: MOST_PIECES,
        }
    }

    fn means(&self, time: f64) -> Vec<(f64, f64)> {
        let mean = |sum: &Sum| (sum.integral / time, sum.error / time + f64::EPSILON * sum.size);
        self.sums.iter().map(mean).collect()
    }

    /// Adds the motion between two states of a step.
    fn add(&mut self, ends: [&State; 2]) {
        let (from, to) = (ends[0].t, ends[1].t);
        // The pieces that wait, each with its integral and the number of its halvings.
        let mut waiting = vec![(from, to, self.piece(ends, from, to), 0)];
        while let Some((a, b, whole, halvings)) = waiting.pop() {
            let middle = 0.5 * (a + b);
            let halves = [self.piece(ends, a, middle), self.piece(ends, middle, b)];
            let change = |i: usize| (halves[0][i] + halves[1][i] - whole[i]).abs();
            // Halving does not help what is not a number.
            let is_resolved = |i: usize| !(change(i) > RESOLVED * self.sums[i].size * (to - from));
            if halvings < MOST_HALVINGS && self.left > 0 && !(0..whole.len()).all(is_resolved) {
                self.left -= 1;
                let [first, second] = halves;
                waiting.extend([(middle, b, second, halvings + 1), (a, middle, first, halvings + 1)]);
                continue;
            }
            let errors: Vec<f64> =
                (0..whole.len()).map(|i| if is_resolved(i) { change(i) / 16.0 } else { change(i) }).collect();
            for (i, sum) in self.sums.iter_mut().enumerate() {
                // Halves have a 64th of the error, where the output is smooth.
                sum.error += errors[i];
                sum.integral += halves[0][i] + halves[1][i];
            }
        }
    }

    /// The integrals of all outputs over a piece between two states.
    fn piece(&mut self, [from, to]: [&State; 2], a: f64, b: f64) -> Vec<f64> {
        let mut integrals = vec![0.0; self.sums.len()];
        let mut outputs = integrals.clone();
        for (x, weight) in self.nodes {
            let mut at = quintic(from, to, a + x * (b - a));
            match self.solver.complete(self.mechanism, &mut at) {
                Ok(()) => {
                    let State { t, q, qd, qdd, multipliers, .. } = &at;
                    self.mechanism.outputs(*t, q, qd, qdd, multipliers, &mut outputs);
                }
                // The mean is not known.
                Err(_) => outputs.fill(f64::NAN),
            }
            for ((integral, output), sum) in integrals.iter_mut().zip(&outputs).zip(&mut self.sums) {
                *integral += weight * (b - a) * output;
                sum.size = sum.size.max(output.abs());
            }
        }
        integrals
    }
}
