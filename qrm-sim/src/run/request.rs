//! A run to make.

use super::outcome::StartError;
use crate::event::End;
use crate::integrate::MethodSettings;
use crate::position::Start;

/// A run to make.
#[derive(Default)]
pub struct Request<'a> {
    /// The method.
    pub settings: MethodSettings,
    /// The start; the scene's if `None`.
    pub start: Option<Start>,
    /// The scene's own values of the parameters, whose branch the start is on; those of the model if `None`.
    pub scene_parameters: Option<Vec<f64>>,
    /// Length of the steps, or the time between rows of a method that chooses its steps; the scene's if `None`.
    pub step: Option<f64>,
    /// The end; the scene's if `None`.
    pub end: Option<End<'a>>,
    /// Whether a long run stays in one thread, though a companion run estimates its error.
    pub is_single_threaded: bool,
    /// Whether a companion run estimates the error.
    pub estimate_error: bool,
}

/// An error for a step so short that time would stand still.
pub(crate) fn check_step(step: f64, end_time: f64) -> Result<(), StartError> {
    if step > end_time * f64::EPSILON { Ok(()) } else { Err(StartError::StepTooShort { step, end_time }) }
}
