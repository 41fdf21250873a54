//! The numbers of reference motions.

use qrm_core::DoubleDouble;

/// A number of 32 digits.
pub(super) type Number = DoubleDouble;
