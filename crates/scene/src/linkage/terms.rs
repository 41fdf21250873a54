//! Constructors of formulae. They remove zeros and ones, so that the results are short.

use crate::diagnostic::Span;
use crate::expression::{Node, NodeId, Number};
use crate::function::Function;
use crate::parser::Formula;

/// The formula that is a name.
pub(crate) fn name(name: impl Into<String>, span: &Span) -> Formula {
    let mut formula = Formula::new();
    formula.push(Node::Name(name.into()), span.clone());
    formula
}

/// The formula that is an integer.
pub(crate) fn whole(value: i32) -> Formula {
    let mut formula = Formula::new();
    formula.push(Node::Number(Number::whole(value)), 0..0);
    formula
}

/// `a + b`
pub(crate) fn add(a: Formula, b: Formula) -> Formula {
    match (is_whole(&a, 0), is_whole(&b, 0), negated(&b)) {
        (true, _, _) => b,
        (_, true, _) => a,
        (_, _, Some(b)) => join(a, b, Node::Subtract),
        _ => join(a, b, Node::Add),
    }
}

/// `a - b`
pub(crate) fn subtract(a: Formula, b: Formula) -> Formula {
    match (is_whole(&a, 0), is_whole(&b, 0), negated(&b)) {
        _ if a.nodes() == b.nodes() => whole(0),
        (_, true, _) => a,
        (true, _, _) => negate(b),
        (_, _, Some(b)) => join(a, b, Node::Add),
        _ => join(a, b, Node::Subtract),
    }
}

/// `a*b`
pub(crate) fn multiply(a: Formula, b: Formula) -> Formula {
    match () {
        () if is_whole(&a, 0) || is_whole(&b, 0) => whole(0),
        () if is_whole(&a, 1) => b,
        () if is_whole(&b, 1) => a,
        () => join(a, b, Node::Multiply),
    }
}

/// `a/b`
pub(crate) fn divide(a: Formula, b: Formula) -> Formula {
    join(a, b, Node::Divide)
}

/// `-a`
pub(crate) fn negate(a: Formula) -> Formula {
    if is_whole(&a, 0) {
        return a;
    }
    if let Some(inner) = negated(&a) {
        return inner;
    }
    let (mut formula, span) = (a.clone(), a.whole_span());
    let last = formula.nodes().len() - 1;
    formula.push(Node::Negate(last), span);
    formula
}

/// `cos(a)` and `sin(a)`
pub(crate) fn direction(a: &Formula) -> [Formula; 2] {
    if is_whole(a, 0) {
        return [whole(1), whole(0)];
    }
    [Function::Cos, Function::Sin].map(|function| call(function, [a.clone()]))
}

/// `f(a, ...)`
pub(crate) fn call<const K: usize>(function: Function, arguments: [Formula; K]) -> Formula {
    let (mut formula, mut places, mut span) = (Formula::new(), Vec::new(), 0..0);
    for argument in arguments {
        span = argument.whole_span();
        places.push(formula.append(&argument));
    }
    formula.push(Node::Call(function, places), span);
    formula
}

/// The dot product.
pub(crate) fn dot([ax, ay]: [Formula; 2], [bx, by]: [Formula; 2]) -> Formula {
    add(multiply(ax, bx), multiply(ay, by))
}

/// The difference of two vectors.
pub(crate) fn difference([ax, ay]: [Formula; 2], [bx, by]: [Formula; 2]) -> [Formula; 2] {
    [subtract(ax, bx), subtract(ay, by)]
}

/// The sum of two vectors.
pub(crate) fn sum([ax, ay]: [Formula; 2], [bx, by]: [Formula; 2]) -> [Formula; 2] {
    [add(ax, bx), add(ay, by)]
}

/// The components of a vector given in a frame with this angle.
pub(crate) fn rotated([x, y]: [Formula; 2], angle: &Formula) -> [Formula; 2] {
    let [cos, sin] = direction(angle);
    [
        subtract(multiply(x.clone(), cos.clone()), multiply(y.clone(), sin.clone())),
        add(multiply(x, sin), multiply(y, cos)),
    ]
}

/// The third corner of a triangle with these sides, in the frame of its first corner.
pub(crate) fn corner(first: Formula, second: Formula, third: Formula) -> [Formula; 2] {
    let square = |side: &Formula| join(side.clone(), whole(2), Node::Power);
    let sum = subtract(add(square(&first), square(&third)), square(&second));
    let x = divide(sum, multiply(whole(2), first));
    let y = call(Function::Sqrt, [subtract(square(&third), square(&x))]);
    [x, y]
}

/// The area of a triangle, from two sides that share a corner.
pub(crate) fn area(first: Formula, corner: &[Formula; 2]) -> Formula {
    divide(multiply(first, corner[1].clone()), whole(2))
}

fn join(a: Formula, b: Formula, node: fn(NodeId, NodeId) -> Node<String>) -> Formula {
    let mut formula = a;
    let left = formula.nodes().len() - 1;
    let span = if b.whole_span().is_empty() { formula.whole_span() } else { b.whole_span() };
    let right = formula.append(&b);
    formula.push(node(left, right), span);
    formula
}

/// The value of a formula of time at time zero.
pub(crate) fn at_time_zero(formula: &Formula) -> Formula {
    let mut at_zero = Formula::new();
    for (place, node) in formula.nodes().iter().enumerate() {
        let is_time = matches!(node, Node::Name(name) if name == "t");
        at_zero.push(if is_time { Node::Number(Number::whole(0)) } else { node.clone() }, formula.span(place));
    }
    at_zero
}

/// Replaces a name in a formula by another formula.
pub(crate) fn substituted(formula: &Formula, own: &str, by: &Formula) -> Formula {
    let mut written = Formula::new();
    let mut places: Vec<NodeId> = Vec::new();
    for (place, node) in formula.nodes().iter().enumerate() {
        let is_own = matches!(node, Node::Name(name) if name == own);
        let at = match is_own {
            true => written.append(by),
            false => written.push(node.at(|operand| places[operand]), formula.span(place)),
        };
        places.push(at);
    }
    written
}

/// Whether a formula is the number zero.
pub(crate) fn is_zero(formula: &Formula) -> bool {
    is_whole(formula, 0)
}

/// Whether a formula is a number above zero.
pub(crate) fn is_positive(formula: &Formula) -> bool {
    matches!(formula.nodes(), [Node::Number(number)] if number.value > 0.0)
}

fn is_whole(formula: &Formula, value: i32) -> bool {
    matches!(formula.nodes(), [Node::Number(number)] if number.value == f64::from(value))
}

/// The formula without its leading minus sign, if it has one.
fn negated(formula: &Formula) -> Option<Formula> {
    let (last, rest) = formula.nodes().split_last()?;
    let Node::Negate(inner) = last else { return None };
    if inner + 1 != rest.len() {
        return None;
    }
    let mut positive = Formula::new();
    for (place, node) in rest.iter().enumerate() {
        positive.push(node.clone(), formula.span(place));
    }
    Some(positive)
}
