//! Constraints that prescribe the direction of a vector in a form that is singular at some positions.

use crate::diagnostic::Span;
use crate::expression::{Expression, Node, NodeId};
use crate::function::Function;
use crate::scene::{OutputKind, Scene};

/// A constraint that gives a vector the direction of an angle, such as `x - sqrt(x^2 + y^2)*cos(phi)`.
#[derive(Clone, Debug, PartialEq)]
pub struct Direction {
    /// The index of the constraint.
    pub constraint: usize,
    /// The component whose zeros make the constraint singular, as an operation of the residual.
    pub singular_component: NodeId,
    /// The text of the constraint in the form `x*sin(phi) - y*cos(phi)`, which is regular wherever the vector is not
    /// zero. It also holds for the opposite direction.
    pub regular_form: String,
    /// The location of the residual.
    pub span: Span,
}

/// Finds the constraints of the form `x - r*cos(phi)`, `y - r*sin(phi)` or `y - x*tan(phi)`, in either order, where `r`
/// is `sqrt(x^2 + y^2)`, `(x^2 + y^2)^0.5` or `hypot(x, y)`. One-sided constraints are omitted, and constraints whose
/// multiplier an output uses: another form has another multiplier. `source` is the text of the scene.
pub fn directions(scene: &Scene, source: &str) -> Vec<Direction> {
    let is_used = |place: usize| {
        scene.outputs.iter().any(|output| match &output.kind {
            OutputKind::FreeBody { multipliers, .. } => multipliers.iter().any(|(constraint, _)| *constraint == place),
            _ => false,
        })
    };
    let read = scene.constraints.iter().enumerate().filter_map(|(place, constraint)| {
        if constraint.one_sided.is_some() || is_used(place) {
            return None;
        }
        let residual = &constraint.residual;
        let Vector { function, given, other, angle } = vector(residual)?;
        let text = |id: NodeId| {
            let text = source.get(residual.span(id))?;
            let is_sum = matches!(residual.nodes()[id], Node::Add(..) | Node::Subtract(..) | Node::Negate(_));
            Some(if is_sum && !is_enclosed(text) { format!("({text})") } else { text.to_owned() })
        };
        let (x, y, angle) = (text(given)?, text(other)?, source.get(residual.span(angle))?);
        let [first, second] = if function == Function::Cos { ["sin", "cos"] } else { ["cos", "sin"] };
        Some(Direction {
            constraint: place,
            singular_component: other,
            regular_form: format!("{x}*{first}({angle}) - {y}*{second}({angle})"),
            span: residual.whole_span(),
        })
    });
    read.collect()
}

/// The parts of `given - r*function(angle)`, where `r` is the length of the vector of `given` and `other`; or of `given
/// - other*tan(angle)`.
struct Vector {
    function: Function,
    given: NodeId,
    other: NodeId,
    angle: NodeId,
}

fn vector<N: PartialEq>(residual: &Expression<N>) -> Option<Vector> {
    let nodes = residual.nodes();
    let (a, b) = match *nodes.last()? {
        Node::Subtract(a, b) => (a, b),
        Node::Add(a, b) => match (&nodes[a], &nodes[b]) {
            (Node::Negate(a), _) => (*a, b),
            (_, Node::Negate(b)) => (a, *b),
            _ => return None,
        },
        _ => return None,
    };
    for (given, product) in [(a, b), (b, a)] {
        let Node::Multiply(a, b) = nodes[product] else { continue };
        for (length, call) in [(a, b), (b, a)] {
            let Node::Call(function @ (Function::Sin | Function::Cos | Function::Tan), angle) = &nodes[call] else {
                continue;
            };
            let other = match (function, components(residual, length)) {
                (Function::Tan, _) => length,
                (_, Some([x, y])) if is_same(residual, given, x) => y,
                (_, Some([x, y])) if is_same(residual, given, y) => x,
                _ => continue,
            };
            return Some(Vector { function: *function, given, other, angle: angle[0] });
        }
    }
    None
}

/// The components of a vector, given the operation that computes its length.
fn components<N: PartialEq>(expression: &Expression<N>, length: NodeId) -> Option<[NodeId; 2]> {
    let nodes = expression.nodes();
    let square = |id: NodeId| match &nodes[id] {
        Node::Multiply(a, b) if is_same(expression, *a, *b) => Some(*a),
        _ => expression.base(id, 2.0),
    };
    let radicand = match &nodes[length] {
        Node::Call(Function::Hypot, arguments) => return Some([arguments[0], arguments[1]]),
        Node::Call(Function::Sqrt, arguments) => arguments[0],
        _ => expression.base(length, 0.5)?,
    };
    let Node::Add(a, b) = nodes[radicand] else { return None };
    Some([square(a)?, square(b)?])
}

/// Whether one pair of parentheses encloses a whole text.
fn is_enclosed(text: &str) -> bool {
    let mut depth = 0;
    let closes = |(place, c): (usize, char)| {
        depth += i32::from(c == '(') - i32::from(c == ')');
        (depth == 0).then_some(place)
    };
    text.char_indices().find_map(closes).is_some_and(|place| place > 0 && place + 1 == text.len())
}

/// Whether two operations are equal, operands included.
fn is_same<N: PartialEq>(expression: &Expression<N>, a: NodeId, b: NodeId) -> bool {
    let (first, second) = (&expression.nodes()[a], &expression.nodes()[b]);
    let (operands, others) = (first.operands(), second.operands());
    let is_same_operation = match (first, second) {
        (Node::Number(a), Node::Number(b)) => a.exact == b.exact,
        (Node::Name(a), Node::Name(b)) => a == b,
        (Node::Call(a, _), Node::Call(b, _)) => a == b,
        (Node::Spline(a, _), Node::Spline(b, _)) => a.name == b.name,
        (Node::Number(_) | Node::Name(_) | Node::Call(..) | Node::Spline(..), _) => false,
        _ => std::mem::discriminant(first) == std::mem::discriminant(second),
    };
    is_same_operation
        && operands.len() == others.len()
        && operands.iter().zip(&others).all(|(a, b)| is_same(expression, *a, *b))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::resolve;

    fn form(residual: &str) -> Option<[String; 2]> {
        form_with(residual, "")
    }

    fn form_with(residual: &str, outputs: &str) -> Option<[String; 2]> {
        let source = format!(
            "name = \"s\"\ncoordinates = [{{ name = \"p\" }}, {{ name = \"a\" }}]\n[bodies]\nb = {{ angle = 'p', \
             inertia = '1' }}\n[points]\nA = ['cos(p)', '1 + sin(p)']\n[constraints]\nc = {{ residual = '{residual}' \
             }}\n[initial]\ngiven = {{ p = 0, p_dot = 1 }}\nsolve = {{ a = 0.8 }}\n[run]\nstep = 1e-3\nend_time = \
             1\n{outputs}"
        );
        let (scene, _) = resolve::read("s.toml", &source).unwrap_or_else(|e| panic!("{e}"));
        let found = directions(&scene, &source).pop()?;
        let span = scene.constraints[found.constraint].residual.span(found.singular_component);
        Some([found.regular_form, source[span].to_owned()])
    }

    #[test]
    fn directions_have_a_regular_form() {
        let cases = [
            ("A.x - sqrt(A.x^2 + A.y^2)*cos(a)", "A.x*sin(a) - A.y*cos(a)", "A.y"),
            ("cos(a)*sqrt(A.y*A.y + A.x*A.x) - A.x", "A.x*sin(a) - A.y*cos(a)", "A.y"),
            ("-A.x + (A.x^2 + A.y^2)^0.5*cos(a)", "A.x*sin(a) - A.y*cos(a)", "A.y"),
            ("hypot(A.x, A.y)*cos(a) + -A.x", "A.x*sin(a) - A.y*cos(a)", "A.y"),
            ("A.y - hypot(A.x, A.y)*sin(a + 1)", "A.y*cos(a + 1) - A.x*sin(a + 1)", "A.x"),
            ("(A.y) + (p) - (A.x - 1)*tan(a)", "((A.y) + (p))*cos(a) - (A.x - 1)*sin(a)", "(A.x - 1)"),
            ("(A.y + p) - (A.x - 1)*tan(a)", "(A.y + p)*cos(a) - (A.x - 1)*sin(a)", "(A.x - 1)"),
        ];
        for (residual, regular, component) in cases {
            let expected = [regular, component].map(str::to_owned);
            assert_eq!(form(residual), Some(expected), "{residual}");
        }
    }

    #[test]
    fn other_constraints_stay() {
        for residual in [
            "A.x - sqrt(A.x^2 + A.y^2)*cos(a) + 1",
            "A.x + sqrt(A.x^2 + A.y^2)*cos(a)",
            "A.x - sqrt(A.x^2 - A.y^2)*cos(a)",
            "A.x - (A.x^2 + A.y^2)^0.25*cos(a)",
            "A.x - sqrt(A.x^2 + A.y^3)*cos(a)",
            "p - sqrt(A.x^2 + A.y^2)*cos(a)",
            "A.x*sin(a) - A.y*cos(a)",
        ] {
            assert_eq!(form(residual), None, "{residual}");
        }
        let uses_the_multiplier = "[outputs]\nF = { free_body = [], multipliers = { c = 1 }, unit = \"N\" }\n";
        assert_eq!(form_with("A.x - sqrt(A.x^2 + A.y^2)*cos(a)", uses_the_multiplier), None);
    }
}
