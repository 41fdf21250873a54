//! One operation of a tape, and the places of its operands and results.

/// One operation on values; operands are places that hold a value already.
///
/// The result has the next free place. [`SinCos`](Self::SinCos) has two results: the sine, then the cosine.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[allow(missing_docs, reason = "the names say what they compute")]
pub enum Operation {
    Number(f64),
    Pi,
    Neg(u32),
    Add(u32, u32),
    Sub(u32, u32),
    Mul(u32, u32),
    Div(u32, u32),
    Recip(u32),
    Sqrt(u32),
    Sin(u32),
    Cos(u32),
    SinCos(u32),
    Tan(u32),
    Asin(u32),
    Acos(u32),
    Atan(u32),
    Exp(u32),
    Ln(u32),
    Sinh(u32),
    Cosh(u32),
    Tanh(u32),
    Abs(u32),
    Sign(u32),
    Floor(u32),
    Min(u32, u32),
    Max(u32, u32),
    Hypot(u32, u32),
    Atan2(u32, u32),
    /// A whole power.
    PowI(u32, i32),
    /// A power with a fixed exponent.
    PowF(u32, f64),
    /// A power with any exponent.
    Pow(u32, u32),
    /// The product of the first two values and the third one, added.
    MulAdd(u32, u32, u32),
    /// The product of the first two values, subtracted from the third one.
    NegMulAdd(u32, u32, u32),
}

impl Operation {
    /// The last kind: operations that are no sums and products.
    pub(crate) const OTHER: usize = 6;

    /// The kind of the operation: the form of a sum or product, or another one.
    pub(crate) fn kind(self) -> usize {
        match self {
            Self::MulAdd(..) => 0,
            Self::Mul(..) => 1,
            Self::NegMulAdd(..) => 2,
            Self::Add(..) => 3,
            Self::Sub(..) => 4,
            Self::Neg(_) => 5,
            _ => Self::OTHER,
        }
    }

    /// Hands the operands to a function, in their order.
    pub fn for_each_operand(self, mut f: impl FnMut(u32)) {
        let _ = self.map(|operand| {
            f(operand);
            operand
        });
    }

    /// The operation with its operands replaced, in their order.
    #[must_use]
    pub fn map(self, mut f: impl FnMut(u32) -> u32) -> Self {
        match self {
            Self::Number(_) | Self::Pi => self,
            Self::Neg(a) => Self::Neg(f(a)),
            Self::Add(a, b) => Self::Add(f(a), f(b)),
            Self::Sub(a, b) => Self::Sub(f(a), f(b)),
            Self::Mul(a, b) => Self::Mul(f(a), f(b)),
            Self::Div(a, b) => Self::Div(f(a), f(b)),
            Self::Recip(a) => Self::Recip(f(a)),
            Self::Sqrt(a) => Self::Sqrt(f(a)),
            Self::Sin(a) => Self::Sin(f(a)),
            Self::Cos(a) => Self::Cos(f(a)),
            Self::SinCos(a) => Self::SinCos(f(a)),
            Self::Tan(a) => Self::Tan(f(a)),
            Self::Asin(a) => Self::Asin(f(a)),
            Self::Acos(a) => Self::Acos(f(a)),
            Self::Atan(a) => Self::Atan(f(a)),
            Self::Exp(a) => Self::Exp(f(a)),
            Self::Ln(a) => Self::Ln(f(a)),
            Self::Sinh(a) => Self::Sinh(f(a)),
            Self::Cosh(a) => Self::Cosh(f(a)),
            Self::Tanh(a) => Self::Tanh(f(a)),
            Self::Abs(a) => Self::Abs(f(a)),
            Self::Sign(a) => Self::Sign(f(a)),
            Self::Floor(a) => Self::Floor(f(a)),
            Self::Min(a, b) => Self::Min(f(a), f(b)),
            Self::Max(a, b) => Self::Max(f(a), f(b)),
            Self::Hypot(a, b) => Self::Hypot(f(a), f(b)),
            Self::Atan2(a, b) => Self::Atan2(f(a), f(b)),
            Self::PowI(a, exponent) => Self::PowI(f(a), exponent),
            Self::PowF(a, exponent) => Self::PowF(f(a), exponent),
            Self::Pow(a, b) => Self::Pow(f(a), f(b)),
            Self::MulAdd(a, b, c) => Self::MulAdd(f(a), f(b), f(c)),
            Self::NegMulAdd(a, b, c) => Self::NegMulAdd(f(a), f(b), f(c)),
        }
    }
}

/// How many places the results of operations take.
pub(super) fn places(operations: &[Operation]) -> usize {
    let pairs = operations.iter().filter(|operation| matches!(operation, Operation::SinCos(_)));
    operations.len() + pairs.count()
}
