//! Designs in lanes: each lane makes the steps of one design until that ends, and then takes the next.

mod adaptive;

use qrm_core::{BatchRequest, LaneRole, LaneSchedule, Mechanism, Model, PauseReason, RowRequest, SimdBatch, Width};

use super::sweep::{DesignResult, SweepEnd, SweepRequest, run_alone};
use crate::integrate::{DOP853, Integrator, RK4, StepError};
use crate::run::{
    Branch, COMPANION_STEPS, StartError, Status, Undefined, accepted_errors, check_condition, check_step,
    estimated_errors, first_state, is_balanced, locate, worst,
};
use crate::solve::{Projection, Solver, constraint_rank, largest};
use crate::state::State;

/// A sweep in lanes.
pub(super) struct LaneSweep<'a> {
    designs: &'a [Box<dyn Mechanism>],
    request: &'a SweepRequest<'a>,
    batch: SimdBatch,
    /// Makes the steps that are no whole ones, and those that lanes cannot make.
    integrator: Integrator,
    /// The next design that waits.
    next: usize,
    finished: Vec<Option<DesignResult>>,
    /// The design of each lane; `None` in lanes that follow another for want of one.
    lanes: Vec<Option<Lane>>,
    /// The parameters of each lane.
    parameters: Vec<Vec<f64>>,
    /// Room for a row.
    row: Vec<f64>,
    /// Number of coordinates and of constraints.
    size: (usize, usize),
    /// The branch that designs are assembled on.
    branch: Branch,
    /// Whether a lane has lost its design.
    wants_refill: bool,
}

/// A design in a lane.
struct Lane {
    design: usize,
    rows: RowRequest,
    first: State,
    /// Whether the companion goes on.
    has_companion: bool,
    /// Whether the step under way is to end where the stop condition becomes true.
    is_landing: bool,
    /// The end of the design, while its companion runs in the lane.
    main: Option<adaptive::Main>,
}

impl<'a> LaneSweep<'a> {
    /// `None` where the processor or the mechanism has no lanes of this width.
    pub(super) fn new(
        model: &Model,
        designs: &'a [Box<dyn Mechanism>],
        request: &'a SweepRequest<'a>,
        width: Width,
    ) -> Option<Self> {
        let (settings, description) = (request.settings, model.description);
        let is_adaptive = settings.method == DOP853;
        if settings.method != RK4 && !is_adaptive || settings.projection != Projection::default() {
            return None;
        }
        // Lanes do not know where loads have corners.
        if is_adaptive && description.has_corners {
            return None;
        }
        let batch_request = BatchRequest {
            watches_event: request.end.is_none(),
            waits_each_step: matches!(request.end, Some(SweepEnd::Condition(_))),
            ranges: request.extremes,
            companions: request.estimate_error,
            is_adaptive,
        };
        let batch = model.batch(width, batch_request, settings.projection_tolerance.residual)?;
        let size = (description.coordinates.len(), description.constraints.len());
        let any = &**designs.first()?;
        let integrator =
            Integrator::with_solver(any, settings, &State::zero(size.0, size.1), 0.0, Solver::new(any)).ok()?;
        Some(Self {
            designs,
            request,
            integrator,
            next: 0,
            finished: designs.iter().map(|_| None).collect(),
            lanes: (0..batch.lanes()).map(|_| None).collect(),
            parameters: vec![vec![0.0; description.parameters.len()]; batch.lanes()],
            row: vec![0.0; 1 + 3 * size.0 + size.1],
            size,
            branch: Branch::of(any),
            batch,
            wants_refill: false,
        })
    }

    /// Runs all designs.
    pub(super) fn run(mut self) -> Vec<DesignResult> {
        self.refill();
        // All lanes may lose their designs at once while others wait.
        while self.next < self.designs.len() || self.lanes.iter().any(Option::is_some) {
            match self.batch.advance(self.wants_refill) {
                PauseReason::Step if self.is_adaptive() => self.resolve_adaptive_step(),
                PauseReason::Step => self.resolve_step(),
                PauseReason::Companion => self.resolve_companion(),
                PauseReason::Refill => self.refill(),
            }
        }
        self.finished.into_iter().flatten().collect()
    }

    /// Gives waiting designs to lanes without one; where none waits, such a lane follows another.
    fn refill(&mut self) {
        self.wants_refill = false;
        for lane in 0..self.lanes.len() {
            while self.lanes[lane].is_none() && self.next < self.designs.len() {
                let design = self.next;
                self.next += 1;
                match self.begin(design) {
                    Ok((_, first)) if self.is_redundant(design, &first) => {
                        self.finished[design] = Some(run_alone(design, &*self.designs[design], self.request));
                    }
                    Ok((rows, first)) => self.enter(lane, design, rows, &first),
                    Err(reason) => self.finished[design] = Some(DesignResult::not_started(reason)),
                }
            }
        }
        let Some(leader) = self.lanes.iter().position(Option::is_some) else { return };
        for lane in 0..self.lanes.len() {
            if self.lanes[lane].is_none() {
                self.parameters[lane] = self.parameters[leader].clone();
                self.batch.copy(leader, lane);
            }
        }
        self.batch.set_parameters(&self.parameters);
    }

    fn is_adaptive(&self) -> bool {
        self.request.settings.method.is_adaptive()
    }

    /// The latest end of a design.
    fn end_time(&self, design: usize) -> f64 {
        match self.request.end {
            Some(SweepEnd::Time(t)) => t,
            _ => self.designs[design].schedule().end_time,
        }
    }

    fn begin(&mut self, design: usize) -> Result<(RowRequest, State), StartError> {
        let mechanism = &*self.designs[design];
        let schedule = mechanism.schedule();
        let step = self.request.step.unwrap_or(schedule.step);
        let end_time = self.end_time(design);
        check_step(step, end_time)?;
        let first = first_state(mechanism, &self.branch)?;
        check_condition(self.condition(design, &first))?;
        let residual = self.integrator.settings.projection_tolerance.residual;
        Ok((RowRequest { origin: 0.0, step, end_time, first: 0, residual, watches_event: true }, first))
    }

    /// Whether constraints of a design repeat others, which lanes do not know.
    fn is_redundant(&self, design: usize, first: &State) -> bool {
        constraint_rank(&*self.designs[design], first.t, &first.q) < self.size.1
    }

    fn enter(&mut self, lane: usize, design: usize, rows: RowRequest, first: &State) {
        self.parameters[lane] = self.designs[design].parameters().to_vec();
        // The first row stands at zero, however near the end is.
        let mut last = (rows.end_time / rows.step).floor().max(1.0);
        while rows.time(last as u64) < rows.end_time {
            last += 1.0;
        }
        first.write(&mut self.row);
        self.batch.place(lane, &self.row, &LaneSchedule { step: rows.step, last, end_time: rows.end_time });
        let outputs = self.outputs(design, first);
        self.batch.begin_ranges(lane, &outputs);
        self.batch.set_outputs(lane, &outputs);
        let first = first.clone();
        let has_companion = self.request.estimate_error;
        self.lanes[lane] = Some(Lane { design, rows, first, has_companion, is_landing: false, main: None });
        if self.is_adaptive() {
            self.choose_steps(lane, 1.0);
        }
    }

    fn outputs(&self, design: usize, at: &State) -> Vec<f64> {
        let mechanism = &self.designs[design];
        let count = if self.request.extremes { mechanism.description().outputs.len() } else { 0 };
        let mut outputs = vec![0.0; count];
        mechanism.outputs(at.t, &at.q, &at.qd, &at.qdd, &at.multipliers, &mut outputs);
        outputs
    }

    /// The distance of the stop condition from true (negative), if there is one.
    fn condition(&self, design: usize, at: &State) -> Option<f64> {
        condition_value(self.request, &*self.designs[design], design, at)
    }

    /// The state of a lane, as the batch reads it into a row.
    fn state(&mut self, read: impl FnOnce(&SimdBatch, &mut Vec<f64>)) -> State {
        read(&self.batch, &mut self.row);
        let mut state = State::zero(self.size.0, self.size.1);
        state.read(&self.row);
        state
    }

    /// Takes up a step of which not every lane can simply go on.
    fn resolve_step(&mut self) {
        for lane in 0..self.lanes.len() {
            let Some(Lane { design, rows, .. }) = &self.lanes[lane] else { continue };
            if self.batch.goes_on(lane) {
                continue;
            }
            let (design, end_time) = (*design, rows.end_time);
            let mut to = self.state(|batch, row| batch.read_row(LaneRole::Main, lane, row));
            let from = self.state(|batch, row| batch.read_row_before(lane, row));
            if !self.batch.is_reliable(lane) {
                match self.robust_step(design, &from, to.t) {
                    Ok(robust) => {
                        robust.write(&mut self.row);
                        self.batch.set_row(LaneRole::Main, lane, &self.row);
                        let outputs = self.outputs(design, &robust);
                        self.batch.set_outputs(lane, &outputs);
                        to = robust;
                    }
                    Err(reason) => {
                        self.finish(lane, Status::Failed(reason), &from);
                        continue;
                    }
                }
            }
            let condition = self.condition(design, &to);
            match condition {
                Some(value) if value.is_nan() => {
                    let status = Status::NotFinite { t: to.t, what: Undefined::Condition };
                    self.finish(lane, status, &from);
                }
                Some(value) if value >= 0.0 => {
                    let (request, mechanism) = (self.request, &*self.designs[design]);
                    let value = |at: &State| condition_value(request, mechanism, design, at).unwrap_or(0.0);
                    match locate(&from, &to, value, |t| self.step_alone(design, &from, t)) {
                        Ok(at) => self.finish(lane, Status::Stopped, &at),
                        Err(reason) => self.finish(lane, Status::Failed(reason), &from),
                    }
                }
                _ if to.t >= end_time => {
                    let status = match condition {
                        Some(missing) => Status::StopNotReached { nearest_time: to.t, missing: -missing },
                        None => Status::Completed,
                    };
                    self.finish(lane, status, &to);
                }
                _ => {}
            }
        }
    }

    /// A step of a design by the plain functions.
    fn robust_step(&mut self, design: usize, from: &State, t: f64) -> Result<State, StepError> {
        let mut to = from.clone();
        self.integrator.advance_by_functions(&*self.designs[design], from, t, &mut to)?;
        Ok(to)
    }

    /// A step of a design by itself.
    fn step_alone(&mut self, design: usize, from: &State, t: f64) -> Result<State, StepError> {
        let mut to = from.clone();
        self.integrator.advance(&*self.designs[design], from, t, &mut to)?;
        Ok(to)
    }

    /// Takes up a step of the companions that cannot be relied on.
    fn resolve_companion(&mut self) {
        for lane in 0..self.lanes.len() {
            let Some(Lane { design, has_companion, .. }) = &self.lanes[lane] else { continue };
            if self.batch.is_reliable(lane) || !has_companion {
                continue;
            }
            let design = *design;
            let from = self.state(|batch, row| batch.read_row_before(lane, row));
            let main = self.state(|batch, row| batch.read_row(LaneRole::Main, lane, row));
            let robust = self.robust_step(design, &from, main.t);
            if let (Err(_), Some(lane)) = (&robust, &mut self.lanes[lane]) {
                lane.has_companion = false;
            }
            // Without a companion any state serves that makes no trouble.
            robust.unwrap_or(main).write(&mut self.row);
            self.batch.set_row(LaneRole::Companion, lane, &self.row);
        }
    }

    /// The largest difference of each coordinate from the companion in any row that both have; `None` if there is no
    /// such row.
    fn differences(&mut self, lane: usize, design: usize, at: &State) -> Option<Vec<f64>> {
        let (steps, [own, its]) = (self.batch.steps(lane), COMPANION_STEPS);
        let mut differences: Vec<f64> = (0..self.size.0).map(|i| self.batch.difference(lane, i)).collect();
        // The companion has not made the steps that end with the design.
        let ends_together = steps.is_multiple_of(own) && at.t >= self.end_time(design);
        if steps < if ends_together { own } else { own + 1 } {
            return None;
        }
        if ends_together {
            let mut companion = self.state(|batch, row| batch.read_row(LaneRole::Companion, lane, row));
            let step = (at.t - companion.t) / its as f64;
            companion = self.step_alone(design, &companion, at.t - step).ok()?;
            companion = self.step_alone(design, &companion, at.t).ok()?;
            for ((difference, own), q) in differences.iter_mut().zip(&companion.q).zip(&at.q) {
                *difference = difference.max((own - q).abs());
            }
        }
        Some(differences)
    }

    /// Estimated largest error of each coordinate; `None` where a run of its own is to judge the design.
    fn errors(&mut self, lane: usize, design: usize, at: &State) -> Option<Vec<f64>> {
        let steps = self.batch.steps(lane);
        let differences = self.differences(lane, design, at)?;
        let ranges = self.ranges(lane, at);
        let description = self.designs[design].description();
        let accepted = accepted_errors(description, &ranges, None, steps);
        let size = largest(ranges.as_flattened()).1;
        let errors = estimated_errors(&differences, size, steps, description.has_corners);
        worst(&errors, &accepted).is_none().then_some(errors)
    }

    /// The smallest and the largest value of each coordinate.
    fn ranges(&self, lane: usize, at: &State) -> Vec<[f64; 2]> {
        let range = |i: usize| {
            let [low, high] = self.batch.coordinate_range(lane, i);
            [low.min(at.q[i]), high.max(at.q[i])]
        };
        (0..self.size.0).map(range).collect()
    }

    /// Whether the energy at the end is that at the start, if no load without potential works at either.
    fn is_balanced(&self, design: usize, first: &State, at: &State) -> bool {
        let mechanism = &*self.designs[design];
        let power = |at: &State| mechanism.power(at.t, &at.q, &at.qd, &at.multipliers);
        if power(first) != 0.0 || power(at) != 0.0 {
            return true;
        }
        let [before, after] = [first, at].map(|at| mechanism.energy(&at.q, &at.qd));
        let imbalance = (after[0] + after[1] - before[0] - before[1]).abs();
        is_balanced(imbalance, before[0].max(after[0]), before[1].abs().max(after[1].abs()))
    }

    /// Takes up the end of a lane's design.
    fn finish(&mut self, lane: usize, status: Status, at: &State) {
        let Some(Lane { design, first, has_companion, .. }) = self.lanes[lane].take() else { return };
        self.wants_refill = true;
        let estimates = self.request.estimate_error && self.batch.steps(lane) >= COMPANION_STEPS[0];
        let errors = if estimates && has_companion { self.errors(lane, design, at) } else { None };
        let is_doubtful = estimates && errors.is_none() || !self.is_balanced(design, &first, at);
        if !status.is_done() || !self.batch.is_defined(lane) || is_doubtful {
            // A run of its own tells when and what went wrong.
            self.finished[design] = Some(run_alone(design, &*self.designs[design], self.request));
            return;
        }
        let estimated_error = errors.map(|errors| largest(&errors).1);
        self.finished[design] = Some(DesignResult { estimated_error, ..self.result(lane, design, status, at) });
    }

    /// The end of a design in a lane.
    fn result(&self, lane: usize, design: usize, status: Status, at: &State) -> DesignResult {
        let outputs = self.outputs(design, at);
        let status = match outputs.iter().position(|value| !value.is_finite()) {
            Some(output) => Status::NotFinite { t: at.t, what: Undefined::Output(output) },
            None => status,
        };
        let steps = self.batch.steps(lane);
        let range = |(output, value): (usize, &f64)| {
            let [low, high] = self.batch.range(lane, output);
            [low.min(*value), high.max(*value)]
        };
        let extremes = outputs.iter().enumerate().map(range).collect();
        DesignResult {
            status: Ok(status),
            steps,
            end_time: at.t,
            q: at.q.clone(),
            qd: at.qd.clone(),
            extremes,
            estimated_error: None,
            doubts: Vec::new(),
            is_alone: false,
        }
    }
}

/// The distance of the stop condition of a design from true (negative), if there is one.
fn condition_value(request: &SweepRequest, mechanism: &dyn Mechanism, design: usize, at: &State) -> Option<f64> {
    match request.end {
        Some(SweepEnd::Time(_)) => None,
        Some(SweepEnd::Condition(condition)) => Some(condition(design, at.t, &at.q, &at.qd)),
        None => mechanism.event(at.t, &at.q, &at.qd),
    }
}
