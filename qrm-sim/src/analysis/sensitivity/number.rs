//! Numbers with their derivatives by several parameters.

use num_dual::{Derivative, Dual64, DualSVec64};
use qrm_core::Dual;

/// The number of parameters whose derivatives are computed together.
pub(super) const PARTS: usize = 8;

/// A value with its derivatives.
pub(super) type Derived = DualSVec64<PARTS>;

/// A value with its derivatives, as the scalar that a tape is evaluated on.
pub(super) type Number = Dual<Derived>;

/// A number by its value and derivatives.
#[inline]
pub(super) fn number(value: f64, derivatives: [f64; PARTS]) -> Number {
    Dual(Derived::new(value, Derivative::some(derivatives.into())))
}

/// The derivatives of a number.
#[inline]
pub(super) fn derivatives(number: &Number) -> [f64; PARTS] {
    number.0.eps.0.map_or([0.0; PARTS], Into::into)
}

/// A number with its derivative by one of the parameters.
pub(super) fn of_part(number: &Number, place: usize) -> Dual64 {
    Dual64::new(number.0.re, derivatives(number)[place])
}

/// Numbers with their derivatives by one of the parameters.
pub(super) fn of_parts(numbers: &[Number], place: usize) -> Vec<Dual64> {
    numbers.iter().map(|number| of_part(number, place)).collect()
}

/// Whether all derivatives are finite.
pub(super) fn has_derivatives(number: &Number) -> bool {
    derivatives(number).iter().all(|derivative| derivative.is_finite())
}
