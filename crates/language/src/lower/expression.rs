//! Converts operations into expressions.

use qrm_core::Operation;

use crate::ir::{Builtin, Expression, Operator};

/// The expression of an operation with given operands; two expressions for a sine with its cosine.
pub(super) fn expressions(operation: Operation, mut at: impl FnMut(u32) -> Expression) -> Vec<Expression> {
    use Operation as Op;
    use Operator::{Add, Divide, Multiply, Subtract};
    let number = |number: f64| Expression::Number(format!("{number:?}"));
    let (builtin, a, second) = match operation {
        Op::Number(value) if value.is_infinite() => return vec![Expression::Infinity],
        Op::Number(value) if value.is_sign_negative() => return vec![number(-value).negative()],
        Op::Number(value) => return vec![number(value)],
        Op::Pi => return vec![Expression::Pi],
        Op::Neg(a) => return vec![at(a).negative()],
        Op::Add(a, b) => return vec![Expression::binary(Add, at(a), at(b))],
        Op::Sub(a, b) => return vec![Expression::binary(Subtract, at(a), at(b))],
        Op::Mul(a, b) => return vec![Expression::binary(Multiply, at(a), at(b))],
        Op::Div(a, b) => return vec![Expression::binary(Divide, at(a), at(b))],
        Op::Recip(a) => return vec![Expression::binary(Divide, number(1.0), at(a))],
        // The compiler decides whether product and sum are fused, as in Rust.
        Op::MulAdd(a, b, c) => {
            let product = Expression::binary(Multiply, at(a), at(b));
            return vec![Expression::binary(Add, product, at(c))];
        }
        Op::NegMulAdd(a, b, c) => {
            let product = Expression::binary(Multiply, at(a), at(b));
            return vec![Expression::binary(Subtract, at(c), product)];
        }
        Op::SinCos(a) => {
            let angle = at(a);
            return [Builtin::Sin, Builtin::Cos].map(|own| Expression::Call(own, vec![angle.clone()])).into();
        }
        Op::PowI(a, exponent) => (Builtin::Power, a, Some(number(f64::from(exponent)))),
        Op::PowF(a, exponent) if exponent < 0.0 => (Builtin::Power, a, Some(number(-exponent).negative())),
        Op::PowF(a, exponent) => (Builtin::Power, a, Some(number(exponent))),
        Op::Pow(a, b) => (Builtin::Power, a, Some(at(b))),
        Op::Min(a, b) => (Builtin::Min, a, Some(at(b))),
        Op::Max(a, b) => (Builtin::Max, a, Some(at(b))),
        Op::Hypot(a, b) => (Builtin::Hypot, a, Some(at(b))),
        Op::Atan2(a, b) => (Builtin::Atan2, a, Some(at(b))),
        Op::Sqrt(a) => (Builtin::Sqrt, a, None),
        Op::Sin(a) => (Builtin::Sin, a, None),
        Op::Cos(a) => (Builtin::Cos, a, None),
        Op::Tan(a) => (Builtin::Tan, a, None),
        Op::Asin(a) => (Builtin::Asin, a, None),
        Op::Acos(a) => (Builtin::Acos, a, None),
        Op::Atan(a) => (Builtin::Atan, a, None),
        Op::Exp(a) => (Builtin::Exp, a, None),
        Op::Ln(a) => (Builtin::Ln, a, None),
        Op::Sinh(a) => (Builtin::Sinh, a, None),
        Op::Cosh(a) => (Builtin::Cosh, a, None),
        Op::Tanh(a) => (Builtin::Tanh, a, None),
        Op::Abs(a) => (Builtin::Abs, a, None),
        Op::Sign(a) => (Builtin::Sign, a, None),
        Op::Floor(a) => (Builtin::Floor, a, None),
    };
    let arguments = std::iter::once(at(a)).chain(second).collect();
    vec![Expression::Call(builtin, arguments)]
}
