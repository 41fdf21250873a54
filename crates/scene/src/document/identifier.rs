//! Names with their places.

use crate::diagnostic::Span;

/// A name and its place.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Identifier {
    /// The name.
    pub name: String,
    /// Where it stands.
    pub span: Span,
}

/// The point or body that a force, a torque or a reaction acts on.
#[derive(Debug)]
pub enum Target {
    /// `at = "point"`
    Point(Identifier),
    /// `on = "body"`
    Body(Identifier),
}
