//! Operations as Rust expressions, with the necessary parentheses.

use proc_macro2::{Literal, TokenStream};
use qrm_core::Operation;
use quote::quote;

/// The precedence of an expression.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Binding {
    Sum,
    Product,
    Sign,
    Whole,
}

/// A Rust expression.
#[derive(Clone, Debug)]
pub(super) struct Piece {
    pub(super) tokens: TokenStream,
    binding: Binding,
}

impl Piece {
    /// An atomic expression: a name, a call, or a literal.
    pub(super) fn whole(tokens: TokenStream) -> Self {
        Self { tokens, binding: Binding::Whole }
    }

    /// The expression, in parentheses unless its precedence is at least `binding`.
    pub(super) fn at_least(&self, binding: Binding) -> TokenStream {
        let tokens = &self.tokens;
        if self.binding >= binding { tokens.clone() } else { quote!((#tokens)) }
    }

    pub(super) fn negate(&self) -> Self {
        let operand = self.at_least(Binding::Whole);
        Self { tokens: quote!(-#operand), binding: Binding::Sign }
    }

    pub(super) fn add(&self, other: &Self) -> Self {
        let (left, right) = (self.at_least(Binding::Sum), other.at_least(Binding::Product));
        Self { tokens: quote!(#left + #right), binding: Binding::Sum }
    }

    pub(super) fn subtract(&self, other: &Self) -> Self {
        let (left, right) = (self.at_least(Binding::Sum), other.at_least(Binding::Product));
        Self { tokens: quote!(#left - #right), binding: Binding::Sum }
    }

    pub(super) fn multiply(&self, other: &Self) -> Self {
        let (left, right) = (self.at_least(Binding::Product), other.at_least(Binding::Whole));
        Self { tokens: quote!(#left * #right), binding: Binding::Product }
    }

    /// `self * other + sum`, or with a negative product.
    pub(super) fn multiply_add(&self, other: &Self, is_negative: bool, sum: &Self) -> Self {
        let (receiver, other, sum) = (self.at_least(Binding::Whole), &other.tokens, &sum.tokens);
        Self::whole(if is_negative {
            quote!(#receiver.neg_mul_add(#other, #sum))
        } else {
            quote!(#receiver.mul_add(#other, #sum))
        })
    }

    pub(super) fn divide(&self, other: &Self) -> Self {
        let (left, right) = (self.at_least(Binding::Product), other.at_least(Binding::Whole));
        Self { tokens: quote!(#left / #right), binding: Binding::Product }
    }

    /// A method call on the expression.
    pub(super) fn call(&self, method: &str, arguments: &TokenStream) -> Self {
        let (receiver, method) = (self.at_least(Binding::Whole), quote::format_ident!("{method}"));
        Self::whole(quote!(#receiver.#method(#arguments)))
    }
}

/// A nonnegative double as the shortest decimal that reads back exactly.
pub(super) fn literal(value: f64) -> TokenStream {
    if value.is_infinite() {
        return quote!(f64::INFINITY);
    }
    // The Debug format uses an exponent for long numbers; that of Literal never does.
    let text = format!("{value:?}");
    match text.parse::<Literal>() {
        Ok(literal) => quote!(#literal),
        Err(_) => unreachable!("`{text}` is a literal: the value is finite and has no sign"),
    }
}

/// The expression of an operation with given operands.
pub(super) fn expression(operation: Operation, mut operand: impl FnMut(u32) -> Piece) -> Piece {
    use Operation as Op;
    let (none, mut at) = (TokenStream::new(), |value: u32| operand(value));
    let (name, a, b) = match operation {
        Op::Number(number) if number.to_bits() == 0 => return Piece::whole(quote!(R::zero())),
        Op::Number(number) => {
            let size = literal(number.abs());
            let size = Piece::whole(quote!(R::from_number(#size)));
            return if number.is_sign_negative() { size.negate() } else { size };
        }
        Op::Pi => return Piece::whole(quote!(R::pi())),
        Op::Neg(a) => return at(a).negate(),
        Op::Add(a, b) => return at(a).add(&at(b)),
        Op::Sub(a, b) => return at(a).subtract(&at(b)),
        Op::Mul(a, b) => return at(a).multiply(&at(b)),
        Op::Div(a, b) => return at(a).divide(&at(b)),
        Op::MulAdd(a, b, c) => return at(a).multiply_add(&at(b), false, &at(c)),
        Op::NegMulAdd(a, b, c) => return at(a).multiply_add(&at(b), true, &at(c)),
        Op::PowI(a, exponent) => {
            let exponent = Literal::i32_unsuffixed(exponent);
            return at(a).call("powi", &quote!(#exponent));
        }
        Op::PowF(a, exponent) => {
            let (size, sign) = (literal(exponent.abs()), (exponent < 0.0).then(|| quote!(-)));
            return at(a).call("powf", &quote!(#sign #size));
        }
        Op::Recip(a) => ("recip", a, None),
        Op::Sqrt(a) => ("sqrt", a, None),
        Op::Sin(a) => ("sin", a, None),
        Op::Cos(a) => ("cos", a, None),
        Op::SinCos(a) => ("sin_cos", a, None),
        Op::Tan(a) => ("tan", a, None),
        Op::Asin(a) => ("asin", a, None),
        Op::Acos(a) => ("acos", a, None),
        Op::Atan(a) => ("atan", a, None),
        Op::Exp(a) => ("exp", a, None),
        Op::Ln(a) => ("ln", a, None),
        Op::Sinh(a) => ("sinh", a, None),
        Op::Cosh(a) => ("cosh", a, None),
        Op::Tanh(a) => ("tanh", a, None),
        Op::Abs(a) => ("abs", a, None),
        Op::Sign(a) => ("sign", a, None),
        Op::Floor(a) => ("floor", a, None),
        Op::Min(a, b) => ("min", a, Some(b)),
        Op::Max(a, b) => ("max", a, Some(b)),
        Op::Hypot(a, b) => ("hypot", a, Some(b)),
        Op::Atan2(a, b) => ("atan2", a, Some(b)),
        Op::Pow(a, b) => ("pow", a, Some(b)),
    };
    let receiver = at(a);
    receiver.call(name, &b.map_or(none, |b| at(b).tokens))
}
