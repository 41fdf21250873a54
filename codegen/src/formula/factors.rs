//! Formats products, quotients, powers and calls.

use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::{One, Signed};

use super::fraction::{Factor, Fraction};
use super::names::latex_function;
use super::{Style, Writer};
use crate::term::Term;
use qrm_scene::expression::{Number, to_f64};
use qrm_scene::function::Function;
use qrm_scene::spline::Spline;

impl Writer<'_> {
    pub(super) fn fraction(&self, fraction: Fraction) -> String {
        let Fraction { coefficient, above, below, is_negative } = fraction;
        let (numerator, denominator) = (coefficient.numer(), coefficient.denom());
        match self.style {
            Style::Plain => {
                let number = decimal(&coefficient);
                let rest = if number.is_some() { BigInt::one() } else { denominator.clone() };
                let above = self.product(number.unwrap_or_else(|| numerator.to_string()), &above, false);
                let many = below.len() + usize::from(!rest.is_one()) > 1;
                let below = self.product(rest.to_string(), &below, false);
                match below.as_str() {
                    "1" => above,
                    _ if many => format!("{above}/({below})"),
                    _ => format!("{above}/{below}"),
                }
            }
            Style::Latex if below.is_empty() => {
                let is_simple = !denominator.is_one() && *denominator <= BigInt::from(12);
                let number = decimal(&coefficient).filter(|_| !is_simple).map(|number| scientific(&number));
                let number = number.unwrap_or_else(|| format!(r"\tfrac{{{numerator}}}{{{denominator}}}"));
                self.product(number, &above, !is_negative)
            }
            Style::Latex => {
                let above = self.product(numerator.to_string(), &above, true);
                format!(r"\frac{{{above}}}{{{}}}", self.product(denominator.to_string(), &below, true))
            }
        }
    }

    /// Formats a number times factors. A factor of one is omitted, and a single sum may omit its parentheses.
    fn product(&self, number: String, factors: &[Factor], may_be_bare: bool) -> String {
        if factors.is_empty() {
            return number;
        }
        let has_number = number != "1";
        let is_alone = factors.len() == 1 && !has_number && may_be_bare;
        let mut text = if has_number { number } else { String::new() };
        for (i, factor) in factors.iter().enumerate() {
            text += match (i, self.style, factor.base) {
                (0, _, _) if !has_number => "",
                (_, Style::Plain, _) => "*",
                // Two adjacent numbers would look like one.
                (0, Style::Latex, Term::Number(_)) => r" \cdot ",
                (_, Style::Latex, _) => r"\,",
            };
            text += &self.factor(factor, is_alone);
        }
        text
    }

    fn factor(&self, factor: &Factor, alone: bool) -> String {
        let Factor { base, exponent } = factor;
        if let Some((_, name)) = self.roots.iter().find(|(radicand, _)| *radicand == **base)
            && !(exponent.is_one() && alone)
        {
            let doubled = exponent * BigInt::from(2);
            return match (self.style, doubled.is_integer(), doubled.is_one()) {
                (_, _, true) => name.clone(),
                (Style::Plain, true, _) => format!("{name}^{doubled}"),
                (Style::Plain, false, _) => format!("{name}^({doubled})"),
                (Style::Latex, ..) => format!("{{{name}}}^{{{doubled}}}"),
            };
        }
        let half = BigRational::new(1.into(), 2.into());
        if *exponent == half {
            let radicand = self.term(base);
            return if self.style == Style::Plain {
                format!("sqrt({radicand})")
            } else {
                format!(r"\sqrt{{{radicand}}}")
            };
        }
        if exponent.is_one() {
            return match base {
                Term::Call(function, argument) => self.call(*function, argument, ""),
                Term::Spline(spline, order, argument) => self.spline(spline, *order, argument, ""),
                Term::Symbol(symbol) => self.symbol(*symbol),
                Term::Sum(_) if alone => self.term(base),
                Term::Number(n) if !n.is_negative() && n.is_integer() => self.term(base),
                _ => self.in_parentheses(&self.term(base)),
            };
        }
        let power = match (self.style, exponent.is_integer()) {
            (Style::Plain, true) => format!("^{exponent}"),
            (Style::Plain, false) => format!("^({exponent})"),
            (Style::Latex, _) => format!("^{{{exponent}}}"),
        };
        match base {
            Term::Call(function, argument) => self.call(*function, argument, &power),
            Term::Spline(spline, order, argument) => self.spline(spline, *order, argument, &power),
            Term::Symbol(symbol) => self.symbol(*symbol) + power.as_str(),
            Term::Number(n) if n.is_integer() && !n.is_negative() => self.term(base) + power.as_str(),
            _ => self.in_parentheses(&self.term(base)) + power.as_str(),
        }
    }

    fn call(&self, function: Function, argument: &Term, power: &str) -> String {
        let inside = self.term(argument);
        if self.style == Style::Plain {
            return format!("{}({inside}){power}", function.name());
        }
        match (function, argument) {
            (Function::Sqrt, _) if power.is_empty() => format!(r"\sqrt{{{inside}}}"),
            (Function::Exp, _) if power.is_empty() => format!(r"\mathrm{{e}}^{{{inside}}}"),
            (Function::Exp | Function::Sqrt, _) => {
                format!(r"\left({}\right){power}", self.call(function, argument, ""))
            }
            (_, Term::Symbol(_)) => format!("{}{power} {inside}", latex_function(function)),
            _ => format!("{}{power}{}", latex_function(function), self.in_parentheses(&inside)),
        }
    }

    /// Formats a spline by its name, with a prime for each derivative.
    fn spline(&self, spline: &Spline, order: usize, argument: &Term, power: &str) -> String {
        let (inside, dashes) = (self.term(argument), "'".repeat(order));
        match self.style {
            Style::Plain => format!("{}{dashes}({inside}){power}", spline.name),
            Style::Latex => {
                let name = format!(r"\operatorname{{{}}}{dashes}", spline.name.replace('_', r"\_"));
                let call = format!("{name}{}", self.in_parentheses(&inside));
                if power.is_empty() { call } else { format!(r"\left({call}\right){power}") }
            }
        }
    }

    fn in_parentheses(&self, text: &str) -> String {
        if self.style == Style::Plain { format!("({text})") } else { format!(r"\left({text}\right)") }
    }
}

/// A number as a decimal, if the decimal is exact.
fn decimal(number: &BigRational) -> Option<String> {
    if number.is_integer() {
        return Some(number.to_string());
    }
    let text = format!("{:?}", to_f64(number));
    (Number::parse(&text)?.exact == *number).then_some(text)
}

/// Formats `1e-5` in LaTeX.
fn scientific(number: &str) -> String {
    match number.split_once('e') {
        Some((mantissa, exponent)) => format!(r"{mantissa} \cdot 10^{{{exponent}}}"),
        None => number.to_owned(),
    }
}
