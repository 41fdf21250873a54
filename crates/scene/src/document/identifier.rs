//! Names with their locations.

use crate::diagnostic::Span;

/// A name and its location.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Identifier {
    /// The name.
    pub name: String,
    /// The location of the name.
    pub span: Span,
}

/// The point or body on which a force, a torque or a reaction acts.
#[derive(Debug)]
pub enum Target {
    /// `at = "point"`
    Point(Identifier),
    /// `on = "body"`
    Body(Identifier),
}
