//! Sizes of numbers and of their rounding errors.

use num_traits::Signed;

use super::wide::Wide;

/// Rounding errors with 32 digits, relative to the largest number of any function in any state, and in any formula.
pub(super) const SMALLEST: f64 = 1e-28;
/// The size below which numbers lose the second half of their digits.
pub(super) const TINY: f64 = 1e-290;

pub(super) fn size(number: Wide) -> f64 {
    number.abs().0.hi()
}
