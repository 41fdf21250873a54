//! Numbers in the engine.

use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::ToPrimitive;
use symbolica::atom::Atom;
use symbolica::parse;

use qrm_scene::expression::Number;

/// Converts a number of the scene without rounding.
pub(super) fn exact(number: &Number) -> Atom {
    rational(&number.exact)
}

pub(super) fn rational(value: &BigRational) -> Atom {
    let whole = |part: &BigInt| match part.to_i64() {
        Some(small) => Atom::num(small),
        None => parse!(part.to_string()),
    };
    whole(value.numer()) / whole(value.denom())
}
