//! Reference states: a motion in numbers of 32 digits.

mod elimination;
mod equations;
mod extrapolation;

use qrm_core::{DoubleDouble, Model, Replace, Scalar};

use self::equations::Equations;
use self::extrapolation::{ORDER, extrapolated};
use super::measure::StateAt;
use crate::integrate::StepError;
use crate::run::StartError;

/// The states of a motion at times that rise, followed in double-double numbers with relative errors of about
/// `tolerance` in each step, and rounded to doubles at the end.
///
/// Parameters have the doubles that a simulation has too; coordinates and rates at the start that the scene gives have
/// all digits of its formulae. Steps are those of the extrapolated midpoint rule, after each of which coordinates and
/// rates are projected onto the constraints in the mass metric. Tolerances below 1e-26 drown in rounding errors.
///
/// # Errors
/// The constraints cannot be met at the start; the accelerations are not determined, also where constraints depend on
/// each other; or it would take more than some 2e7 operations, about half a second, as it does with stiff motions and
/// with loads that jump.
pub fn reference_states(
    model: &Model,
    replace: Replace,
    times: &[f64],
    tolerance: f64,
) -> Result<Vec<StateAt>, StartError> {
    let mechanism = model.mechanism(replace);
    let mut equations = Equations::new(model.tape, mechanism.parameters());
    let start = equations.start(&*mechanism).map_err(StartError::NotAssembled)?;
    let step = equations.evaluator.schedule().step.to_f64();
    let states = Motion::new(equations, start, step, tolerance).and_then(|mut motion| motion.visit(times));
    states.map_err(StartError::Step)
}

/// A number of 32 digits.
type Number = DoubleDouble;

/// The least factor between the lengths of consecutive steps, and the largest one.
const FACTORS: [f64; 2] = [0.1, 4.0];
/// What a step is made shorter for the next one to be accepted.
const SAFETY: f64 = 0.9;
/// Time stands still where steps are as short as this against it.
const SHORTEST: f64 = 1e-29;

/// A motion that is being followed.
struct Motion<'t> {
    equations: Equations<'t>,
    tolerance: f64,
    /// Number of attempted steps.
    attempts: u64,
    /// Length of the next step.
    h: f64,
    t: Number,
    /// Coordinates, then rates.
    y: Vec<Number>,
    /// Their derivative by time.
    slope: Vec<Number>,
}

impl<'t> Motion<'t> {
    /// A motion at its start, with the length of the first step to try.
    ///
    /// # Errors
    /// The accelerations are not determined there.
    fn new(mut equations: Equations<'t>, y: Vec<Number>, h: f64, tolerance: f64) -> Result<Self, StepError> {
        let (t, mut slope) = (Number::zero(), y.clone());
        equations.slope(t, &y, &mut slope)?;
        Ok(Self { equations, tolerance, attempts: 0, h, t, y, slope })
    }

    /// The states at times that rise.
    fn visit(&mut self, times: &[f64]) -> Result<Vec<StateAt>, StepError> {
        let state = |&t: &f64| {
            self.advance_to(t.into())?;
            self.equations.described(self.t, &self.y)
        };
        times.iter().map(state).collect()
    }

    fn advance_to(&mut self, t: Number) -> Result<(), StepError> {
        while self.t < t {
            let left = t - self.t;
            // Two even steps to the end are better than a long and a very short one.
            let h = if !(self.h < left.to_f64()) {
                left
            } else if self.h > 0.5 * left.to_f64() {
                (0.5 * left.to_f64()).into()
            } else {
                self.h.into()
            };
            let end = if h == left { t } else { self.t + h };
            self.attempt(h, end)?;
        }
        Ok(())
    }

    /// Tries one step, and chooses the length of the next one.
    ///
    /// # Errors
    /// Steps became too short or too many, or an accepted one leads to where the accelerations are not determined.
    fn attempt(&mut self, step: Number, end: Number) -> Result<(), StepError> {
        let h = step.to_f64();
        self.attempts += 1;
        if self.equations.is_spent() {
            return Err(StepError::TooManySteps { attempts: self.attempts, h });
        }
        if !(h > SHORTEST * self.t.to_f64()) {
            return Err(StepError::StepTooShort { h });
        }
        let Self { equations, t, y, slope, .. } = self;
        let made = extrapolated(&mut |t, y, slope| equations.slope(t, y, slope), (*t, y, slope), step);
        // A step that leaves the domain of a formula is too long.
        let (next, error) = made.unwrap_or((Vec::new(), f64::INFINITY));
        let factor = SAFETY * (self.tolerance / error).powf(1.0 / ORDER);
        let proposed = h * if factor.is_nan() { FACTORS[0] } else { factor.clamp(FACTORS[0], FACTORS[1]) };
        if !(error <= self.tolerance) {
            self.h = proposed.min(SAFETY * h);
            return Ok(());
        }
        // A step that is short for the sake of its end says little of the next one.
        self.h = if h < self.h { proposed.max(self.h) } else { proposed };
        (self.t, self.y) = (end, next);
        self.equations.project(end, &mut self.y)?;
        self.equations.slope(end, &self.y, &mut self.slope)
    }
}

#[cfg(test)]
mod tests;
