//! A companion run beside a run, whose difference from it estimates the error.

use std::f64::consts::TAU;

use qrm_core::{Mechanism, RowLayout, RowRequest};

use crate::integrate::{BlockEnd, COMPANION_STEP_RATIO, Integrator, MethodSettings, StepError};
use crate::solve::largest;
use crate::state::State;

/// The random walk of rounding errors in a step, in units in the last place of the largest coordinate (measured).
const ROUNDING_PER_STEP: f64 = 0.2;

/// So many steps of a run take as long as so many of its companion. Steps that are no multiples of each other see
/// different moments of a load, and come differently near to a singular position.
const COMPANION_STEPS: [u64; 2] = [3, 2];

/// The ratio of the difference of the two to the error of the finer one. It is `(3/2)^p - 1`, 4.06 for order 4, where
/// errors follow an order; long steps show less.
const RICHARDSON_FACTOR: f64 = 2.0;
/// The ratio where steps are so long that errors follow no order: ratios from 0.43 to 3.75 were measured, and estimates
/// are to hold within a factor of 3 both ways.
const RATIO_OF_LONG_STEPS: f64 = 1.26;
/// Steps are long where the difference is a larger part than this of the largest coordinate, or of a turn.
const LONG: f64 = 1e-5;
/// The ratio of that difference to the error where loads have corners. The errors of both depend on where their steps
/// meet one, and may agree by chance.
const RATIO_AT_CORNERS: f64 = 1.0 / 3.0;

/// Below this, a companion has the fraction of the tolerance that belongs to order 4: smaller ones may be out of reach
/// near singular positions.
const TIGHT: f64 = 1e-8;
/// Tolerances below this ask for more than double precision has.
const SMALLEST_TOLERANCE: f64 = 1e-15;

/// A companion run beside a run: with longer steps; or, where a tolerance chooses them, with shorter ones, where the
/// difference is the error of the first run itself.
#[derive(Clone, Debug)]
pub(crate) struct Companion {
    integrator: Integrator,
    layout: RowLayout,
    at: State,
    next: State,
    /// The number of the row that it stands at.
    row: u64,
    /// Rows under way.
    rows: Vec<f64>,
    /// Largest difference of each coordinate in any row, and largest coordinate.
    differences: Vec<f64>,
    /// The differences of parts of the motion that are over, added up.
    before: Vec<f64>,
    /// The smallest and the largest value of each coordinate.
    ranges: Vec<[f64; 2]>,
    /// Whether it was compared with the run at all.
    has_met: bool,
    failed: bool,
    /// Whether loads have corners.
    has_corners: bool,
}

impl Companion {
    /// Begins with the run; `None` if that is not possible.
    pub(crate) fn new(
        mechanism: &dyn Mechanism,
        settings: &MethodSettings,
        first: &State,
        end_time: f64,
    ) -> Option<Self> {
        let finer = |order: u32| settings.tolerance * COMPANION_STEP_RATIO.powi(order as i32);
        let tolerance = finer(settings.method.order).max(finer(4).min(TIGHT)).max(SMALLEST_TOLERANCE);
        let settings = MethodSettings { tolerance, ..*settings };
        let layout = RowLayout { n: first.q.len(), m: first.multipliers.len() };
        Some(Self {
            integrator: Integrator::new(mechanism, settings, first, end_time).ok()?,
            layout,
            at: first.clone(),
            next: first.clone(),
            row: 0,
            rows: Vec::new(),
            differences: vec![0.0; layout.n],
            before: vec![0.0; layout.n],
            ranges: first.q.iter().map(|q| [*q; 2]).collect(),
            has_met: false,
            failed: false,
            has_corners: mechanism.description().has_corners,
        })
    }

    /// Comes to the state `end` of the run, at which the parameters change, and begins with the run again at `first`.
    ///
    /// Differences add up, but are not carried on: whoever changes parameters by what the run does, as a controller
    /// does, corrects the errors of the run, and would not correct those of another motion.
    pub(crate) fn change(&mut self, [old, new]: [&dyn Mechanism; 2], [end, first]: [&State; 2]) {
        if !self.failed {
            self.failed = self.try_change([old, new], [end, first]).is_err();
        }
    }

    fn try_change(&mut self, [old, new]: [&dyn Mechanism; 2], [end, first]: [&State; 2]) -> Result<(), StepError> {
        // Two steps where the run may have made one: the same step would show no difference.
        let middle = 0.5 * (self.at.t + end.t);
        for t in [middle, end.t] {
            if t > self.at.t {
                self.integrator.advance(old, &self.at, t, &mut self.next)?;
                std::mem::swap(&mut self.at, &mut self.next);
            }
        }
        self.has_met = true;
        compare((&mut self.differences, &mut self.ranges), &self.at.q, &end.q);
        for (before, difference) in self.before.iter_mut().zip(&mut self.differences) {
            *before += std::mem::take(difference);
        }
        self.at.clone_from(first);
        self.integrator = Integrator::new(new, self.integrator.settings, first, f64::INFINITY)?;
        self.row = 0;
        Ok(())
    }

    /// Follows rows of the run, the last of its integrator, of which the first has the number `first`; a last one that
    /// is no whole step is left out.
    pub(crate) fn follow(
        &mut self,
        mechanism: &dyn Mechanism,
        run: &Integrator,
        request: &RowRequest,
        rows: &[f64],
        first: u64,
    ) {
        let width = self.layout.width();
        let count = (rows.len() / width) as u64;
        let is_whole = |row: u64| rows[(row - first) as usize * width] == request.time(row);
        let end = first + count - u64::from(count > 0 && !is_whole(first + count - 1));
        if self.failed {
            return;
        }
        self.integrator.limit_steps_by(run.steps());
        if end <= self.row + 1 {
            return;
        }
        if self.integrator.is_fixed() {
            self.follow_steps(mechanism, request, rows, (first, end));
        } else {
            self.follow_rows(mechanism, rows, (first, end));
        }
    }

    /// Makes longer steps, up to the last row of the run that one of them ends at.
    fn follow_steps(
        &mut self,
        mechanism: &dyn Mechanism,
        request: &RowRequest,
        rows: &[f64],
        (first, end): (u64, u64),
    ) {
        let (width, [of_run, own]) = (self.layout.width(), COMPANION_STEPS);
        let steps = (end - 1 - self.row) / of_run * own;
        let length = (steps as usize + 1) * width;
        if self.rows.len() < length {
            // Later blocks may have some steps more.
            self.rows.resize(length + own as usize * width, 0.0);
        }
        self.at.write(&mut self.rows);
        let step = of_run as f64 / own as f64 * request.step;
        let longer = RowRequest { step, first: self.row / of_run * own, watches_event: false, ..*request };
        let block = self.integrator.fill(mechanism, &longer, &mut self.rows[..length]);
        self.failed = matches!(block.reason, BlockEnd::Failed(_));
        let made = &self.rows[..(block.made + 1) * width];
        for state in made.chunks_exact(width).step_by(own as usize).skip(1) {
            self.row += of_run;
            self.has_met = true;
            let row = &rows[(self.row - first) as usize * width..];
            compare((&mut self.differences, &mut self.ranges), &state[1..=self.layout.n], &row[1..=self.layout.n]);
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
            self.has_met = true;
            compare((&mut self.differences, &mut self.ranges), &self.at.q, &row[1..=self.layout.n]);
        }
    }

    /// The largest error of each coordinate in any row, after so many steps; `None` if the companion broke off or never
    /// met the run.
    pub(crate) fn errors(&self, steps: u64) -> Option<Vec<f64>> {
        if self.failed || !self.has_met {
            return None;
        }
        let differences: Vec<f64> = self.before.iter().zip(&self.differences).map(|(a, b)| a + b).collect();
        let size = largest(self.ranges.as_flattened()).1;
        if self.integrator.is_fixed() {
            return Some(estimated_errors(&differences, size, steps, self.has_corners));
        }
        // Both may be off by what the companion tolerates.
        let tolerated = |[low, high]: &[f64; 2]| self.integrator.settings.tolerance * (high - low).min(1.0);
        let error =
            |(difference, range): (&f64, &[f64; 2])| difference.max(tolerated(range)).max(rounding(size, steps));
        Some(differences.iter().zip(&self.ranges).map(error).collect())
    }

    /// Whether it broke off.
    pub(crate) fn failed(&self) -> bool {
        self.failed
    }
}

fn compare((differences, ranges): (&mut [f64], &mut [[f64; 2]]), own: &[f64], row: &[f64]) {
    for i in 0..row.len() {
        differences[i] = differences[i].max((own[i] - row[i]).abs());
        ranges[i] = [ranges[i][0].min(row[i]), ranges[i][1].max(row[i])];
    }
}

/// The errors of a run of so many fixed steps, with coordinates up to this size, by the differences from its companion.
fn estimated_errors(differences: &[f64], size: f64, steps: u64, has_corners: bool) -> Vec<f64> {
    // The rounding errors of both runs may agree; by themselves they accumulate to this.
    let rounding = rounding(size, steps);
    let ratio = if has_corners {
        RATIO_AT_CORNERS
    } else if largest(differences).1 > LONG * size.min(TAU) {
        RATIO_OF_LONG_STEPS
    } else {
        RICHARDSON_FACTOR
    };
    differences.iter().map(|difference| (difference / ratio).max(rounding)).collect()
}

/// The error that rounding leaves after so many steps with coordinates of this size.
pub(crate) fn rounding(size: f64, steps: u64) -> f64 {
    ROUNDING_PER_STEP * f64::EPSILON * size * (steps as f64).sqrt()
}
