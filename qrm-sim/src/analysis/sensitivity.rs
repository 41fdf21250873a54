//! Derivatives of a motion by the parameters of its mechanism (forward sensitivity analysis).

mod dual_run;
mod event;
mod number;
mod result;
mod saddle;
mod step;
#[cfg(test)]
mod tests;
mod values;

pub use result::{Derivatives, OutputValues, Sensitivity};

use num_dual::Dual64;
use qrm_core::{Model, Replace};

use crate::integrate::StepError;
use crate::run::StartError;
use dual_run::DualRun;
use number::PARTS;

/// Derivatives of the end of a motion, and of its outputs, by parameters at the values that `replace` gives them.
///
/// The motion is computed for up to eight parameters `p` at once, on dual numbers, by the classical Runge-Kutta method
/// with a fixed step and the projection in the mass metric after each step. With `qdd` and `lambda` known, their
/// derivatives follow from those of the equations of motion:
///
/// ```text
/// | Mbar  C_q' | | dqdd/dp    |     | d(Mbar qdd + C_q' lambda - fbar)/dp |
/// | C_q   0    | | dlambda/dp | = - | d(C_q qdd + bias)/dp               |
/// ```
///
/// On the right `qdd` and `lambda` are held, and `q` and `qd` change with `p`. The derivatives are those of the
/// numerical solution. From those of the exact motion they differ by the error of the method, of order 4 in the step.
///
/// At an event `g(t, q, qd, p) = 0` the end time moves by `dt/dp = -(dg/dp) / (dg/dt)`, and the derivatives are those
/// at the moving end.
///
/// ```
/// # use qrm_core::Model;
/// # use qrm_sim::analysis::{SensitivityError, SensitivityRequest, sensitivity};
/// # fn by(model: &Model) -> Result<(), SensitivityError> {
/// let request = SensitivityRequest { by: &["k", "c"], step: None, end: None, goes_on: None };
/// let found = sensitivity(model, &|_| None, &request)?;
/// let [largest, _] = &found.outputs[0].maximum;
/// println!("the largest output {} and its derivatives {:?}", largest.value, largest.by);
/// # Ok(())
/// # }
/// ```
///
/// # Errors
/// A name is unknown, the motion does not come to its end, or it has no derivative there: see [`SensitivityError`].
pub fn sensitivity(
    model: &Model,
    replace: Replace,
    request: &SensitivityRequest,
) -> Result<Sensitivity, SensitivityError> {
    let mechanism = model.mechanism(replace);
    if request.by.is_empty() {
        return values::values(&*mechanism, request);
    }
    let mut all = Sensitivity::default();
    for parameters in request.by.chunks(PARTS) {
        let motion = DualRun::new(&*mechanism, model.tape, replace, parameters, request)?.run()?;
        all.push(motion, parameters.len());
    }
    Ok(all)
}

/// The derivatives to compute.
pub struct SensitivityRequest<'a> {
    /// The names of the parameters; without any, values alone are found, in a fraction of the time.
    pub by: &'a [&'a str],
    /// The step, in s; the scene's if `None`.
    pub step: Option<f64>,
    /// The end; the scene's if `None`.
    pub end: Option<SensitivityEnd<'a>>,
    /// Asked after some steps, with the time and the latest end of the motion under way; nothing more is computed where
    /// it says false.
    pub goes_on: Option<&'a dyn Fn(f64, f64) -> bool>,
}

impl SensitivityRequest<'_> {
    /// The number of motions that give the derivatives by so many parameters.
    pub fn motions(parameters: usize) -> usize {
        parameters.div_ceil(PARTS).max(1)
    }
}

/// The end of the motion.
pub enum SensitivityEnd<'a> {
    /// At a time, in s, whatever the parameters are.
    Time(f64),
    /// When a function rises through zero.
    Condition(&'a DualCondition<'a>),
}

/// A function of the parameter's name, time, coordinates and rates, with its derivative by that parameter. It is called
/// for one parameter after another, and without a name where the value alone is needed.
///
/// The arguments carry their own derivatives. Where the function depends on the parameter itself, it has to add that
/// part.
pub type DualCondition<'a> = dyn Fn(&str, Dual64, &[Dual64], &[Dual64]) -> Dual64 + 'a;

/// Why there are no derivatives.
#[derive(Clone, Debug, PartialEq)]
pub enum SensitivityError {
    /// The motion cannot begin.
    Start(StartError),
    /// A step could not be made.
    Step {
        /// The time at its beginning.
        t: f64,
        /// The reason.
        error: StepError,
    },
    /// The constraint Jacobian loses rank, or nearly so, in the step after this time. The motion is continued there by
    /// means that have no derivatives.
    Singular {
        /// The time at the beginning of the step.
        t: f64,
    },
    /// At or after this time some formula has no finite value, or no finite derivative, as a root at zero.
    NotSmooth {
        /// The time.
        t: f64,
    },
    /// The stop condition did not become true.
    EventNotReached {
        /// The latest end.
        end_time: f64,
    },
    /// The condition touches zero without crossing it: a small change of a parameter may move the end far.
    GrazingEvent {
        /// The time.
        t: f64,
    },
    /// The caller wanted no more.
    Interrupted {
        /// The time of the motion under way.
        t: f64,
    },
    /// There is no parameter of this name.
    NoParameter {
        /// The name.
        name: String,
    },
}
