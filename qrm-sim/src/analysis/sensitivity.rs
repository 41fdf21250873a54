//! Derivatives of a motion by the parameters of its mechanism (forward sensitivity analysis).

mod by_start;
mod collocation;
mod columns;
mod crossing;
mod dual_run;
mod equations;
mod error;
mod event;
mod explicit;
mod mesh;
mod number;
mod result;
mod rosenbrock;
mod saddle;
mod slope;
mod start;
mod stepper;
#[cfg(test)]
mod tests;
mod values;

pub(super) use by_start::{EndByStart, MotionByStart, end_by_start};
pub use error::SensitivityError;
pub use result::{DerivativeErrors, Derivatives, OutputValues, Sensitivity};

use num_dual::Dual64;
use qrm_core::{Mechanism, Model, ParameterOverrides, Tape};

use crate::event::End;
use crate::integrate::MethodSettings;
use dual_run::DualRun;
use number::{Inner, PARTS};

/// Derivatives of the end of a motion, and of its outputs, by parameters at the values that `replace` gives them.
///
/// The steps of an ordinary run by any method are made again on dual numbers, by the same formula, for up to eight
/// parameters `p` at once (internal numerical differentiation); they end at rows too. With `qdd` and `lambda` known,
/// their derivatives follow from those of the equations of motion:
///
/// ```text
/// | Mbar  C_q' | | dqdd/dp    |     | d(Mbar qdd + C_q' lambda - fbar)/dp |
/// | C_q   0    | | dlambda/dp | = - | d(C_q qdd + bias)/dp               |
/// ```
///
/// On the right `qdd` and `lambda` are held, and `q` and `qd` change with `p`. The derivatives are those of the
/// numerical solution. From those of the exact motion they differ by the error of the method, which is estimated by
/// steps half as long.
///
/// At an event `g(t, q, qd, p) = 0` the end time moves by `dt/dp = -(dg/dp) / (dg/dt)`, and the derivatives are those
/// at the moving end. So does the time of a corner or jump of the equations of motion: the derivatives of the state
/// jump there by `(f- - f+) dt/dp`.
///
/// ```
/// # use qrm_core::Model;
/// # use qrm_sim::analysis::{SensitivityError, SensitivityRequest, sensitivity};
/// # use qrm_sim::integrate::{DOP853, MethodSettings};
/// # fn by(model: &Model) -> Result<(), SensitivityError> {
/// let settings = MethodSettings::new(DOP853, 1e-10);
/// let request = SensitivityRequest { by: &["k", "c"], settings, ..SensitivityRequest::default() };
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
    replace: ParameterOverrides,
    request: &SensitivityRequest,
) -> Result<Sensitivity, SensitivityError> {
    derived(&*model.mechanism(replace), model.tape(), replace, request)
}

fn derived(
    mechanism: &dyn Mechanism,
    tape: &Tape,
    replace: ParameterOverrides,
    request: &SensitivityRequest,
) -> Result<Sensitivity, SensitivityError> {
    if request.by.is_empty() {
        return values::values(mechanism, request);
    }
    let of_steps = if request.direction.is_empty() { motions::<f64> } else { motions::<Dual64> };
    let (mut found, steps) = of_steps(mechanism, tape, replace, request, false)?;
    if request.estimate_errors {
        let (mut accurate, _) = of_steps(mechanism, tape, replace, request, true)?;
        let ratio = if mechanism.description().has_corners { RATIO_AT_CORNERS } else { 1.0 };
        found.estimate_errors(&mut accurate, ratio, steps);
    }
    Ok(found)
}

/// The ratio of errors to differences from steps half as long, where loads have corners. Both errors depend on where
/// steps meet one, and may agree by chance.
const RATIO_AT_CORNERS: f64 = 3.0;

/// The derivatives by all parameters, eight at once, and the number of steps of a motion.
fn motions<T: Inner>(
    mechanism: &dyn Mechanism,
    tape: &Tape,
    replace: ParameterOverrides,
    request: &SensitivityRequest,
    is_halved: bool,
) -> Result<(Sensitivity, u64), SensitivityError> {
    let (mut all, mut steps) = (Sensitivity::default(), 0);
    for parameters in request.by.chunks(PARTS) {
        let motion = DualRun::<T>::new(mechanism, tape, replace, parameters, request, is_halved)?.run()?;
        steps = motion.steps;
        all.push(motion, parameters.len());
    }
    Ok((all, steps))
}

/// The derivatives to compute.
#[derive(Default)]
pub struct SensitivityRequest<'a> {
    /// The names of the parameters; without any, values alone are found, in a fraction of the time.
    pub by: &'a [&'a str],
    /// The method, of which the derivatives are those of its steps.
    pub settings: MethodSettings,
    /// The step, or the time between rows of a method that chooses its steps, in s; the scene's if `None`.
    pub step: Option<f64>,
    /// The end; the scene's if `None`.
    pub end: Option<End<'a>>,
    /// The numbers of the outputs that are asked for, all if `None`; extremes and integrals of others are those of rows.
    pub outputs: Option<&'a [usize]>,
    /// A direction by names of parameters, others being zero: the products of Hessians with it are computed too.
    pub direction: &'a [(&'a str, f64)],
    /// Whether errors are estimated, by another motion with steps half as long.
    pub estimate_errors: bool,
    /// Asked after some steps, with the time and the latest end of the motion under way; nothing more is computed where
    /// it says false.
    pub keep_running: Option<&'a dyn Fn(f64, f64) -> bool>,
}

impl SensitivityRequest<'_> {
    /// The number of motions that give the derivatives by so many parameters.
    pub fn motions(parameters: usize) -> usize {
        parameters.div_ceil(PARTS).max(1)
    }
}
