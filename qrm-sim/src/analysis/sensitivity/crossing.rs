//! The state at a time that depends on the parameters, because a function is zero there.

use qrm_core::Scalar;

use super::equations::DualState;
use super::error::SensitivityError;
use super::number::{Inner, Number, Place, has_derivatives};

/// The state near the time `t` at which a function keeps its value while parameters change: `dt/dp = -(dg/dp) /
/// (dg/dt)`.
///
/// `at` makes the state at a time, and the value of the function there; `by_time` is `dg/dt` along the motion.
///
/// # Errors
/// A state cannot be made, or the function has no derivative.
pub(super) fn crossing<T: Inner>(
    (t, by_time, parts): (f64, f64, usize),
    mut at: impl FnMut(Number<T>) -> Result<(DualState<T>, Number<T>), SensitivityError>,
) -> Result<DualState<T>, SensitivityError> {
    let mut time = Number::from_f64(t);
    // One pass more than the order: the method's own derivative by time differs from that of the motion.
    for _ in 0..=T::ORDER {
        let (_, value) = at(time)?;
        if !has_derivatives(&value) {
            return Err(SensitivityError::NotSmooth { t });
        }
        Place::all::<T>(parts).for_each(|place| place.add(&mut time, -place.get(&value) / by_time));
    }
    at(time).map(|(state, _)| state)
}
