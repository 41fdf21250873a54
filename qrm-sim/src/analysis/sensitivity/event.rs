//! The end of a motion at an event, with its derivatives.

use num_dual::Dual64;
use qrm_core::{Mechanism, Scalar};

use super::number::{Number, PARTS, derivatives, has_derivatives, number, of_part, of_parts};
use super::step::{DualState, DualStepper, real};
use super::{DualCondition, SensitivityEnd, SensitivityError};
use crate::event::locate;
use crate::state::State;

/// The stop condition `g(t, q, qd, p)` of a motion, negative before it becomes true.
pub(super) struct Condition<'a> {
    pub(super) parameters: &'a [&'a str],
    pub(super) end: Option<&'a SensitivityEnd<'a>>,
}

impl Condition<'_> {
    /// Its value, if there is a stop condition.
    pub(super) fn value(&self, stepper: &mut DualStepper, at: &DualState) -> Option<Number> {
        match self.end {
            Some(SensitivityEnd::Time(_)) => None,
            Some(SensitivityEnd::Condition(condition)) => {
                let mut value = 0.0;
                let mut by = [0.0; PARTS];
                for (part, parameter) in self.parameters.iter().enumerate() {
                    let t = of_part(&at.t, part);
                    let found = condition(parameter, t, &of_parts(&at.q, part), &of_parts(&at.qd, part));
                    (value, by[part]) = (found.re, found.eps);
                }
                Some(number(value, by))
            }
            None => stepper.evaluator.event(at.t, &at.q, &at.qd),
        }
    }

    /// The state at the event in the step to `beyond`, with the derivatives of its time, `dt/dp = -(dg/dp) / (dg/dt)`.
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
        let mut value = |t: Number| -> Result<Number, SensitivityError> {
            let at = stepper.step(from, t)?;
            Ok(self.value(stepper, &at).unwrap_or_else(Number::zero))
        };
        let fixed = value(Number::from_f64(t))?;
        if !has_derivatives(&fixed) {
            return Err(SensitivityError::NotSmooth { t });
        }
        let by_parameter = derivatives(&fixed);
        // The derivative by time comes on top of that by a parameter: the smallest one leaves it the most digits.
        let used = 0..self.parameters.len();
        let smallest = |a: &usize, b: &usize| by_parameter[*a].abs().total_cmp(&by_parameter[*b].abs());
        let part = used.min_by(smallest).unwrap_or(0);
        let moving = value(number(t, std::array::from_fn(|other| if other == part { 1.0 } else { 0.0 })))?;
        let by_time = derivatives(&moving)[part] - by_parameter[part];
        if !(by_time > 0.0) {
            return Err(SensitivityError::GrazingEvent { t });
        }
        stepper.step(from, number(t, by_parameter.map(|by| -by / by_time)))
    }

    fn real_value(&self, mechanism: &dyn Mechanism, at: &State) -> f64 {
        match self.end {
            Some(SensitivityEnd::Condition(condition)) => value_alone(condition, at.t, &at.q, &at.qd),
            _ => mechanism.event(at.t, &at.q, &at.qd).unwrap_or(0.0),
        }
    }
}

/// The value of a condition without derivatives.
pub(super) fn value_alone(condition: &DualCondition, t: f64, q: &[f64], qd: &[f64]) -> f64 {
    let constants = |x: &[f64]| x.iter().map(|x| Dual64::from(*x)).collect::<Vec<_>>();
    condition("", Dual64::from(t), &constants(q), &constants(qd)).re
}
