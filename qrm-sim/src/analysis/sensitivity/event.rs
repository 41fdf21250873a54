//! The stop condition on dual numbers.

use num_dual::Dual64;
use qrm_core::{Dual, Mechanism, Scalar};

use super::saddle::Number;
use super::step::{DualState, DualStepper, duals, real};
use super::{SensitivityEnd, SensitivityError};
use crate::run::locate;
use crate::state::State;

/// The stop condition `g(t, q, qd, p)` of a motion, negative before it becomes true.
pub(super) struct Condition<'a> {
    pub(super) parameter: &'a str,
    pub(super) end: Option<&'a SensitivityEnd<'a>>,
}

impl Condition<'_> {
    /// Its value, if there is a stop condition.
    pub(super) fn value(&self, stepper: &mut DualStepper, at: &DualState) -> Option<Dual64> {
        match self.end {
            Some(SensitivityEnd::Time(_)) => None,
            Some(SensitivityEnd::Condition(condition)) => {
                Some(condition(self.parameter, at.t.0, &duals(&at.q), &duals(&at.qd)))
            }
            None => stepper.evaluator.event(at.t, &at.q, &at.qd).map(|value| value.0),
        }
    }

    /// The state at the event in the step to `beyond`, with the derivative of its time, `dt/dp = -(dg/dp) / (dg/dt)`.
    ///
    /// # Errors
    /// `g` does not cross zero, or a step cannot be made.
    pub(super) fn locate(
        &self,
        stepper: &mut DualStepper,
        from: &DualState,
        beyond: &DualState,
    ) -> Result<DualState, SensitivityError> {
        let mechanism = stepper.mechanism;
        let step = |t: f64| stepper.step(from, Number::from_f64(t)).map(|at| real(&at));
        let t = locate(&real(from), &real(beyond), |at| self.real_value(mechanism, at), step)?.t;
        let mut derivative = |t: Number| {
            let at = stepper.step(from, t)?;
            Ok(self.value(stepper, &at).map_or(0.0, |value| value.eps))
        };
        let by_parameter = derivative(Number::from_f64(t))?;
        let by_time = derivative(Dual(Dual64::new(t, 1.0)))? - by_parameter;
        if !by_parameter.is_finite() {
            return Err(SensitivityError::NotSmooth { t });
        }
        if !(by_time > 0.0) {
            return Err(SensitivityError::GrazingEvent { t });
        }
        stepper.step(from, Dual(Dual64::new(t, -by_parameter / by_time)))
    }

    fn real_value(&self, mechanism: &dyn Mechanism, at: &State) -> f64 {
        let Some(SensitivityEnd::Condition(condition)) = self.end else {
            return mechanism.event(at.t, &at.q, &at.qd).unwrap_or(0.0);
        };
        let constants = |x: &[f64]| x.iter().map(|x| Dual64::from(*x)).collect::<Vec<_>>();
        condition(self.parameter, Dual64::from(at.t), &constants(&at.q), &constants(&at.qd)).re
    }
}
