//! The execution of operations.

use super::Operation;
use crate::Scalar;

/// Executes operations, whose results have the places from `next` on; the place after the last one.
#[inline(never)]
pub fn execute<R: Scalar>(values: &mut [R], next: usize, operations: &[Operation]) -> usize {
    R::vectorized(
        #[inline(always)]
        || execute_all(values, next, operations),
    )
}

#[inline(always)]
fn execute_all<R: Scalar>(values: &mut [R], mut next: usize, operations: &[Operation]) -> usize {
    for operation in operations {
        next = execute_one(values, next, operation);
    }
    next
}

/// Executes an operation, whose result has the place `next`; the place after it.
#[inline(always)]
pub(crate) fn execute_one<R: Scalar>(values: &mut [R], mut next: usize, operation: &Operation) -> usize {
    use Operation as Op;
    let at = |place: u32| values[place as usize];
    let value = match *operation {
        Op::Number(number) => R::from_f64(number),
        Op::Pi => R::pi(),
        Op::Neg(a) => -at(a),
        Op::Add(a, b) => at(a) + at(b),
        Op::Sub(a, b) => at(a) - at(b),
        Op::Mul(a, b) => at(a) * at(b),
        Op::Div(a, b) => at(a) / at(b),
        Op::Recip(a) => at(a).recip(),
        Op::Sqrt(a) => at(a).sqrt(),
        Op::Sin(a) => at(a).sin(),
        Op::Cos(a) => at(a).cos(),
        Op::SinCos(a) => {
            let (sine, cosine) = at(a).sin_cos();
            values[next] = sine;
            next += 1;
            cosine
        }
        Op::Tan(a) => at(a).tan(),
        Op::Asin(a) => at(a).asin(),
        Op::Acos(a) => at(a).acos(),
        Op::Atan(a) => at(a).atan(),
        Op::Exp(a) => at(a).exp(),
        Op::Ln(a) => at(a).ln(),
        Op::Sinh(a) => at(a).sinh(),
        Op::Cosh(a) => at(a).cosh(),
        Op::Tanh(a) => at(a).tanh(),
        Op::Abs(a) => at(a).abs(),
        Op::Sign(a) => at(a).sign(),
        Op::Floor(a) => at(a).floor(),
        Op::Min(a, b) => at(a).min(at(b)),
        Op::Max(a, b) => at(a).max(at(b)),
        Op::Hypot(a, b) => at(a).hypot(at(b)),
        Op::Atan2(a, b) => at(a).atan2(at(b)),
        Op::PowI(a, exponent) => at(a).powi(exponent),
        Op::PowF(a, exponent) => at(a).powf(exponent),
        Op::Pow(a, b) => at(a).pow(at(b)),
        Op::MulAdd(a, b, c) => at(a).mul_add(at(b), at(c)),
        Op::NegMulAdd(a, b, c) => at(a).neg_mul_add(at(b), at(c)),
    };
    values[next] = value;
    next + 1
}
