//! A scene as the command line wants it run.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use qrm_core::Description;
use qrm_scene::evaluate::parameter_values;
use qrm_scene::resolve;
use qrm_scene::scene::Scene as SceneText;

use super::arguments::{MethodArguments, MethodName, ProjectionName, SceneArguments};
use super::condition::Condition;
use super::late::Late;
use super::{Failure, settings, words};
use crate::motion::{Method, Scheme};
use crate::observer::Observer;
use crate::outcome::Outcome;
use crate::projection::Tolerance;
use crate::scenes::{Scene, Scenes};
use crate::simulate::{End, Request};

/// A scene with its parameters set, and how it is to be run.
pub(super) struct Setup<'s> {
    pub(super) scene: &'s dyn Scene,
    pub(super) description: Description,
    /// What the scene's text says.
    pub(super) text: SceneText,
    /// Where the text stands.
    pub(super) path: String,
    pub(super) method: Method,
    /// The name of its formula.
    pub(super) method_name: &'static str,
    /// The name of the projection.
    pub(super) projection: &'static str,
    /// The stop condition as written.
    pub(super) until: String,
    /// Parameters that the command line changes.
    pub(super) set: BTreeMap<String, f64>,
    /// Step and end of the command line.
    pub(super) step: Option<f64>,
    pub(super) end_time: Option<f64>,
    /// The stop condition of the command line.
    pub(super) condition: Option<Condition>,
}

/// The formula of this name, with its tolerance.
fn scheme(name: MethodName, tolerance: Option<f64>) -> Result<Scheme, Failure> {
    let chosen = tolerance.unwrap_or(1e-9);
    match name {
        MethodName::Rk4 | MethodName::Document if tolerance.is_some() => Err(Failure::Use(
            "error: `--tolerance` needs a method that chooses its steps\n  \
             = help: add `--method dop853`, or choose `--step` instead"
                .to_owned(),
        )),
        MethodName::Rk4 => Ok(Scheme::Rk4),
        MethodName::Document => Ok(Scheme::Document),
        MethodName::Dopri5 => Ok(Scheme::Dopri5 { tolerance: chosen }),
        MethodName::Dop853 => Ok(Scheme::Dop853 { tolerance: chosen }),
        MethodName::Auto => Ok(Scheme::Auto { tolerance: chosen }),
        MethodName::Rodas => Ok(Scheme::Rodas { tolerance: chosen }),
    }
}

/// The projection that is asked for, or that belongs to the method.
fn projection(how: &MethodArguments) -> Result<ProjectionName, Failure> {
    match (how.method, how.projection) {
        (MethodName::Document, None | Some(ProjectionName::Euclidean)) => Ok(ProjectionName::Euclidean),
        (MethodName::Document, Some(_)) => Err(Failure::Use(
            "error: the method `document` is one with its projection, which is euclidean\n  \
             = help: leave `--projection` away, or take `--method rk4`"
                .to_owned(),
        )),
        (_, asked) => Ok(asked.unwrap_or(ProjectionName::Mass)),
    }
}

impl<'s> Setup<'s> {
    pub(super) fn new(scenes: &'s Scenes, arguments: &SceneArguments, how: &MethodArguments) -> Result<Self, Failure> {
        let scene = settings::scene(scenes, &arguments.scene)?;
        let description = scene.description();
        let set = settings::parameters(&description, &arguments.set)?;
        let replace = |name: &str| set.get(name).copied();
        let path = format!("scenes/{}.toml", description.name);
        let text = resolve::read_with(&path, description.source, &replace);
        let (text, _) = text.map_err(|report| Failure::Use(report.to_string()))?;
        let option =
            |name: &str, value: &Option<String>| value.as_ref().map(|v| settings::positive(name, v)).transpose();
        let step = option("--step", &arguments.step)?;
        let end_time = option("--end-time", &arguments.end_time)?;
        let residual = option("--closure-tolerance", &how.closure_tolerance)?;
        let residual = residual.unwrap_or(Tolerance::default().residual);
        let tolerance = Tolerance { residual, iterations: how.closure_iterations };
        let error = option("--tolerance", &how.tolerance)?;
        let scheme = scheme(how.method, error)?;
        let projection = projection(how)?;
        let until = arguments.until.as_deref();
        let condition =
            until.map(|until| Condition::new(&text, until, parameter_values(&text, replace))).transpose()?;
        Ok(Self {
            method: Method { scheme, projection: projection.projection(), tolerance },
            method_name: how.method.name(),
            projection: projection.name(),
            until: until.unwrap_or(description.until).to_owned(),
            scene,
            description,
            text,
            path,
            set,
            step,
            end_time,
            condition,
        })
    }

    /// The value that the command line gives a parameter.
    pub(super) fn replace(&self) -> impl Fn(&str) -> Option<f64> {
        |name| self.set.get(name).copied()
    }

    /// The values of all parameters of the text.
    pub(super) fn parameters(&self) -> Vec<f64> {
        parameter_values(&self.text, self.replace())
    }

    /// Whether the command line changes a parameter.
    #[cfg(feature = "pictures")]
    pub(super) fn is_changed(&self) -> bool {
        !self.set.is_empty()
    }

    /// The step of the command line, or of the scene.
    #[cfg(any(feature = "fmu", feature = "pictures", feature = "sensitivity"))]
    pub(super) fn step(&self) -> f64 {
        self.step.unwrap_or_else(|| qrm_scene::evaluate::constant(&self.text.run.step, &self.parameters()))
    }

    /// The end that the command line asks for, if it asks for a time.
    pub(super) fn latest_end(&self) -> f64 {
        self.end_time.unwrap_or(f64::INFINITY)
    }

    /// Where the files of a command go.
    pub(super) fn folder(&self, out: Option<&Path>) -> PathBuf {
        settings::folder(&self.description, out)
    }

    /// Runs the scene.
    pub(super) fn simulate(&self, estimate_error: bool, observer: &mut dyn Observer) -> Result<Outcome, Failure> {
        let until = |t: f64, q: &[f64], qd: &[f64]| self.condition.as_ref().map_or(0.0, |c| c.value(t, q, qd));
        let end = match (self.end_time, &self.condition) {
            (Some(t), _) => Some(End::Time(t)),
            (None, Some(_)) => Some(End::Condition(&until)),
            (None, None) => None,
        };
        self.simulate_until(end, estimate_error, observer)
    }

    /// Runs the scene to another end.
    pub(super) fn simulate_until(
        &self,
        end: Option<End>,
        estimate_error: bool,
        observer: &mut dyn Observer,
    ) -> Result<Outcome, Failure> {
        let request = Request { method: self.method, step: self.step, end, estimate_error };
        let run = |observer: &mut dyn Observer| self.scene.simulate(&self.replace(), &request, observer);
        let outcome = match self.method.scheme {
            Scheme::Document => run(&mut Late::new(&self.text, self.parameters(), observer)),
            _ => run(observer),
        };
        outcome.map_err(|reason| Failure::Use(words::no_start(&reason, &self.description, &self.text, &self.path)))
    }
}
