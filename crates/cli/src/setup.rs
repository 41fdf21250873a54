//! A scene prepared for a run as requested on the command line.

use std::collections::BTreeMap;
use std::io::Write;
use std::sync::Arc;

use qrm_core::{Description, Mechanism, Model, Tape};
use qrm_scene::diagnostic::{Diagnostic, Report};
use qrm_scene::evaluate::{constant, parameter_values};
use qrm_scene::formula_tape::event_tape;
use qrm_scene::names::suggestion;
use qrm_scene::resolve::{self, constant_condition, read_condition};
use qrm_scene::scene::Scene;
use qrm_scene::time_scales::{TimeScale, time_scales};
use qrm_sim::integrate::{MethodSettings, RK4, StepBounds};
use qrm_sim::position::{Start, assemble};
use qrm_sim::run::{End, Observer, Outcome, Request, simulate};
use qrm_sim::solve::{ProjectionTolerance, constraint_rank};

use crate::error::{Error, Message};
use crate::far_places::far_places;
use crate::options::{MethodOptions, SceneOptions, StartOptions, assignments, optional_positive, parameters};
use crate::regular_forms::{DesignSpace, Rewritten, rewritten};
use crate::resolution;
use crate::scenes::FoundScene;

/// A scene with its parameters set, and the options of its run.
pub(crate) struct Setup {
    /// The functions.
    pub(crate) model: &'static Model,
    /// The path of the scene file, as the user typed it.
    pub(crate) path: String,
    pub(crate) description: &'static Description,
    /// The scene from which the code was generated.
    pub(crate) scene: Arc<Scene>,
    pub(crate) settings: MethodSettings,
    /// The time scales of its loads and drives.
    scales: Vec<TimeScale>,
    /// The stop condition as written.
    pub(crate) until: String,
    /// The parameters changed on the command line.
    pub(crate) set: BTreeMap<String, f64>,
    /// The start given on the command line.
    start: Option<Start>,
    /// Another start, by which that one may be wrong.
    other_start: Option<Start>,
    /// The step given on the command line.
    pub(crate) requested_step: Option<f64>,
    /// The longest step given on the command line.
    max_step: Option<f64>,
    /// The end time given on the command line.
    pub(crate) end_time: Option<f64>,
    /// The event of the stop condition given on the command line.
    event: Option<Tape>,
    /// The messages about rewritten constraints and rough places.
    pub(crate) notes: Vec<Message>,
}

/// The largest difference of coordinates at the start, in rad or m, that belong to the same position.
const SAME_POSITION: f64 = 1e-6;

impl Setup {
    /// Prepares a scene of the command line; prints its notes.
    pub(crate) fn new(models: &'static [Model], options: &SceneOptions, how: &MethodOptions) -> Result<Self, Error> {
        let setup = Self::from_found(options.name.find(models)?, options, how)?;
        setup.print_notes();
        Ok(setup)
    }

    /// Prepares a scene that was found already; it is not read again if it contains a scene with its own values. The
    /// name in `options` is not used.
    pub(crate) fn from_found(found: FoundScene, options: &SceneOptions, how: &MethodOptions) -> Result<Self, Error> {
        let one = DesignSpace { count: 1, value: &|_, _| None, range: &|_| None };
        let mut setup = Self::without_rewrites(found, options, how)?.with_regular_forms(&one)?;
        setup.notes.extend(far_places(&setup));
        Ok(setup)
    }

    /// Prepares a scene with all constraints in their original form.
    pub(crate) fn without_rewrites(
        found: FoundScene,
        options: &SceneOptions,
        how: &MethodOptions,
    ) -> Result<Self, Error> {
        let FoundScene { model, path, scene } = found;
        let description = model.description;
        let set = parameters(description, &options.set)?;
        let replace = |name: &str| set.get(name).copied();
        let scene = match scene.filter(|_| set.is_empty()) {
            Some(scene) => scene,
            None => Arc::new(resolve::read_with(&path, description.source, &replace)?.0),
        };
        let requested_step = optional_positive("--step", options.step.as_ref(), "s")?;
        let end_time = optional_positive("--end-time", options.end_time.as_ref(), "s")?;
        let residual = optional_positive("--closure-tolerance", how.closure_tolerance.as_ref(), "")?;
        let tolerance = optional_positive("--tolerance", how.tolerance.as_ref(), "")?;
        let method = how.method.unwrap_or(RK4);
        if tolerance.is_some() && !method.is_adaptive() {
            return Err(Error::usage("`--tolerance` needs a method that chooses its steps")
                .help("add `--method dop853`, or choose `--step` instead"));
        }
        let max_step = optional_positive("--max-step", how.max_step.as_ref(), "s")?;
        if max_step.is_some() && !method.is_adaptive() {
            return Err(Error::usage("`--max-step` needs a method that chooses its steps")
                .help("add `--method dop853`, or choose `--step` instead"));
        }
        let default = MethodSettings::default();
        let scales = time_scales(&scene, &parameter_values(&scene, replace));
        let settings = MethodSettings {
            method,
            tolerance: tolerance.unwrap_or(default.tolerance),
            projection: how.projection.unwrap_or(default.projection),
            projection_tolerance: ProjectionTolerance {
                residual: residual.unwrap_or(default.projection_tolerance.residual),
                iterations: how.closure_iterations,
            },
            step_bounds: resolution::step_bounds(&scales, max_step),
        };
        let until = options.until.as_deref();
        let event = until.map(|until| event(&scene, model, until)).transpose()?;
        Ok(Self {
            settings,
            scales,
            until: until.unwrap_or(description.until).to_owned(),
            model,
            path,
            description,
            scene,
            set,
            start: None,
            other_start: None,
            requested_step,
            max_step,
            end_time,
            event,
            notes: Vec::new(),
        })
    }

    /// Replaces the constraints that may be singular in some design by regular forms.
    pub(crate) fn with_regular_forms(mut self, designs: &DesignSpace) -> Result<Self, Error> {
        let Some(Rewritten { model, scene, notes }) = rewritten(&self, designs.range)? else { return Ok(self) };
        // The original form also holds for mirrored positions, which the regular form excludes.
        let is_same = (0..designs.count).all(|design| {
            let replace = |name: &str| (designs.value)(design, name).or_else(|| self.replace()(name));
            let own_start = |mechanism: Box<dyn Mechanism>| assemble(&*mechanism, Start::new(&*mechanism));
            let [given, regular] = [self.model, model].map(|model| own_start(model.mechanism(&replace)));
            match (given, regular) {
                (Ok((given, _)), Ok((regular, _))) => {
                    given.iter().zip(&regular).all(|(a, b)| (a - b).abs() < SAME_POSITION)
                }
                (given, regular) => given.is_err() && regular.is_err(),
            }
        });
        if is_same {
            (self.model, self.description, self.scene) = (model, model.description, scene);
            if self.event.is_some() {
                self.event = Some(event(&self.scene, model, &self.until)?);
            }
            self.notes.extend(notes);
        }
        Ok(self)
    }

    /// Prints the messages about rewritten constraints and rough places.
    pub(crate) fn print_notes(&self) {
        for note in &self.notes {
            // Standard error may be closed.
            let _ = writeln!(std::io::stderr(), "{}", note.warning());
        }
    }

    /// Applies the start values of the options.
    pub(crate) fn starting_from(mut self, options: &StartOptions) -> Result<Self, Error> {
        if options.start.is_empty() {
            return Ok(self);
        }
        let mut start = Start::new(&*self.mechanism());
        let description = self.description;
        let unit = |name: &str| {
            let (own, is_rate) = name.strip_suffix("_dot").map_or((name, false), |own| (own, true));
            let coordinate = description.coordinates.iter().find(|coordinate| coordinate.name == own);
            match coordinate.map(|coordinate| (coordinate.unit, is_rate)) {
                Some(("rad", true)) => "rad/s",
                Some(("m", true)) => "m/s",
                Some((unit, false)) => unit,
                _ => "",
            }
        };
        for (name, value) in assignments("--start", &options.start, &unit)? {
            if start.set(self.description, &name, value).is_none() {
                let given = start.given_values(self.description);
                let names: Vec<&str> = given.iter().map(|(name, _)| name.as_str()).collect();
                let help = suggestion(&name, names.iter().copied(), || match &names[..] {
                    [] => "its motion is given by the constraints alone".to_owned(),
                    names => format!("given at the start: {}", names.join(", ")),
                });
                let scene = self.description.name;
                return Err(Error::usage(format!("`{name}` is not given at the start of scene `{scene}`")).help(help));
            }
        }
        self.start = Some(start);
        Ok(self)
    }

    /// Makes the run one over a period from a start, with another start by which that may be wrong, and rows at this
    /// distance.
    pub(crate) fn run_over(&mut self, [start, other]: [Start; 2], period: f64, step: f64) {
        (self.start, self.other_start) = (Some(start), Some(other));
        (self.end_time, self.requested_step) = (Some(period), Some(step));
    }

    /// Gives a parameter another value.
    pub(crate) fn set_parameter(&mut self, name: &str, value: f64) {
        self.set.insert(name.to_owned(), value);
    }

    /// Whether the start differs from that of the scene.
    pub(crate) fn has_own_start(&self) -> bool {
        self.start.is_some()
    }

    /// The bounds of the steps that a method chooses, for these parameter values.
    pub(crate) fn step_bounds(&self, parameters: &[f64]) -> StepBounds {
        resolution::step_bounds(&time_scales(&self.scene, parameters), self.max_step)
    }

    /// The values of parameters given on the command line.
    pub(crate) fn replace(&self) -> impl Fn(&str) -> Option<f64> {
        |name| self.set.get(name).copied()
    }

    /// Creates the mechanism with the parameters of the command line.
    pub(crate) fn mechanism(&self) -> Box<dyn Mechanism> {
        self.model.mechanism(&self.replace())
    }

    /// The start given on the command line, or that of the scene.
    pub(crate) fn start(&self) -> Start {
        self.start.clone().unwrap_or_else(|| Start::new(&*self.mechanism()))
    }

    /// Coordinates and rates at the start.
    pub(crate) fn first_state(&self) -> Result<[Vec<f64>; 2], Error> {
        let (q, qd) = assemble(&*self.mechanism(), self.start()).map_err(|reason| self.not_assembled(&reason))?;
        Ok([q, qd])
    }

    /// The coordinates at the start.
    pub(crate) fn assembled(&self) -> Result<Vec<f64>, Error> {
        let mechanism = self.mechanism();
        let (q, _) = assemble(&*mechanism, Start::new(&*mechanism)).map_err(|reason| self.not_assembled(&reason))?;
        Ok(q)
    }

    /// The values of all parameters of the scene, including those that the generated code omits.
    pub(crate) fn parameters(&self) -> Vec<f64> {
        parameter_values(&self.scene, self.replace())
    }

    /// The reason why fixed steps skip a time-dependent change of a load, in a run to an end time.
    pub(crate) fn passed_over(&self, end_time: f64) -> Option<String> {
        if self.settings.method.is_adaptive() {
            return None;
        }
        resolution::passed_over(&self.scales, self.step(), end_time)
    }

    /// Returns an error if constraints are redundant at a position of the mechanism.
    pub(crate) fn refuse_redundant(&self, q: &[f64]) -> Result<(), Error> {
        let (rank, count) = (constraint_rank(&*self.mechanism(), 0.0, q), self.description.constraints.len());
        if rank == count {
            return Ok(());
        }
        Err(self.redundant(rank))
    }

    /// The error of a command that needs independent constraints; `rank` of them are.
    pub(crate) fn redundant(&self, rank: usize) -> Error {
        let count = self.description.constraints.len();
        Error::usage(format!(
            "C_q has rank {rank} with {count} constraints: some of them repeat others, and this command needs \
             independent ones"
        ))
        .help("take the constraints out that follow from the others; `qrm run` and `qrm check` do with them")
    }

    /// Whether the command line changes a parameter.
    pub(crate) fn is_changed(&self) -> bool {
        !self.set.is_empty()
    }

    /// The step given on the command line, or that of the scene.
    pub(crate) fn step(&self) -> f64 {
        self.requested_step.unwrap_or_else(|| constant(&self.scene.run.step, &self.parameters()))
    }

    /// The end time given on the command line; infinite without one.
    pub(crate) fn latest_end(&self) -> f64 {
        self.end_time.unwrap_or(f64::INFINITY)
    }

    /// The end given on the command line; `None` for that of the scene.
    pub(crate) fn end(&self) -> Option<End<'_>> {
        self.end_time.map(End::Time).or(self.event.as_ref().map(End::Event))
    }

    /// Whether motions end at a condition.
    pub(crate) fn has_condition(&self) -> bool {
        match self.end() {
            Some(End::Time(_)) => false,
            Some(End::Event(_)) => true,
            None => self.scene.run.until.is_some(),
        }
    }

    /// The event of a condition on the names of the scene.
    pub(crate) fn event(&self, condition: &str) -> Result<Tape, Error> {
        event(&self.scene, self.model, condition)
    }

    /// Creates an error at a location in the scene.
    pub(crate) fn at_place(&self, diagnostic: Diagnostic) -> Error {
        Report::new(&self.path, self.description.source, vec![diagnostic]).into()
    }

    /// Runs the scene.
    pub(crate) fn simulate(&self, estimate_error: bool, observer: &mut dyn Observer) -> Result<Outcome, Error> {
        self.simulate_until(self.end(), estimate_error, observer)
    }

    /// Runs the scene to another end.
    pub(crate) fn simulate_until(
        &self,
        end: Option<End>,
        estimate_error: bool,
        observer: &mut dyn Observer,
    ) -> Result<Outcome, Error> {
        let request = Request {
            start: self.start.clone(),
            other_start: self.other_start.clone(),
            settings: self.settings,
            step: self.requested_step,
            end,
            estimate_error,
            ..Request::default()
        };
        let outcome = simulate(&*self.mechanism(), &request, observer);
        outcome.map_err(|reason| self.no_start(&reason))
    }
}

fn event(scene: &Scene, model: &Model, condition: &str) -> Result<Tape, Error> {
    let tape = event_tape(scene, &read_condition(scene, condition)?, model.named_tape());
    if tape.event_is_constant() {
        return Err(Report::new("--until", condition, vec![constant_condition(0..condition.len())]).into());
    }
    Ok(tape)
}
