//! A companion run beside a run, whose difference from it estimates the error.

use std::f64::consts::TAU;

use qrm_core::{Mechanism, RowLayout, RowRequest};

use super::error_estimate::{ErrorEstimates, rounding};
use super::quantities::{Difference, Differences, Quantities};
use crate::integrate::{BlockEnd, COMPANION_STEP_RATIO, Integrator, MethodSettings, StepError};
use crate::state::{State, state_in};

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
    /// The time at which both began.
    start: f64,
    /// The number of the row that it stands at.
    row: u64,
    /// Rows under way.
    rows: Vec<f64>,
    differences: Differences,
    /// The largest differences of parts of the motion that are over, added up.
    before: Vec<f64>,
    failed: bool,
}

impl Companion {
    /// Begins with the run; `None` if that is not possible.
    pub(crate) fn new(
        mechanism: &dyn Mechanism,
        settings: &MethodSettings,
        first: &State,
        end_time: f64,
        has_outputs: bool,
    ) -> Option<Self> {
        let finer = |order: u32| settings.tolerance * COMPANION_STEP_RATIO.powi(order as i32);
        let tolerance = finer(settings.method.order).max(finer(4).min(TIGHT)).max(SMALLEST_TOLERANCE);
        let settings = MethodSettings { tolerance, ..*settings };
        let layout = RowLayout { n: first.q.len(), m: first.multipliers.len() };
        let quantities = Quantities::new(mechanism.description(), has_outputs);
        Some(Self {
            integrator: integrator(mechanism, settings, first, end_time).ok()?,
            layout,
            start: first.t,
            at: first.clone(),
            next: first.clone(),
            row: 0,
            rows: Vec::new(),
            differences: Differences::new(quantities, mechanism, &first.as_ref()),
            before: vec![0.0; quantities.count()],
            failed: false,
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
        self.differences.take(old, &end.as_ref(), &self.at.as_ref());
        for (before, difference) in self.before.iter_mut().zip(self.differences.restart()) {
            *before += difference;
        }
        self.at.clone_from(first);
        self.integrator = integrator(new, self.integrator.settings, first, f64::INFINITY)?;
        self.row = 0;
        Ok(())
    }

    /// Follows rows of the run, of which the first has the number `first`; a last one that is no whole step is left out.
    /// A method that chooses its steps made `steps` meanwhile.
    pub(crate) fn follow(
        &mut self,
        mechanism: &dyn Mechanism,
        steps: &[[f64; 2]],
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
        self.integrator.limit_steps_by(steps);
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
            let row = &rows[(self.row - first) as usize * width..];
            self.differences.take(mechanism, &state_in(self.layout, row), &state_in(self.layout, state));
        }
        self.at.read(&made[block.made * width..]);
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
            self.differences.take(mechanism, &state_in(self.layout, row), &self.at.as_ref());
        }
    }

    /// The errors after so many steps; `None` if the companion broke off or never met the run.
    pub(crate) fn errors(&self, steps: u64) -> Option<ErrorEstimates> {
        if self.failed || !self.differences.has_met {
            return None;
        }
        let differences = &self.differences;
        let floors = self.floors(steps);
        let ratio = self.ratio();
        let errors = |own: &dyn Fn(&Difference) -> f64| -> Vec<f64> {
            let differences = differences.each.iter().map(own).zip(&self.before).zip(&floors);
            differences.map(|((own, before), floor)| ((own + before) / ratio).max(*floor)).collect()
        };
        Some(ErrorEstimates {
            quantities: differences.quantities,
            start: self.start,
            largest: errors(&|difference| difference.largest),
            at_extremes: [0, 1].map(|end| errors(&|difference| difference.at_extremes[end])),
            at_end: errors(&|difference| difference.latest),
        })
    }

    /// The ratio of differences to errors.
    fn ratio(&self) -> f64 {
        if !self.integrator.is_fixed() {
            return 1.0;
        }
        let of_coordinates = &self.differences.each[..self.layout.n];
        let total = of_coordinates.iter().zip(&self.before).map(|(own, before)| own.largest + before);
        let size = size(of_coordinates);
        if total.fold(0.0, f64::max) > LONG * size.min(TAU) { RATIO_OF_LONG_STEPS } else { RICHARDSON_FACTOR }
    }

    /// The errors below which a difference says nothing: the rounding errors of both runs may agree.
    fn floors(&self, steps: u64) -> Vec<f64> {
        let groups = self.differences.quantities.groups().into_iter().map(|group| &self.differences.each[group]);
        groups
            .flat_map(|group| {
                let rounding = rounding(size(group), steps);
                group.iter().map(move |difference| rounding.max(difference.noise))
            })
            .collect()
    }

    /// Whether it broke off.
    pub(crate) fn failed(&self) -> bool {
        self.failed
    }
}

/// The largest value of any of some quantities.
fn size(of: &[Difference]) -> f64 {
    of.iter().flat_map(|difference| difference.range).fold(0.0, |size, value| size.max(value.abs()))
}

/// An integrator with coarser steps behind corners than that of a run.
fn integrator(
    mechanism: &dyn Mechanism,
    settings: MethodSettings,
    first: &State,
    end_time: f64,
) -> Result<Integrator, StepError> {
    let mut integrator = Integrator::new(mechanism, settings, first, end_time)?;
    integrator.set_steps_behind_corners(COMPANION_STEPS[1] as u32);
    Ok(integrator)
}
