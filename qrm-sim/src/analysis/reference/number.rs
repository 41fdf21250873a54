//! The numbers of reference motions.

use qrm_core::DoubleDouble;

/// A double-double number, about 32 digits.
pub(super) type Number = DoubleDouble;
