//! Numbers with several derivatives.

use num_dual::{Derivative, DualSVec};
use qrm_core::{Dual, DualKind};

/// The number of derivatives that are computed together.
pub(crate) const PARTS: usize = 8;

/// A value with its derivatives, as the scalar that a tape is evaluated on.
pub(crate) type Differentiated<D> = Dual<DualSVec<D, PARTS>>;

/// A number by its value and derivatives.
pub(crate) fn differentiated<D: DualKind>(value: D, derivatives: [D; PARTS]) -> Differentiated<D> {
    Dual(DualSVec::new(value, Derivative::some(derivatives.into())))
}

/// One of the derivatives of a number.
pub(crate) fn derivative<D: DualKind>(number: &Differentiated<D>, part: usize) -> D {
    number.0.eps.0.as_ref().map_or(D::from(0.0), |all| all[part])
}
