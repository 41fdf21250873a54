//! Designs in lanes: each lane makes the steps of one design until that ends, and then takes the next. Their companions
//! follow in the same way.

mod companion;
mod landing;
mod result;

use crate::position::{AssemblyBranch, Start};
use qrm_core::{Batch, BatchRequest, LaneSchedule, Mechanism, Model, Tape};

use super::design::{DesignResult, SweepRequest};
use crate::event::{End, EventBounds, EventFunction};
use crate::integrate::{AUTO, StepBounds, quintic};
use crate::run::{StartError, Status, check_condition, check_step, first_position};
use crate::solve::{LoopConstraints, Projection, SingularityDistance, Solver, largest};
use crate::state::State;
use companion::{Companion, LONGER, LOOSER};

/// The largest tolerance: errors of longer steps do not follow the tolerance.
const MAX_TOLERANCE: f64 = 3e-9;
/// A design of `auto` with more steps leaves its lane: it may be stiff.
const MAX_STEPS: f64 = 2000.0;

/// The number of places in a step at which its distance from singular positions is measured, and the smallest singular
/// value there, as a fraction of the largest one, that leaves forces their digits.
const PLACES: u32 = 8;
const NEAR_SINGULAR: f64 = 0.05;

/// A sweep in lanes.
pub(super) struct LaneSweep<'a> {
    designs: &'a [Box<dyn Mechanism>],
    request: &'a SweepRequest<'a>,
    batch: Batch,
    /// The batch of companions, if errors are estimated.
    companions: Option<Batch>,
    /// The next design that waits.
    next: usize,
    /// Companions that wait.
    waiting: Vec<Lane>,
    finished: Vec<Option<DesignResult>>,
    /// The design of each lane; `None` in lanes that rest for want of one.
    lanes: Vec<Option<Lane>>,
    /// Room for a row, for the states at both ends of a step, and for another one near its end.
    row: Vec<f64>,
    from: State,
    to: State,
    near: State,
    /// Number of coordinates and of constraints.
    size: (usize, usize),
    /// The event that ends the design of each lane; none if designs end at a time.
    events: Vec<EventFunction<'a>>,
    /// The bounds of the event that were made last.
    event_bounds: Option<EventBounds>,
    /// The branch that designs are assembled on.
    branch: AssemblyBranch,
    /// Computes the first accelerations; it does not know of constraints that repeat others, nor do lanes.
    solver: Solver,
}

/// A design in a lane.
struct Lane {
    design: usize,
    first: State,
    /// Bounds of its steps, which take long to find.
    bounds: StepBounds,
    /// The latest end.
    end_time: f64,
    /// Whether the step under way is to end where the stop condition becomes true.
    is_landing: bool,
    /// The number of such steps so far.
    landings: u32,
    /// The distance from singular positions; made when the design may come near one.
    distance: Option<SingularityDistance>,
    /// The comparison of the companion with its design, where the companion is under way.
    companion: Option<Companion>,
}

impl Lane {
    /// Begins with a design.
    fn new(design: usize, first: State, bounds: StepBounds, end_time: f64) -> Self {
        Self { design, first, bounds, end_time, is_landing: false, landings: 0, distance: None, companion: None }
    }

    /// Whether a step comes near a singular position.
    fn passes_singular(&mut self, mechanism: &dyn Mechanism, from: &State, to: &State) -> bool {
        let first = &self.first;
        let rank = first.multipliers.len();
        let new = || SingularityDistance::at(mechanism, rank, first.t, (&first.q, &first.qd));
        let distance = self.distance.get_or_insert_with(new);
        (0..=PLACES).any(|place| {
            let at = quintic(from, to, from.t + (to.t - from.t) * f64::from(place) / f64::from(PLACES));
            let jacobian = LoopConstraints::at(mechanism, at.t, &at.q).constraint_jacobian;
            distance.measure(&jacobian).is_some_and(|value| value < NEAR_SINGULAR * distance.largest())
        })
    }

    /// The next time that a step is to end at.
    fn next_end(&self, t: f64) -> f64 {
        let end_time = self.bounds.next_end(t).min(self.end_time);
        let checkpoint = self.companion.as_ref().and_then(|companion| companion.next_checkpoint(t));
        checkpoint.map_or(end_time, |checkpoint| end_time.min(checkpoint))
    }
}

impl<'a> LaneSweep<'a> {
    /// `None` where there are no lanes, or the method makes other steps. The last function creates batches.
    pub(super) fn new(
        model: &Model,
        designs: &'a [Box<dyn Mechanism>],
        request: &'a SweepRequest<'a>,
        new_batch: &dyn Fn(BatchRequest, f64) -> Option<Batch>,
    ) -> Option<Self> {
        let (settings, description) = (request.settings, model.description);
        // Lanes do not know where loads have corners.
        if !settings.method.has_lanes() || settings.projection != Projection::default() || description.has_corners {
            return None;
        }
        // Lanes look at outputs a few times in a step.
        if request.extremes && designs.first()?.tape().is_some_and(Tape::outputs_may_be_narrow) {
            return None;
        }
        // Lanes look inside steps for events that are convex.
        let waits_each_step = match request.end {
            Some(End::Time(_)) => false,
            Some(End::Event(_)) => true,
            None => designs.first()?.tape().is_some_and(|tape| tape.event.is_some() && !tape.event_is_convex()),
        };
        let batch_request = BatchRequest {
            watches_event: request.end.is_none(),
            waits_each_step,
            ranges: request.extremes,
            forces: request.extremes && designs.first()?.tape().is_some_and(Tape::outputs_take_forces),
            checkpoints: request.estimate_error,
        };
        let residual = settings.projection_tolerance.residual;
        let batch = new_batch(batch_request, residual)?;
        let plain = BatchRequest {
            watches_event: false,
            waits_each_step: false,
            ranges: false,
            forces: false,
            checkpoints: false,
        };
        let companions = if request.estimate_error { Some(new_batch(plain, residual)?) } else { None };
        let size = (description.coordinates.len(), description.constraints.len());
        Some(Self {
            designs,
            request,
            companions,
            next: 0,
            waiting: Vec::new(),
            finished: designs.iter().map(|_| None).collect(),
            lanes: (0..batch.lanes()).map(|_| None).collect(),
            row: vec![0.0; 1 + 3 * size.0 + size.1],
            from: State::default(),
            to: State::default(),
            near: State::default(),
            size,
            events: (0..batch.lanes()).filter_map(|_| EventFunction::new(&**designs.first()?, request.end)).collect(),
            event_bounds: None,
            branch: AssemblyBranch::new(&**designs.first()?),
            solver: Solver::with_rank(&**designs.first()?, size.1),
            batch,
        })
    }

    /// Runs all designs, and then their companions.
    pub(super) fn run(mut self) -> Vec<DesignResult> {
        self.run_batch();
        if let Some(companions) = self.companions.take() {
            self.batch = companions;
            self.run_batch();
        }
        self.finished.into_iter().flatten().collect()
    }

    fn run_batch(&mut self) {
        self.refill();
        while self.lanes.iter().any(Option::is_some) {
            self.batch.advance();
            for lane in 0..self.lanes.len() {
                if self.lanes[lane].is_some() && !self.batch.keep_running(lane) {
                    self.resolve_step(lane);
                }
            }
            self.refill();
        }
    }

    /// Gives waiting designs to lanes without one; where none waits, such a lane rests.
    fn refill(&mut self) {
        if self.lanes.iter().all(Option::is_some) {
            return;
        }
        for lane in 0..self.lanes.len() {
            if self.lanes[lane].is_none() {
                self.take_next(lane);
            }
        }
        let Some(leader) = self.lanes.iter().position(Option::is_some) else { return };
        for lane in 0..self.lanes.len() {
            if self.lanes[lane].is_none() {
                self.batch.rest(lane, leader);
            }
        }
    }

    /// Gives a lane the next design that can begin, or the next companion.
    fn take_next(&mut self, lane: usize) {
        while self.next < self.designs.len() {
            let design = self.next;
            self.next += 1;
            match self.first_state(lane, design) {
                Ok(Some(first)) => {
                    let outputs = self.outputs(design, &first);
                    self.batch.begin_ranges(lane, &outputs);
                    let (bounds, end_time) = (self.request.bounds_of(design), self.end_time(design));
                    let next = Lane::new(design, first, bounds, end_time);
                    return self.begin(lane, next);
                }
                Ok(None) => self.run_alone(design),
                Err(reason) => self.finished[design] = Some(DesignResult::not_started(reason)),
            }
        }
        if self.companions.is_none()
            && let Some(next) = self.waiting.pop()
        {
            self.begin(lane, next);
        }
    }

    /// The first state of a design; `None` if a run of its own is to find it.
    fn first_state(&mut self, lane: usize, design: usize) -> Result<Option<State>, StartError> {
        let mechanism = &*self.designs[design];
        check_step(self.request.step.unwrap_or(mechanism.schedule().step), self.end_time(design))?;
        let mut first = first_position(mechanism, &self.branch, Start::new(mechanism))?;
        if self.solver.complete(mechanism, &mut first).is_err() {
            return Ok(None);
        }
        if let Some(event) = self.events.get_mut(lane) {
            event.set_parameters(mechanism);
            event.share_bounds(mechanism, &mut self.event_bounds);
            let value = event.value(mechanism, &first);
            check_condition(value)?;
            value.into_iter().for_each(|value| event.set_start(value));
        }
        Ok(Some(first))
    }

    /// The latest end of a design.
    fn end_time(&self, design: usize) -> f64 {
        match self.request.end {
            Some(End::Time(t)) => t,
            _ => self.designs[design].schedule().end_time,
        }
    }

    /// Begins with a design or its companion.
    fn begin(&mut self, lane: usize, next: Lane) {
        self.batch.set_parameters(lane, self.designs[next.design].parameters());
        let [looser, longer] = if next.companion.is_some() { [LOOSER, LONGER] } else { [1.0, 1.0] };
        let settings = self.request.settings;
        let tolerance = looser * settings.tolerance.min(MAX_TOLERANCE);
        let first = &next.first;
        let rate = largest(&first.qd).1.max(largest(&first.qdd).1.sqrt()).max(1.0 / next.end_time);
        first.write(&mut self.row);
        let schedule = LaneSchedule {
            tolerance,
            longest: longer * next.bounds.longest,
            end_time: next.next_end(first.t),
            step: tolerance.powf(0.125) / rate,
            max_steps: if settings.method == AUTO { MAX_STEPS } else { f64::INFINITY },
        };
        self.batch.place(lane, &self.row, &schedule);
        self.lanes[lane] = Some(next);
    }

    /// Lets a lane go on up to the next time that a step is to end at.
    fn go_on(&mut self, lane: usize, t: f64) {
        let Some(of_lane) = &self.lanes[lane] else { return };
        let schedule = LaneSchedule { end_time: of_lane.next_end(t), ..self.batch.schedule(lane) };
        self.batch.set_schedule(lane, &schedule);
    }

    /// Takes up a step after which a lane cannot simply go on.
    fn resolve_step(&mut self, lane: usize) {
        let mut to = std::mem::take(&mut self.to);
        self.read(&mut to, |batch, row| batch.read_row(lane, row));
        self.resolve(lane, &to);
        self.to = to;
    }

    fn resolve(&mut self, lane: usize, to: &State) {
        if !self.batch.is_reliable(lane) || self.passes_singular(lane, to) {
            return self.leave(lane);
        }
        let Some(Lane { design, end_time, is_landing, companion, .. }) = &mut self.lanes[lane] else { return };
        let (design, end_time, is_landing) = (*design, *end_time, *is_landing);
        if let Some(companion) = companion {
            companion.compare(to);
            if to.t >= end_time {
                return self.finish_companion(lane, to);
            }
        } else {
            let has_landed = is_landing && to.t >= self.batch.schedule(lane).end_time;
            match self.events.get(lane).and_then(|event| event.value(&*self.designs[design], to)) {
                Some(value) if value.is_nan() => return self.leave(lane),
                Some(_) if !is_landing && self.land_inside(lane, to) => return,
                Some(value) if has_landed || value >= 0.0 => return self.land(lane, to, value),
                // The step was rejected, or is made in several.
                Some(_) if is_landing && !self.batch.is_stuck(lane) => return,
                // A run of its own tells how near the design came.
                Some(_) if to.t >= end_time => return self.leave(lane),
                None if to.t >= end_time => return self.finish(lane, Status::Completed, to),
                _ => {}
            }
        }
        if self.batch.is_stuck(lane) { self.leave(lane) } else { self.go_on(lane, to.t) }
    }

    /// Whether the last step of a lane came near a singular position, at which outputs lose digits.
    fn passes_singular(&mut self, lane: usize, to: &State) -> bool {
        if !self.batch.may_be_singular(lane) {
            return false;
        }
        let mut from = std::mem::take(&mut self.from);
        self.read(&mut from, |batch, row| batch.read_row_before(lane, row));
        let of_lane = self.lanes[lane].as_mut();
        let passes = of_lane.is_some_and(|of_lane| of_lane.passes_singular(&*self.designs[of_lane.design], &from, to));
        self.from = from;
        passes
    }

    fn outputs(&self, design: usize, at: &State) -> Vec<f64> {
        let mechanism = &self.designs[design];
        let count = if self.request.extremes { mechanism.description().outputs.len() } else { 0 };
        let mut outputs = vec![0.0; count];
        mechanism.outputs(at.t, &at.q, &at.qd, &at.qdd, &at.multipliers, &mut outputs);
        outputs
    }

    /// Reads a state of a lane, as the batch reads it into a row.
    fn read(&mut self, state: &mut State, read: impl FnOnce(&Batch, &mut Vec<f64>)) {
        read(&self.batch, &mut self.row);
        state.q.resize(self.size.0, 0.0);
        state.qd.resize(self.size.0, 0.0);
        state.qdd.resize(self.size.0, 0.0);
        state.multipliers.resize(self.size.1, 0.0);
        state.read(&self.row);
    }
}
