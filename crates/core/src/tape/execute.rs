//! The execution of operations.

use super::Operation;
use crate::Scalar;

/// Executes operations, whose results have the places from `next` on; the place after the last one.
///
/// Sums and products of one form that follow each other are executed fast: the processor foresees the branches of loops.
#[inline(never)]
pub fn execute<R: Scalar>(values: &mut [R], next: usize, operations: &[Operation]) -> usize {
    R::vectorized(
        #[inline(always)]
        || execute_all(values, next, operations),
    )
}

#[inline(always)]
fn execute_all<R: Scalar>(values: &mut [R], mut next: usize, operations: &[Operation]) -> usize {
    use Operation as Op;
    let mut rest = operations.iter();
    let Some(mut operation) = rest.next() else { return next };
    macro_rules! run {
        ($kind:pat => $value:expr) => {
            while let &$kind = operation {
                values[next] = $value;
                next += 1;
                let Some(following) = rest.next() else { return next };
                operation = following;
            }
        };
    }
    macro_rules! at {
        ($place:expr) => {
            values[$place as usize]
        };
    }
    loop {
        run!(Op::MulAdd(a, b, c) => at!(a).mul_add(at!(b), at!(c)));
        run!(Op::Mul(a, b) => at!(a) * at!(b));
        run!(Op::NegMulAdd(a, b, c) => at!(a).neg_mul_add(at!(b), at!(c)));
        run!(Op::Add(a, b) => at!(a) + at!(b));
        run!(Op::Sub(a, b) => at!(a) - at!(b));
        run!(Op::Neg(a) => -at!(a));
        while operation.kind() == Op::OTHER {
            next = execute_other(values, next, operation);
            let Some(following) = rest.next() else { return next };
            operation = following;
        }
    }
}

/// Executes an operation that is no sum or product.
#[inline(always)]
fn execute_other<R: Scalar>(values: &mut [R], mut next: usize, operation: &Operation) -> usize {
    use Operation as Op;
    let at = |place: u32| values[place as usize];
    let value = match *operation {
        Op::MulAdd(..) | Op::Mul(..) | Op::NegMulAdd(..) | Op::Add(..) | Op::Sub(..) | Op::Neg(_) => return next,
        Op::Number(number) => R::from_number(number),
        Op::Pi => R::pi(),
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
    };
    values[next] = value;
    next + 1
}
