//! The end of a motion at an event, with its derivatives.

use num_dual::HyperDual64;
use qrm_core::Scalar;

use super::crossing::crossing;
use super::equations::{DualState, Moving, moving};
use super::number::{Inner, Number, PARTS, number, of_part};
use super::stepper::DualStepper;
use super::{DualCondition, SensitivityEnd, SensitivityError};
use crate::integrate::Formula;
use crate::root_finding::locate;
use crate::state::State;

/// The stop condition `g(t, q, qd, p)` of a motion, negative before it becomes true.
pub(super) struct Condition<'a> {
    pub(super) parameters: &'a [&'a str],
    pub(super) end: Option<&'a SensitivityEnd<'a>>,
}

impl Condition<'_> {
    /// The value of the stop condition at a state; `None` if there is no condition.
    pub(super) fn value<T: Inner>(&self, stepper: &mut DualStepper<T>, at: &DualState<T>) -> Option<Number<T>> {
        match self.end {
            Some(SensitivityEnd::Time(_)) => None,
            Some(SensitivityEnd::Condition(condition)) => {
                let mut value = T::from(0.0);
                let mut by = [value; PARTS];
                for (part, parameter) in self.parameters.iter().enumerate() {
                    let all = |numbers: &[Number<T>]| numbers.iter().map(|x| of_part(x, part)).collect::<Vec<_>>();
                    let found = condition(parameter, of_part(&at.t, part), &all(&at.q), &all(&at.qd));
                    value = T::new(found.re, found.eps2);
                    by[part] = T::new(found.eps1, found.eps1eps2);
                }
                Some(number(value, by))
            }
            None => stepper.equations.evaluator.event(at.t, &at.q, &at.qd),
        }
    }

    /// The state at the event in the step to `beyond`, with the derivatives of its time.
    ///
    /// # Errors
    /// `g` does not cross zero, or a step cannot be made.
    pub(super) fn locate<T: Inner>(
        &self,
        stepper: &mut DualStepper<T>,
        formula: Formula,
        [from, beyond]: [&DualState<T>; 2],
    ) -> Result<DualState<T>, SensitivityError> {
        let mechanism = stepper.equations.mechanism;
        let value = |at: &State| match self.end {
            Some(SensitivityEnd::Condition(condition)) => value_alone(condition, at.t, &at.q, &at.qd),
            _ => mechanism.event(at.t, &at.q, &at.qd).unwrap_or(0.0),
        };
        let step = |t: f64| stepper.advance(formula, from, Number::from_f64(t)).map(|at| at.real());
        let at = locate(&from.real(), &beyond.real(), &mut { value }, &mut { step })?;
        let by_time = self.by_time(stepper, &at);
        if !(by_time > 0.0) {
            return Err(SensitivityError::GrazingEvent { t: at.t });
        }
        crossing((at.t, by_time, stepper.equations.parts), |t| {
            let at = stepper.advance(formula, from, t)?;
            let value = self.value(stepper, &at).unwrap_or_else(Number::zero);
            Ok((at, value))
        })
    }

    /// The derivative of its value by time along the motion.
    fn by_time<T: Inner>(&self, stepper: &mut DualStepper<T>, at: &State) -> f64 {
        match self.end {
            Some(SensitivityEnd::Condition(condition)) => {
                let (t, q, qd) = moving(at);
                let along = |x: &Moving| HyperDual64::new(x.0.re, x.0.eps, 0.0, 0.0);
                let all = |x: &[Moving]| x.iter().map(along).collect::<Vec<_>>();
                condition("", along(&t), &all(&q), &all(&qd)).eps1
            }
            _ => {
                let event = stepper.equations.along_motion(at, |moving, t, q, qd| moving.event(t, q, qd));
                event.map_or(0.0, |value| value.0.eps)
            }
        }
    }
}

/// The value of a condition without derivatives.
pub(super) fn value_alone(condition: &DualCondition, t: f64, q: &[f64], qd: &[f64]) -> f64 {
    let constants = |x: &[f64]| x.iter().map(|x| HyperDual64::from(*x)).collect::<Vec<_>>();
    condition("", HyperDual64::from(t), &constants(q), &constants(qd)).re
}
