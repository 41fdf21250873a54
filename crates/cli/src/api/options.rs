//! The options of a run.

use qrm_scene::names::suggestion;
use qrm_sim::integrate::{METHODS, Method, method_named};
use qrm_sim::solve::Projection;

use crate::error::Error;
use crate::options::{MethodOptions, SceneName, SceneOptions, StartOptions};

/// The options of a run, as in the command. Values are numbers, or formulae of numbers such as `3*pi`.
#[derive(Clone, Debug, Default)]
pub struct RunOptions {
    /// New values of parameters: `--set`.
    pub set: Vec<(String, String)>,
    /// Values at the start: `--start`.
    pub start: Vec<(String, String)>,
    /// Step of the integration or of the rows, in s.
    pub step: Option<String>,
    /// End of the motion, in s.
    pub end_time: Option<String>,
    /// A condition that ends the motion.
    pub until: Option<String>,
    /// The integration method, by its name.
    pub method: Option<String>,
    /// Largest error of a step.
    pub tolerance: Option<String>,
    /// Longest step, in s.
    pub max_step: Option<String>,
    /// The projection after each step, by its name.
    pub projection: Option<String>,
    /// Largest residual of a constraint that is not corrected.
    pub closure_tolerance: Option<String>,
    /// Largest number of corrections of the position after a step.
    pub closure_iterations: Option<u32>,
}

impl RunOptions {
    /// Converts the options to those of the command.
    pub(super) fn parsed(&self) -> Result<(SceneOptions, StartOptions, MethodOptions), Error> {
        if self.end_time.is_some() && self.until.is_some() {
            return Err(Error::usage("`--end-time` and `--until` are both given").help("keep one of the two"));
        }
        let assignments =
            |values: &[(String, String)]| values.iter().map(|(name, value)| format!("{name}={value}")).collect();
        let scene = SceneOptions {
            name: SceneName { scene: String::new() },
            set: assignments(&self.set),
            step: self.step.clone(),
            end_time: self.end_time.clone(),
            until: self.until.clone(),
        };
        let default = MethodOptions::default();
        let method = MethodOptions {
            method: self.method.as_deref().map(method).transpose()?,
            tolerance: self.tolerance.clone(),
            max_step: self.max_step.clone(),
            projection: self.projection.as_deref().map(projection).transpose()?,
            closure_tolerance: self.closure_tolerance.clone(),
            closure_iterations: self.closure_iterations.unwrap_or(default.closure_iterations),
        };
        Ok((scene, StartOptions { start: assignments(&self.start) }, method))
    }
}

/// Finds a method by its name.
fn method(name: &str) -> Result<&'static Method, Error> {
    method_named(name).ok_or_else(|| unknown("method", name, METHODS.iter().map(|method| method.name).collect()))
}

/// Finds a projection by its name.
fn projection(name: &str) -> Result<Projection, Error> {
    let names = || Projection::ALL.iter().map(|(name, _)| *name).collect();
    Projection::named(name).ok_or_else(|| unknown("projection", name, names()))
}

fn unknown(what: &str, name: &str, known: Vec<&'static str>) -> Error {
    let help = suggestion(name, known.iter().copied(), || format!("{what}s: {}", known.join(", ")));
    Error::usage(format!("there is no {what} `{name}`")).help(help)
}
