//! A motion from one row to the next, by any method.

use qrm_core::{Mechanism, RowLayout, RowRequest, StopReason};

use super::adaptive::{Adaptive, Counts, IntermediateRows};
use super::corners::{Corner, Corners};
use super::fixed::{Fixed, StepBy};
use super::formula::Formula;
use super::methods::MethodSettings;
use super::step_error::StepError;
use crate::solve::{Projection, ProjectionTolerance, Solver, SolverStats};
use crate::state::{State, state_in};

/// Rows that the kernel makes before it is known whether the equations of motion had a corner between them.
const ROWS_BETWEEN_CORNERS: usize = 16;
/// Most numbers of states between rows that are kept.
const MOST_INNER: usize = 1 << 20;

/// A method with what it keeps between rows.
#[derive(Clone, Debug)]
pub struct Integrator {
    /// The method.
    pub settings: MethodSettings,
    solver: Solver,
    steps: Steps,
    /// Room for the two rows of a step.
    pair: [State; 2],
    layout: RowLayout,
    /// The choice of the states between rows that are kept; `inner` holds those of the last block.
    keeps_inner: Option<IntermediateRows>,
    inner: Vec<f64>,
}

#[derive(Clone, Debug)]
enum Steps {
    /// Each row is a step.
    Fixed(Box<Fixed>),
    /// Steps are chosen by a tolerance.
    Adaptive(Box<Adaptive>),
}

/// The end of a block of rows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Block {
    /// The number of rows.
    pub(crate) rows_written: usize,
    /// The reason why it ended; an error if the next row could not be made.
    pub(crate) reason: Result<StopReason, StepError>,
}

impl Integrator {
    /// Begins at a state.
    ///
    /// # Errors
    /// The method does not suit the scene, or the accelerations near the start are not determined.
    pub fn new(
        mechanism: &dyn Mechanism,
        settings: MethodSettings,
        first: &State,
        end_time: f64,
    ) -> Result<Self, StepError> {
        let layout = RowLayout { n: first.q.len(), m: first.multipliers.len() };
        let mut solver = Solver::at(mechanism, first.t, &first.q);
        let steps = match settings.method.formula {
            None => Steps::Fixed(Box::new(Fixed::new(mechanism, first))),
            Some(_) if settings.method.needs_linearization && !mechanism.has_linearization() => {
                return Err(StepError::NoLinearization);
            }
            Some(formula) => {
                let formula = formula(mechanism);
                let adaptive = Adaptive::new(mechanism, formula, settings.task(end_time), first, &mut solver)?;
                Steps::Adaptive(Box::new(adaptive))
            }
        };
        let pair = [first.clone(), first.clone()];
        Ok(Self { settings, solver, steps, pair, layout, keeps_inner: None, inner: Vec::new() })
    }

    /// Has states between rows kept, where steps are shorter than these.
    pub(crate) fn keep_inner_rows(&mut self, which: IntermediateRows) {
        self.keeps_inner = Some(which);
    }

    /// Begin and end of each step of the last block, where they are chosen by a tolerance.
    pub(crate) fn steps(&self) -> &[[f64; 2]] {
        match &self.steps {
            Steps::Fixed(_) => &[],
            Steps::Adaptive(adaptive) => adaptive.steps(),
        }
    }

    /// Makes the part of a fixed step behind a corner in so many steps.
    pub(crate) fn set_steps_behind_corners(&mut self, count: u32) {
        if let Steps::Fixed(fixed) = &mut self.steps {
            fixed.steps_behind_corners = count;
        }
    }

    /// End and formula of each step since the last call, where they are chosen by a tolerance.
    pub(crate) fn take_steps(&mut self) -> Vec<(f64, Formula)> {
        let Steps::Adaptive(adaptive) = &mut self.steps else { return Vec::new() };
        let formula = |kind| Formula::new(self.settings.method, kind);
        let steps = adaptive.steps().iter().zip(adaptive.kinds()).map(|([_, end], kind)| (*end, formula(kind)));
        let steps = steps.collect();
        adaptive.forget_steps();
        steps
    }

    /// Keeps steps that are chosen by a tolerance below those of another run at the same time.
    pub(crate) fn limit_steps_by(&mut self, steps: &[[f64; 2]]) {
        if let Steps::Adaptive(adaptive) = &mut self.steps {
            adaptive.forget_steps();
            adaptive.limit_steps_by(steps);
        }
    }

    /// A state between the rows of the last block, as a row.
    pub(crate) fn inner_row(&self, i: usize) -> Option<&[f64]> {
        let width = self.layout.width();
        self.inner.get(i * width..(i + 1) * width)
    }

    /// The states between the rows of the last block, as rows.
    pub(crate) fn inner_rows(&self) -> &[f64] {
        &self.inner
    }

    /// Statistics of the linear solves so far.
    pub fn stats(&self) -> &SolverStats {
        &self.solver.stats
    }

    /// The largest correction of each coordinate so far.
    pub fn corrections(&self) -> &[f64] {
        &self.solver.corrections
    }

    /// The number of constraints that are independent where the motion is not singular.
    pub(crate) fn rank(&self) -> usize {
        self.solver.rank()
    }

    /// The solver of the linear equations.
    pub(crate) fn solver_mut(&mut self) -> &mut Solver {
        &mut self.solver
    }

    /// Moves from a row to the next one, at `t`, by the generated kernel where the method allows it.
    ///
    /// # Errors
    /// The motion does not get there.
    pub fn advance(
        &mut self,
        mechanism: &dyn Mechanism,
        from: &State,
        t: f64,
        to: &mut State,
    ) -> Result<(), StepError> {
        let asks_kernel = self.is_by_kernel();
        self.advance_by(asks_kernel, mechanism, from, t, to)
    }

    fn is_by_kernel(&self) -> bool {
        self.settings.is_by_kernel() && !self.solver.is_redundant()
    }

    /// Moves from a row to the next one, at `t`, by the plain functions.
    ///
    /// # Errors
    /// The motion does not get there.
    pub(crate) fn advance_by_functions(
        &mut self,
        mechanism: &dyn Mechanism,
        from: &State,
        t: f64,
        to: &mut State,
    ) -> Result<(), StepError> {
        self.advance_by(false, mechanism, from, t, to)
    }

    fn advance_by(
        &mut self,
        asks_kernel: bool,
        mechanism: &dyn Mechanism,
        from: &State,
        t: f64,
        to: &mut State,
    ) -> Result<(), StepError> {
        let Self { settings, solver, steps, layout, keeps_inner, inner, .. } = self;
        let mut keep = |state: &State| {
            let begin = inner.len();
            if begin < MOST_INNER {
                inner.resize(begin + layout.width(), 0.0);
                state.write(&mut inner[begin..]);
            }
        };
        match steps {
            Steps::Fixed(fixed) => {
                fixed.advance(&mut StepBy { mechanism, settings, solver, asks_kernel }, from, t, to, &mut keep)
            }
            Steps::Adaptive(adaptive) => {
                let inner = keeps_inner.map(|which| (which, &mut keep as &mut dyn FnMut(&State)));
                adaptive.advance_to(mechanism, t, solver, to, inner)
            }
        }
    }

    /// The state at a time between the row `from` and the last one.
    ///
    /// # Errors
    /// The motion does not get there.
    pub fn between(&mut self, mechanism: &dyn Mechanism, from: &State, t: f64) -> Result<State, StepError> {
        let mut to = from.clone();
        if t == from.t {
            return Ok(to);
        }
        match &self.steps {
            Steps::Fixed(_) => {
                // States on the way are none of the block.
                let kept = self.inner.len();
                let made = self.advance(mechanism, from, t, &mut to);
                self.inner.truncate(kept);
                made?;
            }
            Steps::Adaptive(adaptive) => {
                let mut again = adaptive.restarted(from);
                again.advance_to(mechanism, t, &mut self.solver, &mut to, None)?;
            }
        }
        Ok(to)
    }

    /// Fills a block with rows after its first one, by the generated kernel where the method allows it.
    pub(crate) fn fill(&mut self, mechanism: &dyn Mechanism, request: &RowRequest, rows: &mut [f64]) -> Block {
        self.inner.clear();
        if let Steps::Adaptive(adaptive) = &mut self.steps {
            adaptive.forget_steps();
        }
        // The rows are borrowed beside the rest of the integrator.
        let mut pair = std::mem::replace(&mut self.pair, [State::zero(0, 0), State::zero(0, 0)]);
        let block = self.fill_with(mechanism, request, rows, &mut pair);
        self.pair = pair;
        block
    }

    fn fill_with(
        &mut self,
        mechanism: &dyn Mechanism,
        request: &RowRequest,
        rows: &mut [f64],
        [from, to]: &mut [State; 2],
    ) -> Block {
        let (layout, width) = (self.layout, self.layout.width());
        from.read(rows);
        let mut made = 0;
        loop {
            if self.is_by_kernel() {
                let rest = RowRequest { first: request.first + made as u64, ..*request };
                let room = self.rows_to_corner(&rest, rows.len() / width - made - 1, rows[made * width]);
                let result = mechanism.integrate_rk4(&rest, &mut rows[made * width..(made + room + 1) * width]);
                let smooth = self.rows_without_corner(&rows[made * width..(made + result.rows_written + 1) * width]);
                made += smooth;
                if smooth == result.rows_written && room > 0 {
                    match result.reason {
                        Some(StopReason::Full) if rows.len() >= (made + 2) * width => continue,
                        Some(reason) => return Block { rows_written: made, reason: Ok(reason) },
                        None => {}
                    }
                }
                from.read(&rows[made * width..]);
            }
            if rows.len() < (made + 2) * width {
                return Block { rows_written: made, reason: Ok(StopReason::Full) };
            }
            match self.row(mechanism, request.first + made as u64, request, from, to) {
                Err(reason) => return Block { rows_written: made, reason: Err(reason) },
                Ok(event) => {
                    made += 1;
                    to.write(&mut rows[made * width..]);
                    rows[made * width + layout.event()] = event;
                    if let Some(reason) = end_of_row(event, to, request, made, rows.len() / width) {
                        return Block { rows_written: made, reason: Ok(reason) };
                    }
                    std::mem::swap(from, to);
                }
            }
        }
    }

    /// The number of rows, at most `room`, for the kernel to make from `t` on.
    fn rows_to_corner(&mut self, request: &RowRequest, room: usize, t: f64) -> usize {
        let Some(corners) = self.corners() else { return room };
        if corners.at(t).is_some() {
            return 0;
        }
        let end = corners.next_time(t).map_or(f64::INFINITY, Corner::just_before);
        let room = room.min(ROWS_BETWEEN_CORNERS);
        (0..room).take_while(|row| request.time(request.first + *row as u64 + 1) <= end).count()
    }

    /// The corners that end steps of a fixed length.
    fn corners(&mut self) -> Option<&mut Corners> {
        match &mut self.steps {
            Steps::Fixed(fixed) => fixed.corners.as_mut(),
            Steps::Adaptive(_) => None,
        }
    }

    /// The number of rows of a block after its first one before which the motion meets no corner.
    fn rows_without_corner(&mut self, rows: &[f64]) -> usize {
        let (layout, width) = (self.layout, self.layout.width());
        let count = rows.len() / width - 1;
        let Some(corners) = self.corners() else { return count };
        let row = |i: usize| state_in(layout, &rows[i * width..]);
        (0..count).find(|i| corners.may_meet(&row(*i), &row(i + 1))).unwrap_or(count)
    }

    /// Makes the row after row `row` by the plain functions, and returns the value of the event there.
    fn row(
        &mut self,
        mechanism: &dyn Mechanism,
        row: u64,
        request: &RowRequest,
        from: &State,
        to: &mut State,
    ) -> Result<f64, StepError> {
        self.advance(mechanism, from, request.time(row + 1), to)?;
        let event = if request.watches_event { mechanism.event(&to.as_ref()) } else { None };
        Ok(event.unwrap_or(-1.0))
    }

    /// The largest difference between energy and work at the end of any step; `None` if rows are the steps.
    pub fn imbalance(&self) -> Option<f64> {
        match &self.steps {
            Steps::Fixed(_) => None,
            Steps::Adaptive(adaptive) => Some(adaptive.imbalance()),
        }
    }

    /// Whether no load without potential did work inside a step, as far as is known.
    pub(crate) fn is_conservative(&self) -> bool {
        match &self.steps {
            Steps::Fixed(_) => true,
            Steps::Adaptive(adaptive) => adaptive.is_conservative(),
        }
    }

    /// Whether each row is a step.
    pub fn is_fixed(&self) -> bool {
        matches!(self.steps, Steps::Fixed(_))
    }

    /// The numbers of steps and evaluations in a run of so many rows.
    pub fn counts(&self, rows: u64) -> Counts {
        match &self.steps {
            Steps::Fixed(_) => Counts { accepted: rows, evaluations: 4 * rows, ..Counts::default() },
            Steps::Adaptive(adaptive) => adaptive.counts(),
        }
    }
}

fn end_of_row(event: f64, row: &State, request: &RowRequest, made: usize, room: usize) -> Option<StopReason> {
    // Written so that a value that is not a number ends the block too.
    if !(event < 0.0) {
        Some(StopReason::Event)
    } else if row.t >= request.end_time {
        Some(StopReason::End)
    } else if made + 1 == room {
        Some(StopReason::Full)
    } else {
        None
    }
}

impl Solver {
    /// Moves a state along its rates and accelerations to a time so near that nothing else changes.
    ///
    /// # Errors
    /// The projection does not converge, or the accelerations are not determined.
    pub(super) fn cross(
        &mut self,
        mechanism: &dyn Mechanism,
        projection: (Projection, ProjectionTolerance),
        t: f64,
        state: &mut State,
    ) -> Result<(), StepError> {
        state.move_along(t - state.t);
        state.t = t;
        self.projected(mechanism, projection, state)
    }

    /// Completes a state by its accelerations and multipliers.
    ///
    /// # Errors
    /// The accelerations are not determined, or not finite.
    pub fn complete(&mut self, mechanism: &dyn Mechanism, state: &mut State) -> Result<(), StepError> {
        let State { t, q, qd, qdd, multipliers, .. } = state;
        self.accelerations(mechanism, *t, (q, qd), (qdd, multipliers))?;
        if state.is_finite() { Ok(()) } else { Err(StepError::NotFinite) }
    }

    /// Closes the loops of a state under other parameters, if they are to be closed, and completes it.
    ///
    /// # Errors
    /// The projection does not converge, or the accelerations are not determined.
    pub(crate) fn make_consistent(
        &mut self,
        mechanism: &dyn Mechanism,
        settings: &MethodSettings,
        state: &mut State,
    ) -> Result<(), StepError> {
        if settings.projection != Projection::None {
            let projection = (settings.projection, settings.projection_tolerance);
            self.project(mechanism, projection, state.t, &mut state.q, &mut state.qd)?;
        }
        state.corrections = 0;
        self.complete(mechanism, state)
    }

    /// Projects the coordinates and rates of a state, and completes it, by the kernel where the projection allows it.
    ///
    /// # Errors
    /// The projection does not converge, or the accelerations are not determined.
    pub(super) fn projected(
        &mut self,
        mechanism: &dyn Mechanism,
        (projection, tolerance): (Projection, ProjectionTolerance),
        state: &mut State,
    ) -> Result<(), StepError> {
        if self.projects_by_kernel((projection, tolerance))
            && self.project_by_kernel(mechanism, tolerance.residual, state)
        {
            return Ok(());
        }
        if projection == Projection::Mass {
            self.factor_mass(mechanism, &state.q);
        }
        self.projected_by_functions(mechanism, (projection, tolerance), state)
    }

    /// Whether kernels make this projection, and steps with it: not where constraints repeat others.
    pub(super) fn projects_by_kernel(&self, (projection, tolerance): (Projection, ProjectionTolerance)) -> bool {
        projection.is_by_kernel(&tolerance) && !self.is_redundant()
    }

    /// Projects and completes a state by the plain functions, in the metric that is known.
    ///
    /// # Errors
    /// The projection does not converge, or the accelerations are not determined.
    pub(super) fn projected_by_functions(
        &mut self,
        mechanism: &dyn Mechanism,
        projection: (Projection, ProjectionTolerance),
        state: &mut State,
    ) -> Result<(), StepError> {
        let State { t, q, qd, .. } = state;
        state.corrections = self.project(mechanism, projection, *t, q, qd)?;
        self.complete(mechanism, state)
    }
}
