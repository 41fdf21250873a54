//! A companion run: its difference from the run estimates the error.

mod errors;
mod extremes;

use qrm_core::{Mechanism, RowLayout, RowRequest};

use super::differences::Differences;
use super::extremes::FoundExtreme;
use super::quantities::Quantities;
use super::stop_condition::StopCondition;
use crate::integrate::{COMPANION_STEP_RATIO, Integrator, MethodSettings, StepError};
use crate::position::StartUncertainty;
use crate::solve::{IRREGULAR, SINGULAR, Solver};
use crate::state::{State, state_in};

/// The numbers of steps of a run and of its companion over the same time. As neither is a multiple of the other, the
/// two sample loads at different times, and pass singular positions at different distances.
const COMPANION_STEPS: [u64; 2] = [3, 2];
/// The numbers of steps of a run and of its second companion over the same time. Where steps are long, errors depend on
/// them irregularly, and two runs of a short motion may agree by chance.
const SECOND_COMPANION_STEPS: [u64; 2] = [5, 3];
/// The largest number of rows that the second companion follows: in a longer motion a chance agreement does not last.
const MOST_SECOND_ROWS: u64 = 4096;

/// The tolerance below which a companion's tolerance is reduced by the factor for order 4: smaller ones may be
/// unreachable near singular positions.
const ORDER4_THRESHOLD: f64 = 1e-8;
/// The smallest tolerance that double precision supports.
const SMALLEST_TOLERANCE: f64 = 1e-15;

/// Whether there is a second companion; a page has no room for it.
pub(super) const HAS_SECOND: bool = cfg!(feature = "extremes");
/// The relative change of the companion's first state.
const ROUNDING: f64 = 2.0 * f64::EPSILON;

/// Whether the errors of extremes and of the end time are estimated.
pub(super) const ESTIMATES_EXTREMES: bool = cfg!(feature = "extremes");

/// A companion run, with longer steps than its run. If a tolerance chooses the steps, the companion has shorter ones,
/// and the difference is the error of the run itself.
#[derive(Clone, Debug)]
pub(crate) struct Companion {
    integrator: Integrator,
    layout: RowLayout,
    /// The numbers of steps of the run and of the companion over the same time.
    steps: [u64; 2],
    /// A companion with other steps, for a short motion by fixed steps.
    second: Option<Box<Companion>>,
    at: State,
    next: State,
    /// The common start time.
    start: f64,
    /// The number of its last row.
    row: u64,
    /// The number of the run's last row.
    row_of_run: u64,
    /// The rows of the current block.
    rows: Vec<f64>,
    differences: Differences,
    /// Whether each quantity depends on accelerations or multipliers.
    by_forces: Vec<bool>,
    /// The largest differences of earlier parts of the motion, summed.
    before: Vec<f64>,
    /// The difference of the times at which the stop condition became true, and its rounding error.
    of_end_time: Option<[f64; 2]>,
    /// The changes of the quantities at the end over that time.
    at_event: Vec<f64>,
    /// The largest relative error of multipliers at extremes at singular positions.
    rounding_at_poles: f64,
    failed: bool,
}

/// Rows of a run for its companion to follow.
#[derive(Clone, Copy)]
pub(crate) struct RowBlock<'a> {
    pub(crate) rows: &'a [f64],
    /// The number of the first row.
    pub(crate) first: u64,
    /// The begin and end of the steps in the block, if a method chose them.
    pub(crate) steps: &'a [[f64; 2]],
    /// The extremes found in the block, none of them before the last row of the previous block.
    pub(crate) extremes: &'a [FoundExtreme],
}

impl Companion {
    /// Begins with the run; `None` if that is not possible. At an uncertain start it begins where that might lie:
    /// differences contain the uncertainty.
    pub(crate) fn new(
        mechanism: &dyn Mechanism,
        settings: &MethodSettings,
        (first, uncertainty): (&State, Option<&StartUncertainty>),
        end_time: f64,
        has_outputs: bool,
    ) -> Option<Self> {
        let settings = finer(settings);
        let mut at = beside(first);
        // A page has no room for it.
        let uncertainty = uncertainty.filter(|_| cfg!(feature = "events"));
        if let Some(other) = uncertainty {
            (at.q, at.qd) = (other.q.clone(), other.qd.clone());
            Solver::at(mechanism, at.t, &at.q).complete(mechanism, &mut at).ok()?;
        }
        let begin = |steps, second| {
            let states = [first, &at];
            let mut own = Self::with_steps(mechanism, (settings, steps, second), states, end_time, has_outputs)?;
            if uncertainty.is_some() {
                own.differences.take(mechanism, &first.as_ref(), &at.as_ref());
            }
            Some(own)
        };
        let has_second = HAS_SECOND && !settings.method.is_adaptive();
        let second = if has_second { Some(Box::new(begin(SECOND_COMPANION_STEPS, None)?)) } else { None };
        begin(COMPANION_STEPS, second)
    }

    fn with_steps(
        mechanism: &dyn Mechanism,
        (settings, steps, second): (MethodSettings, [u64; 2], Option<Box<Self>>),
        [first, at]: [&State; 2],
        end_time: f64,
        has_outputs: bool,
    ) -> Option<Self> {
        let layout = RowLayout { n: first.q.len(), m: first.multipliers.len() };
        let quantities = Quantities::new(mechanism.description(), has_outputs);
        Some(Self {
            integrator: integrator(mechanism, settings, at, end_time).ok()?,
            layout,
            steps,
            second,
            start: first.t,
            at: at.clone(),
            next: at.clone(),
            row: 0,
            row_of_run: 0,
            rows: Vec::new(),
            differences: Differences::new(quantities, mechanism, &first.as_ref()),
            by_forces: quantities.by_forces(mechanism),
            before: vec![0.0; quantities.count()],
            of_end_time: None,
            at_event: Vec::new(),
            rounding_at_poles: 0.0,
            failed: false,
        })
    }

    /// Advances to the state `end` of the run, where the parameters change, and continues from the state `first` of the
    /// run.
    ///
    /// Differences are summed, but not propagated: a program that changes parameters in response to the run, such as a
    /// controller, corrects the errors of the run, and would not correct those of another motion.
    pub(crate) fn change(&mut self, [old, new]: [&dyn Mechanism; 2], [end, first]: [&State; 2]) {
        if HAS_SECOND {
            self.second = None;
        }
        if !self.failed {
            self.failed = self.try_change([old, new], [end, first]).is_err();
        }
    }

    fn try_change(&mut self, [old, new]: [&dyn Mechanism; 2], [end, first]: [&State; 2]) -> Result<(), StepError> {
        self.advance_to(old, end)?;
        for (before, difference) in self.before.iter_mut().zip(self.differences.restart()) {
            *before += difference;
        }
        self.at.clone_from(first);
        self.integrator = integrator(new, self.integrator.settings, first, f64::INFINITY)?;
        (self.row, self.row_of_run) = (0, 0);
        Ok(())
    }

    /// Advances to the state `end` of the run.
    fn advance_to(&mut self, mechanism: &dyn Mechanism, end: &State) -> Result<(), StepError> {
        // Two steps, since the run may have made one: the same step would show no difference. After the common start,
        // so do several same steps.
        let is_at_start = self.integrator.is_fixed() && self.row == 0;
        let parts = if is_at_start { 2 * self.row_of_run.max(1) } else { 2 };
        let begin = self.at.t;
        for part in 1..parts {
            self.move_to(mechanism, begin + part as f64 / parts as f64 * (end.t - begin))?;
        }
        self.move_to(mechanism, end.t)?;
        self.differences.take(mechanism, &end.as_ref(), &self.at.as_ref());
        Ok(())
    }

    /// Advances to a time, unless the companion is already there.
    fn move_to(&mut self, mechanism: &dyn Mechanism, t: f64) -> Result<(), StepError> {
        if t > self.at.t {
            self.integrator.advance(mechanism, &self.at, t, &mut self.next)?;
            let State { q, qd, .. } = &self.next;
            if self.integrator.solver_mut().singularity_fraction(mechanism, SINGULAR, t, (q, qd)).is_some()
                && let Ok(next) = self.integrator.between(mechanism, &self.at, t)
            {
                self.next = next;
            } else {
                self.integrator.solver_mut().refine(mechanism, IRREGULAR, &mut self.next);
            }
            std::mem::swap(&mut self.at, &mut self.next);
        }
        Ok(())
    }

    /// Advances to the end of the run, at which `condition` may have become true.
    pub(crate) fn finish(&mut self, mechanism: &dyn Mechanism, end: &State, condition: Option<&StopCondition>) {
        if HAS_SECOND && let Some(second) = &mut self.second {
            second.finish(mechanism, end, condition);
        }
        // The companion may have passed the end of a run that failed.
        if self.failed || self.at.t > end.t {
            return;
        }
        self.failed = self.advance_to(mechanism, end).is_err();
        if ESTIMATES_EXTREMES {
            // They may agree by chance at the end.
            let of_state = &self.differences.each[..2 * self.layout.n];
            let floors: Vec<f64> = of_state.iter().map(|difference| difference.largest).collect();
            self.of_end_time = condition.and_then(|condition| {
                Some([condition.time_between(end, &self.at, &floors)?, condition.rounding_of_time(end).unwrap_or(0.0)])
            });
            if let Some([difference, of_condition]) = self.of_end_time {
                let mut moved = end.moved_along((difference / self.ratio()).max(of_condition));
                if self.integrator.solver_mut().complete(mechanism, &mut moved).is_ok() {
                    self.at_event = self.differences.between(mechanism, [&end.as_ref(), &moved.as_ref()]);
                }
            }
        }
    }

    /// Follows rows of the run, except a last one that is not a whole step.
    pub(crate) fn follow(&mut self, mechanism: &dyn Mechanism, request: &RowRequest, block: RowBlock) {
        if HAS_SECOND {
            self.second.take_if(|_| block.first > MOST_SECOND_ROWS);
        }
        if HAS_SECOND && let Some(second) = &mut self.second {
            second.follow(mechanism, request, block);
        }
        let RowBlock { rows, first, steps, .. } = block;
        let width = self.layout.width();
        let count = (rows.len() / width) as u64;
        let is_whole = |row: u64| rows[(row - first) as usize * width] == request.time(row);
        let end = first + count - u64::from(count > 0 && !is_whole(first + count - 1));
        self.row_of_run = (first + count).saturating_sub(1);
        if self.failed {
            return;
        }
        self.integrator.limit_steps_by(steps);
        if self.integrator.is_fixed() {
            self.follow_steps(mechanism, request, block, end);
        } else {
            self.failed = self.follow_rows(mechanism, block, end).is_err();
        }
    }

    /// Makes longer steps, up to the last common row of both before row number `end` of the run.
    fn follow_steps(&mut self, mechanism: &dyn Mechanism, request: &RowRequest, block: RowBlock, end: u64) {
        let (width, [of_run, own]) = (self.layout.width(), if HAS_SECOND { self.steps } else { COMPANION_STEPS });
        let steps = end.saturating_sub(1 + self.row) / of_run * own;
        let length = (steps as usize + 1) * width;
        if self.rows.len() < length {
            // Later blocks may contain a few more steps.
            self.rows.resize(length + own as usize * width, 0.0);
        }
        self.at.write(&mut self.rows);
        let step = of_run as f64 / own as f64 * request.step;
        let longer = RowRequest { step, first: self.row / of_run * own, watches_event: false, ..*request };
        let mut made = 0;
        if steps > 0 {
            let filled = self.integrator.fill(mechanism, &longer, &mut self.rows[..length]);
            self.failed = filled.reason.is_err();
            made = filled.rows_written;
        }
        let states = &self.rows[..(made + 1) * width];
        for state in states.chunks_exact(width).step_by(own as usize).skip(1) {
            self.row += of_run;
            let row = &block.rows[(self.row - block.first) as usize * width..];
            self.next.read(state);
            self.integrator.solver_mut().refine(mechanism, IRREGULAR, &mut self.next);
            self.differences.take(mechanism, &state_in(self.layout, row), &self.next.as_ref());
        }
        self.at.read(&states[made * width..]);
        if ESTIMATES_EXTREMES {
            let mut copy = None;
            for extreme in block.extremes {
                if self.may_matter(extreme) {
                    let integrator = copy.get_or_insert_with(|| self.integrator.clone());
                    let other = self.step_to(mechanism, integrator, made, [request.step, step], extreme.t);
                    self.compare(mechanism, extreme, other.as_ref());
                }
            }
        }
    }

    /// Advances to each row of the run before number `end`, and to each extreme.
    fn follow_rows(&mut self, mechanism: &dyn Mechanism, block: RowBlock, end: u64) -> Result<(), StepError> {
        let width = self.layout.width();
        let mut extremes = if ESTIMATES_EXTREMES { block.extremes.to_vec() } else { Vec::new() };
        if ESTIMATES_EXTREMES {
            extremes.sort_by(|a, b| a.t.total_cmp(&b.t));
        }
        let mut extremes = extremes.into_iter().peekable();
        let first = block.first.max(self.row + 1);
        for number in first..end.max(first) {
            let row = &block.rows[(number - block.first) as usize * width..];
            while ESTIMATES_EXTREMES && let Some(extreme) = extremes.next_if(|extreme| extreme.t < row[0]) {
                self.compare_at(mechanism, &extreme)?;
            }
            self.move_to(mechanism, row[0])?;
            self.row = number;
            self.differences.take(mechanism, &state_in(self.layout, row), &self.at.as_ref());
        }
        if ESTIMATES_EXTREMES { extremes.try_for_each(|extreme| self.compare_at(mechanism, &extreme)) } else { Ok(()) }
    }

    /// The number of values of a row.
    pub(crate) fn width(&self) -> usize {
        self.layout.width()
    }

    /// Whether the companion failed.
    pub(crate) fn failed(&self) -> bool {
        self.failed
    }
}

/// A state whose coordinates and rates differ by rounding errors: differences then show how much the motion amplifies
/// them.
fn beside(first: &State) -> State {
    let mut at = first.clone();
    at.q.iter_mut().for_each(|q| *q *= 1.0 + ROUNDING);
    at.qd.iter_mut().for_each(|qd| *qd *= 1.0 - ROUNDING);
    at
}

/// The state of a companion of an adaptive run at a time.
pub(super) fn state_of_companion(
    mechanism: &dyn Mechanism,
    settings: &MethodSettings,
    first: &State,
    t: f64,
) -> Option<State> {
    let mut at = first.clone();
    integrator(mechanism, finer(settings), first, t).ok()?.advance(mechanism, first, t, &mut at).ok()?;
    Some(at)
}

/// The settings of a companion.
fn finer(settings: &MethodSettings) -> MethodSettings {
    let finer = |order: u32| settings.tolerance * COMPANION_STEP_RATIO.powi(order as i32);
    let tolerance = finer(settings.method.order).max(finer(4).min(ORDER4_THRESHOLD)).max(SMALLEST_TOLERANCE);
    MethodSettings { tolerance, ..*settings }
}

/// Creates an integrator with coarser steps behind corners than those of the run.
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
