//! Functions of a sign.

use num_rational::BigRational;

use qrm_codegen::term::Term;

/// A function of the sign of its argument, constant on both sides of zero.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Switch {
    /// 1 if the argument is positive, -1 if it is negative, 0 at zero.
    Sign,
    /// 1 if the argument is positive, 0 if it is negative, 1/2 at zero.
    Above,
    /// 0 if the argument is positive, 1 if it is negative, 1/2 at zero.
    Below,
}

impl Switch {
    /// The value of the function for an argument with this sign.
    pub(super) fn on_side(self, sign: Term) -> Term {
        let half = BigRational::new(1.into(), 2.into());
        let part = match self {
            Self::Sign => return sign,
            Self::Above => half.clone(),
            Self::Below => -half.clone(),
        };
        Term::Sum(vec![Term::Number(half), Term::Product(vec![Term::Number(part), sign])])
    }
}
