//! Reference states: a motion in double-double precision, 32 digits.

mod corner;
mod equations;
mod extrapolation;

use qrm_core::{DoubleDouble, Model, ParameterOverrides, Scalar};

use self::extrapolation::{ORDER, extrapolated};
use super::measure::StateAt;
use crate::integrate::StepError;
use crate::run::StartError;
use crate::solve::{Number, PreciseEquations};

/// A state of a reference motion.
#[derive(Clone, Debug)]
pub struct ReferenceState {
    /// Coordinates, then rates, in all digits.
    pub digits: Vec<DoubleDouble>,
    /// The state with its accelerations, multipliers, outputs and checks, rounded to doubles.
    pub rounded: StateAt,
}

/// Computes the states of a motion at increasing times in double-double precision, with relative errors of about
/// `tolerance` in each step.
///
/// Parameters have the same double values as in a simulation; given coordinates and rates at the start have all digits
/// of the scene's formulae. Steps use the extrapolated midpoint rule; after each step coordinates and rates are
/// projected onto the constraints in the mass metric. Steps end at corners and jumps of the equations of motion; until
/// then they follow the smooth continuation from the beginning of the step. Tolerances below 1e-26 are lost in rounding
/// errors.
///
/// # Errors
/// The constraints cannot be satisfied at the start; the accelerations are not determined; or more than about 1e8
/// operations are needed, a few seconds, as for stiff motions and motions along a jump.
pub fn reference_states(
    model: &Model,
    replace: ParameterOverrides,
    times: &[f64],
    tolerance: f64,
) -> Result<Vec<ReferenceState>, StartError> {
    let mechanism = model.mechanism(replace);
    let parameters = mechanism.parameters();
    let all = (0..model.tape().constraints as usize).collect();
    let mut equations = PreciseEquations::new(model.tape(), parameters, all);
    let y = equations.start(&*mechanism).map_err(StartError::NotAssembled)?;
    let mut equations = equations.without_redundancy(&*mechanism, &y[..y.len() / 2]);
    let step = equations.evaluator.schedule().step.to_f64();
    follow(equations, parameters, y, step, (times, tolerance)).map_err(StartError::Step)
}

/// Follows the smooth parts of a motion one after another.
fn follow(
    mut equations: PreciseEquations,
    parameters: &[f64],
    y: Vec<Number>,
    step: f64,
    (times, tolerance): (&[f64], f64),
) -> Result<Vec<ReferenceState>, StepError> {
    let mut slope = y.clone();
    equations.slope(Number::zero(), &y, &mut slope)?;
    let mut at = At { t: Number::zero(), y, slope, h: step };
    let mut states = Vec::with_capacity(times.len());
    loop {
        let tape = equations.smooth_from(&at);
        let mut part = PreciseEquations::new(&tape, parameters, equations.independent().to_vec());
        part.operations = equations.operations;
        let mut motion = Motion::new(part, at, tolerance)?;
        motion.run_to_times(times, &mut states)?;
        if states.len() == times.len() {
            return Ok(states);
        }
        (at, equations.operations) = (motion.at, motion.equations.operations);
    }
}

/// The smallest and the largest ratio of consecutive step lengths.
const FACTORS: [f64; 2] = [0.1, 4.0];
/// The safety factor in the choice of the step length.
const SAFETY: f64 = 0.9;
/// The smallest step length relative to the time.
const SHORTEST: f64 = 1e-29;

/// The current state of a motion.
#[derive(Clone)]
struct At {
    t: Number,
    /// Coordinates, then rates.
    y: Vec<Number>,
    /// The derivative of `y` with respect to time.
    slope: Vec<Number>,
    /// Length of the next step.
    h: f64,
}

/// A smooth part of a motion.
struct Motion<'t> {
    equations: PreciseEquations<'t>,
    tolerance: f64,
    /// Number of attempted steps.
    attempts: u64,
    at: At,
    /// The signs of the switching functions in this part.
    signs: Vec<f64>,
}

impl<'t> Motion<'t> {
    /// Starts a part.
    ///
    /// # Errors
    /// The accelerations are not determined there.
    fn new(mut equations: PreciseEquations<'t>, mut at: At, tolerance: f64) -> Result<Self, StepError> {
        equations.slope(at.t, &at.y, &mut at.slope)?;
        let signs = equations.signs_from(&at);
        Ok(Self { equations, tolerance, attempts: 0, at, signs })
    }

    /// Adds states at the remaining times, up to the end of this part.
    fn run_to_times(&mut self, times: &[f64], states: &mut Vec<ReferenceState>) -> Result<(), StepError> {
        for &t in &times[states.len()..] {
            if self.advance_to(t.into())? {
                return Ok(());
            }
            let rounded = self.equations.described(self.at.t, &self.at.y)?;
            states.push(ReferenceState { digits: self.at.y.clone(), rounded });
        }
        Ok(())
    }

    /// Advances to a time; returns true if this part of the motion ends before.
    fn advance_to(&mut self, t: Number) -> Result<bool, StepError> {
        while self.at.t < t {
            let left = t - self.at.t;
            // Two equal steps to the end are better than a long and a very short one.
            let h = if !(self.at.h < left.to_f64()) {
                left
            } else if self.at.h > 0.5 * left.to_f64() {
                (0.5 * left.to_f64()).into()
            } else {
                self.at.h.into()
            };
            let end = if h == left { t } else { self.at.t + h };
            if self.attempt(h, end)? {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// Attempts one step, and chooses the length of the next one; returns true if the step ended at a corner.
    ///
    /// # Errors
    /// Steps became too short or too many, or the accelerations are not determined after an accepted step.
    fn attempt(&mut self, step: Number, end: Number) -> Result<bool, StepError> {
        let h = step.to_f64();
        self.attempts += 1;
        if self.equations.is_spent() {
            return Err(StepError::TooManySteps { attempts: self.attempts, h });
        }
        if !(h > SHORTEST * self.at.t.to_f64()) {
            return Err(StepError::StepTooShort { h });
        }
        // A step that leaves the domain of a formula is too long.
        let (next, error) = self.extrapolated(step).unwrap_or((Vec::new(), f64::INFINITY));
        let factor = SAFETY * (self.tolerance / error).powf(1.0 / ORDER);
        let proposed = h * if factor.is_nan() { FACTORS[0] } else { factor.clamp(FACTORS[0], FACTORS[1]) };
        if !(error <= self.tolerance) {
            self.at.h = proposed.min(SAFETY * h);
            return Ok(false);
        }
        // A step that was shortened to end there says little about the next one.
        self.at.h = if h < self.at.h { proposed.max(self.at.h) } else { proposed };
        let corner = self.first_corner(step, &next)?;
        let is_corner = corner.is_some();
        (self.at.t, self.at.y) = corner.unwrap_or((end, next));
        self.equations.project(self.at.t, &mut self.at.y)?;
        self.equations.slope(self.at.t, &self.at.y, &mut self.at.slope)?;
        Ok(is_corner)
    }

    /// The state after a step from here, and its error estimate.
    ///
    /// # Errors
    /// A slope has no value.
    fn extrapolated(&mut self, h: Number) -> Result<(Vec<Number>, f64), StepError> {
        let Self { equations, at: At { t, y, slope, .. }, .. } = self;
        extrapolated(&mut |t, y, slope| equations.slope(t, y, slope), (*t, y, slope), h)
    }
}

#[cfg(test)]
mod tests;
