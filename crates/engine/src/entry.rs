//! Named quantities, and the criterion for scenes that need them.

use std::collections::HashSet;

use symbolica::atom::Atom;

use qrm_scene::expression::Node;
use qrm_scene::function::Function;
use qrm_scene::resolve::all_values;
use qrm_scene::scene::{Quantity, Scene, Value};

/// The largest number of coordinates in a function's argument that has no name. With more coordinates, each one would
/// add a long first derivative, and each pair a second derivative.
pub(super) const COORDINATES: usize = 3;

/// A named quantity.
pub(super) struct Entry {
    pub(super) name: String,
    pub(super) is_root: bool,
    /// The formula, or the radicand of a root.
    pub(super) formula: Atom,
    /// The derivatives of `formula`; empty where names are variables.
    pub(super) gradient: Vec<Atom>,
    /// The derivatives of the quantity: symbols, unless they are numbers; empty where names are variables.
    pub(super) slopes: Vec<Atom>,
    /// The partial derivative of `formula` with respect to time.
    pub(super) time_derivative: Atom,
    /// The coordinates on which the quantity depends.
    pub(super) coordinates: HashSet<usize>,
}

/// Whether the argument of a function other than a root depends on more than [`COORDINATES`] coordinates.
pub(super) fn expands_too_much(scene: &Scene) -> bool {
    all_values(scene).into_iter().any(has_long_argument)
}

fn has_long_argument(value: &Value) -> bool {
    let mut coordinates: Vec<HashSet<usize>> = Vec::new();
    for node in value.nodes() {
        let union = |places: &[usize]| places.iter().flat_map(|&place| coordinates[place].iter().copied()).collect();
        let own: HashSet<usize> = match node {
            Node::Number(_) => HashSet::new(),
            Node::Name(Quantity::Coordinate(i)) => HashSet::from([*i]),
            Node::Name(_) => HashSet::new(),
            Node::Negate(a) | Node::Spline(_, a) => union(&[*a]),
            Node::Add(a, b) | Node::Subtract(a, b) | Node::Multiply(a, b) | Node::Divide(a, b) | Node::Power(a, b) => {
                union(&[*a, *b])
            }
            Node::Call(_, arguments) => union(arguments),
        };
        let is_root = matches!(node, Node::Call(Function::Sqrt | Function::Hypot, _));
        if matches!(node, Node::Call(..) | Node::Spline(..)) && !is_root && own.len() > COORDINATES {
            return true;
        }
        coordinates.push(own);
    }
    false
}
