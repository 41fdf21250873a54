//! A companion run beside a run, whose difference from it estimates the error.

use qrm_core::{Mechanism, RowLayout, RowRequest};

use crate::integrate::{BlockEnd, Integrator, MethodSettings};
use crate::solve::largest;
use crate::state::State;

/// The random walk of rounding errors in a step, in units in the last place of the largest coordinate (measured).
const ROUNDING_PER_STEP: f64 = 0.2;

/// The ratio of the difference of two runs, one at twice the step, to the error of the finer one: 15 for results of
/// order 4, 7 for order 3. Long steps do not show the full order; it is taken for 3.5, so that errors are estimated too
/// large rather than too small.
pub(crate) const RICHARDSON_FACTOR: f64 = 10.3;

/// A run at twice the step, or at a tenth of the tolerance, where the difference is the error of the first run itself.
#[derive(Debug)]
pub(crate) struct Companion {
    integrator: Integrator,
    layout: RowLayout,
    at: State,
    next: State,
    /// The number of the row that it stands at.
    row: u64,
    /// Rows under way.
    rows: Vec<f64>,
    /// Largest difference of a coordinate in any row, and largest coordinate.
    difference: f64,
    size: f64,
    failed: bool,
}

impl Companion {
    /// Begins with the run; `None` if that is not possible.
    pub(crate) fn new(
        mechanism: &dyn Mechanism,
        settings: &MethodSettings,
        first: &State,
        end_time: f64,
    ) -> Option<Self> {
        let settings = MethodSettings { tolerance: 0.1 * settings.tolerance, ..*settings };
        let layout = RowLayout { n: first.q.len(), m: first.multipliers.len() };
        Some(Self {
            integrator: Integrator::new(mechanism, settings, first, end_time).ok()?,
            layout,
            at: first.clone(),
            next: first.clone(),
            row: 0,
            rows: Vec::new(),
            difference: 0.0,
            size: 0.0,
            failed: false,
        })
    }

    /// Follows rows of the run, the first of which has the number `first`; a last one that is no whole step is left
    /// out.
    pub(crate) fn follow(&mut self, mechanism: &dyn Mechanism, request: &RowRequest, rows: &[f64], first: u64) {
        let width = self.layout.width();
        let count = (rows.len() / width) as u64;
        let is_whole = |row: u64| rows[(row - first) as usize * width] == request.time(row);
        let end = first + count - u64::from(count > 0 && !is_whole(first + count - 1));
        if self.failed || end <= self.row + 1 {
            return;
        }
        if self.integrator.is_fixed() {
            self.follow_steps(mechanism, request, rows, (first, end));
        } else {
            self.follow_rows(mechanism, rows, (first, end));
        }
    }

    /// Makes one step for two of the run.
    fn follow_steps(
        &mut self,
        mechanism: &dyn Mechanism,
        request: &RowRequest,
        rows: &[f64],
        (first, end): (u64, u64),
    ) {
        let width = self.layout.width();
        let steps = ((end - 1 - self.row) / 2) as usize;
        self.rows.resize((steps + 1) * width, 0.0);
        self.at.write(&mut self.rows);
        let twice = RowRequest { step: 2.0 * request.step, first: self.row / 2, watches_event: false, ..*request };
        let block = self.integrator.fill(mechanism, &twice, &mut self.rows);
        self.failed = matches!(block.reason, BlockEnd::Failed(_));
        for own in self.rows.chunks_exact(width).take(block.made + 1).skip(1) {
            self.row += 2;
            let row = &rows[(self.row - first) as usize * width..];
            compare((&mut self.difference, &mut self.size), &own[1..=self.layout.n], &row[1..=self.layout.n]);
        }
        self.at.read(&self.rows[block.made * width..]);
    }

    /// Moves to each row of the run.
    fn follow_rows(&mut self, mechanism: &dyn Mechanism, rows: &[f64], (first, end): (u64, u64)) {
        let width = self.layout.width();
        for number in first.max(self.row + 1)..end {
            let row = &rows[(number - first) as usize * width..];
            if self.integrator.advance(mechanism, &self.at, row[0], &mut self.next).is_err() {
                self.failed = true;
                return;
            }
            std::mem::swap(&mut self.at, &mut self.next);
            self.row = number;
            compare((&mut self.difference, &mut self.size), &self.at.q, &row[1..=self.layout.n]);
        }
    }

    /// The largest error of a coordinate in any row, after so many steps; `None` if the companion broke off or never
    /// met the run.
    pub(crate) fn error(&self, steps: u64) -> Option<f64> {
        let factor = if self.integrator.is_fixed() { RICHARDSON_FACTOR } else { 1.0 };
        (!self.failed && self.row > 0).then_some(estimated_error(self.difference / factor, self.size, steps))
    }

    /// Whether it broke off.
    pub(crate) fn failed(&self) -> bool {
        self.failed
    }
}

fn compare((difference, size): (&mut f64, &mut f64), own: &[f64], row: &[f64]) {
    for (own, q) in own.iter().zip(row) {
        *difference = difference.max((own - q).abs());
    }
    *size = size.max(largest(row).1);
}

/// The error of a run of so many steps with coordinates of this size, where the steps by themselves leave `of_steps`.
pub(crate) fn estimated_error(of_steps: f64, size: f64, steps: u64) -> f64 {
    // The rounding errors of both runs may agree; by themselves they accumulate to this.
    of_steps.max(ROUNDING_PER_STEP * f64::EPSILON * size * (steps as f64).sqrt())
}
