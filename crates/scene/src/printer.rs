//! Prints formulae with as few parentheses as the parser needs.

use num_rational::BigRational;
use num_traits::{One, Zero};

use crate::expression::{Node, NodeId, Number};
use crate::parser::Formula;

/// How tightly an operation binds.
#[derive(Clone, Copy, PartialEq, PartialOrd)]
enum Precedence {
    Sum,
    Product,
    Sign,
    Power,
    Atom,
}

/// The text of a formula, as [`parse_formula`](crate::parser::parse_formula) reads it.
pub fn print_formula(formula: &Formula) -> String {
    let mut texts: Vec<(String, Precedence)> = Vec::new();
    for node in formula.nodes() {
        let text = text(node, &texts);
        texts.push(text);
    }
    texts.pop().map_or_else(String::new, |(text, _)| text)
}

fn text(node: &Node<String>, texts: &[(String, Precedence)]) -> (String, Precedence) {
    let within = |place: NodeId, least: Precedence| {
        let (text, own) = &texts[place];
        if *own < least { format!("({text})") } else { text.clone() }
    };
    let (sum, product, sign) = (Precedence::Sum, Precedence::Product, Precedence::Sign);
    match node {
        Node::Number(value) => (number(value), Precedence::Atom),
        Node::Name(name) => (name.clone(), Precedence::Atom),
        Node::Negate(a) => (format!("-{}", within(*a, sign)), sign),
        Node::Add(a, b) => (format!("{} + {}", within(*a, sum), within(*b, product)), sum),
        Node::Subtract(a, b) => (format!("{} - {}", within(*a, sum), within(*b, product)), sum),
        Node::Multiply(a, b) => (format!("{}*{}", within(*a, product), within(*b, Precedence::Power)), product),
        Node::Divide(a, b) => (format!("{}/{}", within(*a, product), within(*b, Precedence::Power)), product),
        Node::Power(a, b) => {
            (format!("{}^{}", within(*a, Precedence::Atom), within(*b, Precedence::Sign)), Precedence::Power)
        }
        Node::Call(function, arguments) => {
            let arguments: Vec<&str> = arguments.iter().map(|place| texts[*place].0.as_str()).collect();
            (format!("{}({})", function.name(), arguments.join(", ")), Precedence::Atom)
        }
        Node::Spline(spline, argument) => (format!("{}({})", spline.name, texts[*argument].0), Precedence::Atom),
    }
}

/// Prints a number as an exact decimal.
fn number(number: &Number) -> String {
    let shortest = format!("{}", number.value);
    if Number::parse(&shortest).is_some_and(|read| read.exact == number.exact) {
        return shortest;
    }
    decimal(&number.exact).unwrap_or_else(|| format!("({}/{})", number.exact.numer(), number.exact.denom()))
}

/// The decimal of a rational number, if it has a finite one.
fn decimal(exact: &BigRational) -> Option<String> {
    let ten = BigRational::from_integer(10.into());
    let (mut digits, mut power) = (exact.clone(), 0);
    while !digits.denom().is_one() && power < 400 {
        digits *= &ten;
        power += 1;
    }
    let whole = digits.denom().is_one().then(|| digits.to_integer())?;
    if whole.is_zero() || power == 0 {
        return Some(whole.to_string());
    }
    Some(format!("{whole}e-{power}"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::declarations::Declarations;
    use crate::parser::parse_formula;

    #[test]
    fn what_is_printed_is_read_as_it_was() {
        for text in [
            "a - (b - c)",
            "a - b - c",
            "-a^2",
            "(-a)^2",
            "a^-b",
            "a^b^c",
            "(a^b)^c",
            "a/(b*c)",
            "a/b*c",
            "-(a + b)*c",
            "a*-b",
            "--a",
            "hypot(P.x - 0.125, 1e-3)*cos(2*(phi + pi/2))",
            "0.1234567890123456789 + 1e30 + 12345678901234567890123",
        ] {
            let formula = parse_formula(text, 0, &Declarations::default()).expect("a formula");
            let printed = print_formula(&formula);
            let again = parse_formula(&printed, 0, &Declarations::default()).expect("a formula");
            assert_eq!(formula.nodes(), again.nodes(), "{text}: {printed}");
        }
    }
}
