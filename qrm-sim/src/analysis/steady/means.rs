//! Means of outputs over a motion.

use std::io;

use qrm_core::Mechanism;

use crate::integrate::quintic;
use crate::quadrature::gauss_legendre;
use crate::run::{Observer, Row};
use crate::solve::Solver;
use crate::state::State;

/// The number of nodes in a piece.
const NODES: usize = 3;
/// A piece is halved until that changes its integral by less than this part of the output's size over a row.
const RESOLVED: f64 = 1e-12;
/// The most pieces between two rows, and the most halvings of a piece.
const MOST_PIECES: u32 = 2000;
const MOST_HALVINGS: u32 = 40;

/// The means of all outputs over the time of a run, which observes its rows.
///
/// Pieces between rows are integrated by Gauss's formula of order 6. They are halved where outputs have corners or
/// jumps.
pub struct OutputMeans<'m> {
    mechanism: &'m dyn Mechanism,
    /// Completes states between rows.
    solver: Solver,
    nodes: [(f64, f64); NODES],
    begin: f64,
    /// The last row.
    last: Option<State>,
    sums: Vec<Sum>,
}

/// The integral of an output so far, its error, and the largest size of the output.
#[derive(Clone, Copy, Debug, Default)]
struct Sum {
    integral: f64,
    error: f64,
    size: f64,
}

impl<'m> OutputMeans<'m> {
    /// Begins before the first row.
    pub fn new(mechanism: &'m dyn Mechanism) -> Self {
        let count = mechanism.description().outputs.len();
        Self {
            mechanism,
            solver: Solver::new(mechanism),
            nodes: gauss_legendre::<NODES>(),
            begin: 0.0,
            last: None,
            sums: vec![Sum::default(); count],
        }
    }

    /// The mean of an output, and the error of its integral over the time.
    pub fn mean(&self, output: usize) -> (f64, f64) {
        let Sum { integral, error, size } = self.sums[output];
        let time = self.last.as_ref().map_or(0.0, |last| last.t) - self.begin;
        (integral / time, error / time + f64::EPSILON * size)
    }

    /// Adds the motion from one row to the next.
    fn add(&mut self, ends: [&State; 2]) {
        let (from, to) = (ends[0].t, ends[1].t);
        // The pieces that wait, each with its integral and the number of its halvings.
        let mut waiting = vec![(from, to, self.piece(ends, from, to), 0)];
        let mut left = MOST_PIECES;
        while let Some((a, b, whole, halvings)) = waiting.pop() {
            let middle = 0.5 * (a + b);
            let halves = [self.piece(ends, a, middle), self.piece(ends, middle, b)];
            let change = |i: usize| (halves[0][i] + halves[1][i] - whole[i]).abs();
            let is_resolved = |i: usize| change(i) <= RESOLVED * self.sums[i].size * (to - from);
            if halvings < MOST_HALVINGS && left > 0 && !(0..whole.len()).all(is_resolved) {
                left -= 1;
                let [first, second] = halves;
                waiting.extend([(middle, b, second, halvings + 1), (a, middle, first, halvings + 1)]);
                continue;
            }
            for (i, sum) in self.sums.iter_mut().enumerate() {
                sum.error += change(i);
                sum.integral += halves[0][i] + halves[1][i];
            }
        }
    }

    /// The integrals of all outputs over a piece between two rows.
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

impl Observer for OutputMeans<'_> {
    fn row(&mut self, row: &Row) -> io::Result<()> {
        let [q, qd, qdd, multipliers] = [row.q, row.qd, row.qdd, row.multipliers].map(<[f64]>::to_vec);
        let here = State { t: row.t, q, qd, qdd, multipliers, corrections: 0 };
        match self.last.take() {
            None => self.begin = row.t,
            Some(last) => self.add([&last, &here]),
        }
        self.last = Some(here);
        Ok(())
    }
}
