//! The end of a motion at an event, with its derivatives.

use num_dual::Dual64;
use qrm_core::{Dual, Scalar, TapeEvaluator};

use super::crossing::crossing;
use super::equations::{DualState, Moving, moving};
use super::error::SensitivityError;
use super::number::{Inner, Number};
use super::stepper::DualStepper;
use crate::event::location::locate;
use crate::event::{End, EventFunction, Reached};
use crate::integrate::Formula;
use crate::solve::Solver;
use crate::state::State;

/// The part of a step over which the rates of accelerations and multipliers are taken.
const SHIFT: f64 = 1e-4;

/// The event `g(t, q, qd, qdd, lambda, p)` that ends a motion, negative before.
pub(super) struct DualEvent<'a, T: Inner> {
    real: EventFunction<'a>,
    evaluator: TapeEvaluator<'a, Vec<Number<T>>>,
    /// The function with derivatives by time.
    moving: TapeEvaluator<'a, Vec<Moving>>,
}

impl<'a, T: Inner> DualEvent<'a, T> {
    /// The event, with the parameters of the equations; `None` if the motion ends at a time.
    pub(super) fn new(stepper: &DualStepper<'a, T>, end: Option<End<'a>>) -> Option<Self> {
        let equations = &stepper.equations;
        let tape = match end {
            Some(End::Event(tape)) => tape,
            _ => equations.evaluator.tape(),
        };
        let mut evaluator = TapeEvaluator::new(tape);
        evaluator.set_parameters(|i| Some(equations.evaluator.parameters()[i]));
        let moving = TapeEvaluator::with_parameters(tape, equations.mechanism.parameters());
        Some(Self { real: EventFunction::new(equations.mechanism, end)?, evaluator, moving })
    }

    /// The value at a state; `None` if the scene has no event.
    pub(super) fn value(&mut self, at: &DualState<T>) -> Option<Number<T>> {
        self.evaluator.event(at.t, &at.q, &at.qd, &at.qdd, &at.multipliers)
    }

    /// The state at the first event in the step to `to`, with the derivatives of its time; `None` if there is none.
    ///
    /// # Errors
    /// `g` does not cross zero, or a step cannot be made.
    pub(super) fn locate_first(
        &mut self,
        stepper: &mut DualStepper<T>,
        formula: Formula,
        [from, to]: [&DualState<T>; 2],
    ) -> Result<Option<DualState<T>>, SensitivityError> {
        let mechanism = stepper.equations.mechanism;
        let (begin, end) = (from.real(), to.real());
        let mut step = |t: f64| stepper.advance(formula, from, Number::from_f64(t)).map(|at| at.real());
        let reached = self.real.first_inside(mechanism, [&begin, &end], &mut |t| step(t).ok());
        let inside = match reached {
            Some(Reached::Crossed(inside)) => Some(inside),
            Some(Reached::Touched(State { t, .. }, _) | Reached::Undefined(t) | Reached::Undecided([t, _])) => {
                return Err(SensitivityError::GrazingEvent { t });
            }
            None => None,
        };
        let mut value = |at: &State| self.real.value(mechanism, at).unwrap_or(f64::NAN);
        let Some(beyond) = inside.into_iter().chain([end]).find(|at| value(at) >= 0.0) else { return Ok(None) };
        let at = locate(&begin, &beyond, &mut value, &mut step)?;
        let by_time = self.by_time(stepper, &at, SHIFT * (beyond.t - begin.t));
        if !(by_time > 0.0) {
            return Err(SensitivityError::GrazingEvent { t: at.t });
        }
        let state = crossing((at.t, by_time, stepper.equations.parts), |t| {
            let at = stepper.advance(formula, from, t)?;
            let value = self.value(&at).unwrap_or_else(Number::zero);
            Ok((at, value))
        })?;
        Ok(Some(state))
    }

    /// The derivative of its value by time along the motion. Those of accelerations and multipliers are differences of
    /// their values at times `h` before and after.
    fn by_time(&mut self, stepper: &DualStepper<T>, at: &State, h: f64) -> f64 {
        let mechanism = stepper.equations.mechanism;
        let (n, m) = (at.qdd.len(), at.multipliers.len());
        let mut rates = [vec![0.0; n], vec![0.0; m]];
        if self.real.takes_forces() {
            let mut solver = Solver::new(mechanism);
            for (h, weight) in [(-h, -0.5 / h), (h, 0.5 / h)] {
                let mut near = at.moved_along(h);
                // Where they are not determined, the event has no derivative.
                if solver.complete(mechanism, &mut near).is_err() {
                    return f64::NAN;
                }
                for (rates, values) in rates.iter_mut().zip([&near.qdd, &near.multipliers]) {
                    rates.iter_mut().zip(values).for_each(|(rate, value)| *rate += weight * value);
                }
            }
        }
        let (t, q, qd) = moving(at);
        let along = |(x, rate): (&f64, &f64)| Dual(Dual64::new(*x, *rate));
        let qdd: Vec<Moving> = at.qdd.iter().zip(&rates[0]).map(along).collect();
        let multipliers: Vec<Moving> = at.multipliers.iter().zip(&rates[1]).map(along).collect();
        self.moving.event(t, &q, &qd, &qdd, &multipliers).map_or(0.0, |value| value.0.eps)
    }
}
