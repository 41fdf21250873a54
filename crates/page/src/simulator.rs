//! A scene that can be run repeatedly.

mod answer;

use qrm_sim::position::Start;
use std::f64::consts::TAU;
use std::io;

use qrm_core::{Mechanism, Model, StoredTape};
use qrm_pictures::{Frame, Recording, Sources, motion, position_error};
use qrm_scene::evaluate::{self, constant, parameter_values};
use qrm_scene::scene::{Quantity, Scene};
use qrm_sim::analysis::inverse_kinematics;
use qrm_sim::columns::{self, Kind};
use qrm_sim::integrate::{DOP853, Integrator, MethodSettings};
use qrm_sim::run::{Observer, Outcome, Reason, Request, Row, SimError, Status, simulate};
use qrm_sim::state::State;

use crate::named_values::{Named, NamedValues};
use crate::packed::Packed;
use answer::{About, Answer, Run, failure, json, settable};

/// The largest number of frames of a motion; a screen cannot show more.
const MAX_FRAMES: usize = 400;
/// The number of rows of a draft.
const DRAFT_ROWS: f64 = 160.0;
/// The largest number of rows of a draft whose motion lasts longer than expected.
const MAX_DRAFT_ROWS: u64 = 1600;
/// The tolerance of a draft.
const DRAFT_TOLERANCE: f64 = 1e-7;

/// The largest number of rows of a run: the page is blocked while it is computed.
const MAX_ROWS: u64 = 300_000;

/// A derived scene.
pub(crate) struct Simulator {
    model: Model,
    scene: Scene,
    /// The scene's own parameters; those of a scene file may have changed since its derivation.
    own_parameters: Vec<f64>,
    last: LastRun,
}

/// The last run.
#[derive(Default)]
struct LastRun {
    /// The parameters and start values that the page changed for the run.
    values: NamedValues,
    /// The method of the run, and the time between its rows.
    settings: MethodSettings,
    step: f64,
    /// Some of its rows, in the order of the columns.
    frames: Vec<Frame>,
    /// The sources of the numbers of its motion.
    sources: Sources,
    /// The last row that was recomputed.
    row: Option<State>,
    /// The coordinates at the end of the last drag; `None` before the first one.
    dragged: Option<Vec<f64>>,
}

impl Simulator {
    /// Creates a simulator from the bytes of a derived scene.
    pub(crate) fn new(bytes: &[u8]) -> Result<Self, String> {
        let packed: Packed = postcard::from_bytes(bytes).map_err(|_| "these bytes are not a derived scene")?;
        let (model, scene) = (packed.description.into_model(StoredTape::from_placed(packed.tape)), packed.scene);
        let mut simulator = Self { model, scene, own_parameters: Vec::new(), last: LastRun::default() };
        simulator.own_parameters = simulator.mechanism(&NamedValues::default()).parameters().to_vec();
        Ok(simulator)
    }

    /// The scene as JSON.
    pub(crate) fn scene_json(&self) -> Result<String, String> {
        let description = self.model.description;
        let mechanism = self.mechanism(&NamedValues::default());
        let [mut parameters, start] = settable(&*mechanism, &Start::new(&*mechanism));
        for own in &self.scene.parameters {
            let follows = own.formula.names().any(|name| matches!(name, Quantity::Parameter(_)));
            parameters.iter_mut().filter(|each| each.name == own.name).for_each(|each| each.follows = follows);
        }
        let end_time = mechanism.schedule().end_time;
        let (name, doc, left_out) = (description.name, self.scene.doc.clone(), description.left_out);
        json(&About { name, doc, parameters, start, left_out, end_time })
    }

    /// The values of all parameters of the scene.
    fn parameters(&self, changed: &NamedValues) -> Vec<f64> {
        parameter_values(&self.scene, |name| changed.value(name))
    }

    fn mechanism(&self, changed: &NamedValues) -> Box<dyn Mechanism> {
        let values = self.parameters(changed);
        let place = |name: &str| self.scene.parameters.iter().position(|parameter| parameter.name == name);
        self.model.mechanism(&|name| place(name).map(|place| values[place]))
    }

    /// The start of a mechanism with the values from the page.
    fn start(&self, mechanism: &dyn Mechanism, changed: &NamedValues) -> Result<Start, String> {
        let description = self.model.description;
        let mut start = Start::new(mechanism);
        let is_parameter = |name: &str| description.parameters.iter().any(|parameter| parameter.name == name);
        for (name, value) in changed.iter().filter(|(name, _)| !is_parameter(name)) {
            start.set(description, name, value).ok_or_else(|| {
                format!("`{name}` is neither a parameter nor given at the start of `{}`", description.name)
            })?;
        }
        Ok(start)
    }

    /// Runs the scene like `qrm run`; returns the run and its motion as JSON.
    pub(crate) fn run(&mut self, changed: NamedValues) -> Result<String, String> {
        let request = Request { estimate_error: true, ..Request::default() };
        self.run_with(request, changed, MAX_ROWS)
    }

    /// Runs the scene to about `end` with fewer steps, and without an error estimate.
    pub(crate) fn draft(&mut self, changed: NamedValues, end: f64) -> Result<String, String> {
        let settings = MethodSettings::new(DOP853, DRAFT_TOLERANCE);
        let request = Request { settings, step: Some(end / DRAFT_ROWS), ..Request::default() };
        self.run_with(request, changed, MAX_DRAFT_ROWS)
    }

    fn run_with(&mut self, request: Request, changed: NamedValues, max_rows: u64) -> Result<String, String> {
        let description = self.model.description;
        let parameters = self.parameters(&changed);
        for body in &self.scene.bodies {
            if let Some((what, _, number)) = body.negative_inertia(|value| constant(value, &parameters)) {
                return Err(format!("body `{}` has a negative {what}: {number}", body.name));
            }
        }
        let mechanism = self.mechanism(&changed);
        let start = self.start(&*mechanism, &changed)?;
        let values =
            Named(settable(&*mechanism, &start).into_iter().flatten().map(|each| (each.name, each.value)).collect());
        let scene_parameters = Some(self.own_parameters.clone());
        let request = Request { start: Some(start), scene_parameters, ..request };
        let mut observer = (RowLimit { rows: 0, max_rows }, Recording::with_frames(description, MAX_FRAMES));
        let outcome = simulate(&*mechanism, &request, &mut observer);
        let recording = observer.1;
        let outcome = outcome.map_err(|reason| SimError { reason: Reason::Start(reason), description }.to_string())?;
        if recording.frames.len() < 2 {
            let still = || format!("`{}` stays where it is", description.name);
            return Err(failure(&outcome, description).unwrap_or_else(still));
        }
        let (motion, sources) =
            motion(&self.scene, &self.parameters(&changed), &recording).map_err(|e| e.to_string())?;
        self.last = LastRun {
            values: changed,
            settings: request.settings,
            step: outcome.step,
            frames: recording.frames,
            sources,
            row: None,
            dragged: self.last.dragged.take(),
        };
        let mut run = self.report(&outcome, values);
        if !request.estimate_error && matches!(outcome.status, Status::Interrupted) {
            // The run that follows a draft may continue.
            run.failure = None;
        }
        json(&Answer { run, motion })
    }

    /// The numbers of the last motion at a time, for its nodes, arrows, blocks and curves, as JSON.
    ///
    /// The run is recomputed from the row before that time.
    pub(crate) fn at(&mut self, t: f64) -> Result<String, String> {
        let mechanism = self.mechanism(&self.last.values);
        let description = self.model.description;
        let LastRun { values, settings, step, frames, sources, row: last_row, .. } = &mut self.last;
        let before = frames.partition_point(|frame| frame[0] <= t).saturating_sub(1);
        let mut now = columns::state(description, frames.get(before).ok_or("nothing has moved yet")?);
        if let Some(row) = last_row.as_ref().filter(|row| now.t < row.t && row.t <= t) {
            now = row.clone();
        }
        let failed = |t: f64, error| SimError { reason: Reason::Failed { t, error }, description }.to_string();
        let integrator = Integrator::new(&*mechanism, *settings, &now, f64::INFINITY);
        let mut integrator = integrator.map_err(|error| failed(now.t, error))?;
        let mut next = now.clone();
        while now.t < t {
            // Fixed steps end at the same times as those of the run.
            let row = (now.t / *step + 1e-6).floor() + 1.0;
            let to = if settings.method.is_adaptive() { t } else { t.min(row * *step) };
            integrator.advance(&*mechanism, &now, to, &mut next).map_err(|error| failed(now.t, error))?;
            if next.t < t {
                last_row.replace(next.clone());
            }
            std::mem::swap(&mut now, &mut next);
        }
        let (numbers, columns) = (columns::numbers(&*mechanism, &now), columns::columns(description));
        let parameters = parameter_values(&self.scene, |name| values.value(name));
        let state = evaluate::State::plain(&self.scene, &parameters, now.t, &now.q, &now.qd);
        let place = |kind: Kind| columns.iter().position(|column| column.kind == kind);
        json(&sources.numbers(&state, &|kind| place(kind).map_or(f64::NAN, |place| numbers[place])))
    }

    /// Drags points towards a target; returns the new start as JSON.
    pub(crate) fn drag(&mut self, t: f64, target: [f64; 2], points: &NamedValues) -> Result<String, String> {
        let description = self.model.description;
        if !t.is_nan() {
            let distance = |frame: &&Frame| (frame[0] - t).abs();
            let nearest = self.last.frames.iter().min_by(|a, b| distance(a).total_cmp(&distance(b)));
            self.last.dragged = nearest.map(|frame| columns::state(description, frame).q);
        }
        let from = self.last.dragged.as_ref().ok_or("nothing has moved yet")?;
        let mechanism = self.mechanism(&self.last.values);
        let parameters = self.parameters(&self.last.values);
        let place = |name: &str| self.scene.points.iter().position(|point| point.name == name);
        let point = |(name, weight)| Ok((place(name).ok_or_else(|| format!("there is no point `{name}`"))?, weight));
        let points = points.iter().map(point).collect::<Result<Vec<_>, String>>()?;
        let error = |q: &[f64]| position_error(&self.scene, &parameters, q, &points, target);
        let q = inverse_kinematics(&*mechanism, from, error);
        if !q.iter().all(|value| value.is_finite()) {
            return Err(format!("`{}` has no place there", description.name));
        }
        let own = Start::new(&*mechanism);
        let value = |i: usize| match description.is_angle(i) {
            // Whole turns during a drag are ignored.
            true => q[i] - TAU * ((q[i] - own.q[i]) / TAU).round(),
            false => q[i],
        };
        let given = (0..q.len()).filter(|&i| own.given[i]);
        let start = Named(given.map(|i| (description.coordinates[i].name, value(i))).collect());
        self.last.dragged = Some(q);
        json(&start)
    }

    fn report(&self, outcome: &Outcome, values: Named) -> Run {
        let description = self.model.description;
        let rejection_reasons = outcome.rejection_reasons(description);
        Run {
            end_time: outcome.end_time,
            failure: failure(outcome, description),
            steps: outcome.counts.accepted,
            estimated_error: outcome.estimated_error(),
            distrust: rejection_reasons.iter().map(|reason| reason.text(outcome.tolerance, description)).collect(),
            q: outcome.q.clone(),
            qd: outcome.qd.clone(),
            values,
        }
    }
}

/// Ends a run after a number of rows.
struct RowLimit {
    rows: u64,
    max_rows: u64,
}

impl Observer for RowLimit {
    fn row(&mut self, _row: &Row) -> io::Result<()> {
        self.rows += 1;
        Ok(())
    }

    fn keep_running(&mut self, _t: f64, _end_time: f64) -> io::Result<bool> {
        Ok(self.rows < self.max_rows)
    }
}
