//! Rust expressions as tokens, with the parentheses they need.

use proc_macro2::{Literal, TokenStream};
use quote::quote;

/// How tightly an expression holds together.
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
    /// A name, a call, a literal: nothing inside can come loose.
    pub(super) fn whole(tokens: TokenStream) -> Self {
        Self { tokens, binding: Binding::Whole }
    }

    /// The expression with parentheses unless it holds together at least as tightly as asked.
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

/// A double that is not negative, as the shortest decimal that reads back as itself.
pub(super) fn literal(value: f64) -> TokenStream {
    // Debug writes an exponent where digits would run long; Literal's own formatting never does.
    let text = format!("{value:?}");
    match text.parse::<Literal>() {
        Ok(literal) => quote!(#literal),
        Err(_) => unreachable!("`{text}` is a literal: the value is finite and has no sign"),
    }
}
