//! A request for a run.

use super::outcome::StartError;
use crate::event::End;
use crate::integrate::MethodSettings;
use crate::position::Start;

/// A request for a run.
#[derive(Default)]
pub struct Request<'a> {
    /// The method.
    pub settings: MethodSettings,
    /// The start; the scene's if `None`.
    pub start: Option<Start>,
    /// Another start, by which the first one may be wrong: errors contain what that changes.
    #[cfg(feature = "events")]
    pub other_start: Option<Start>,
    /// The values of the scene's own parameters, which define the branch of the start; those of the model if `None`.
    pub scene_parameters: Option<Vec<f64>>,
    /// Length of the steps, or the time between rows of a method that chooses its steps; the scene's if `None`.
    pub step: Option<f64>,
    /// The end; the scene's if `None`.
    pub end: Option<End<'a>>,
    /// Whether a long run stays in one thread even with a companion run.
    pub is_single_threaded: bool,
    /// Whether a companion run estimates the error.
    pub estimate_error: bool,
}

/// Returns an error if the step is below the resolution of time.
pub(crate) fn check_step(step: f64, end_time: f64) -> Result<(), StartError> {
    if step > end_time * f64::EPSILON { Ok(()) } else { Err(StartError::StepTooShort { step, end_time }) }
}
