//! The kinds of outputs.

use super::Value;

/// The kinds of outputs.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum OutputKind {
    /// A formula of coordinates.
    Value(Value),
    /// Its time derivative.
    Rate(Value),
    /// Its second time derivative.
    SecondRate(Value),
    /// Force of a constraint on a point, along a direction: -lambda (dC/dP . along).
    ReactionForce {
        /// The constraint.
        constraint: usize,
        /// The point.
        point: usize,
        /// The direction.
        along: [Value; 2],
    },
    /// Power of a load.
    LoadPower(usize),
    /// Power of a constraint that depends on time.
    DrivePower(usize),
    /// Moment of a constraint on whatever turns with a coordinate: -lambda dC/d(angle).
    ReactionMoment {
        /// The constraint.
        constraint: usize,
        /// The coordinate that is the body's angle.
        coordinate: usize,
    },
    /// Force on bodies along a direction, beside loads and constraints that act on points of theirs:
    /// `sum m a . e - Q + lambda dC`, with the work `Q` and the change `dC` of a virtual displacement by `e`.
    FreeBody {
        /// The bodies.
        bodies: Vec<usize>,
        /// The points that are displaced with them.
        points: Vec<usize>,
        /// The direction.
        along: [Value; 2],
    },
    /// The root of the sum of the squares of two outputs before it.
    Norm([usize; 2]),
}

impl OutputKind {
    /// Whether the output is a reaction force or moment.
    pub fn is_reaction(&self) -> bool {
        self.reaction_of().is_some() || matches!(self, Self::FreeBody { .. } | Self::Norm(_))
    }

    /// All formulae of the output.
    pub fn formulae(&self) -> &[Value] {
        match self {
            Self::Value(value) | Self::Rate(value) | Self::SecondRate(value) => std::slice::from_ref(value),
            Self::ReactionForce { along, .. } | Self::FreeBody { along, .. } => along,
            Self::ReactionMoment { .. } | Self::LoadPower(_) | Self::DrivePower(_) | Self::Norm(_) => &[],
        }
    }

    /// The constraint of a reaction; `None` for other outputs.
    pub fn reaction_of(&self) -> Option<usize> {
        match self {
            Self::ReactionForce { constraint, .. } | Self::ReactionMoment { constraint, .. } => Some(*constraint),
            _ => None,
        }
    }

    /// Whether the output is a rate or a power, which says nothing at rest.
    pub fn needs_motion(&self) -> bool {
        matches!(self, Self::Rate(_) | Self::SecondRate(_) | Self::LoadPower(_))
    }
}
