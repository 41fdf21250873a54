//! The kinds of outputs.

use super::Value;

/// The kinds of outputs.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub enum OutputKind {
    /// A formula of coordinates.
    Value(Value),
    /// The time derivative of a formula of coordinates.
    Rate(Value),
    /// The second time derivative of a formula of coordinates.
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
    /// Moment of a constraint on the bodies that turn with a coordinate: -lambda dC/d(angle).
    ReactionMoment {
        /// The constraint.
        constraint: usize,
        /// The coordinate that is the body's angle.
        coordinate: usize,
    },
    /// The force or moment on bodies other than loads and constraints, by a virtual displacement `(d, w)` of the
    /// bodies: `sum (m a . d + I alpha w) - Q + lambda' dC + sum c lambda + sum k f`, with the work `Q` of loads and
    /// the change `dC` of constraints. It is a force where bodies move, a moment where they turn.
    FreeBody {
        /// The virtual displacements, all made simultaneously.
        displacements: Vec<Displacement>,
        /// Further terms: a constraint and the factor `c` of its multiplier.
        multipliers: Vec<(usize, Value)>,
        /// Further terms: a load along a length and the factor `k` of its force.
        loads: Vec<(usize, Value)>,
    },
    /// Force of the mechanism on the ground along a direction: `sum (m (g - a) + F) . e`, with the external forces `F`.
    ShakingForce([Value; 2]),
    /// Moment of the mechanism on the ground about a point `P`: `sum ((x - P) x (m (g - a)) - I alpha) + sum (x_F - P)
    /// x F`.
    ShakingMoment(usize),
    /// Size of the vector of two earlier outputs.
    Norm {
        /// The outputs that are the components of the vector.
        components: [usize; 2],
        /// The point at which the vector is drawn.
        at: Option<usize>,
    },
}

/// A virtual displacement of bodies and points: by a vector, and by an angle about a point.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub struct Displacement {
    /// The bodies.
    pub bodies: Vec<usize>,
    /// The points.
    pub points: Vec<usize>,
    /// The vector.
    pub along: Option<[Value; 2]>,
    /// The angle.
    pub turn: Option<Turn>,
    /// The change of the place along a slider.
    pub slide: Option<Slide>,
}

/// The change of the place along a slider in a virtual displacement, for formulae that contain its coordinate directly.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub struct Slide {
    /// The size of the change.
    pub size: Value,
    /// The coordinate of the slider.
    pub coordinate: usize,
}

/// The angle of a virtual displacement.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub struct Turn {
    /// The size of the angle.
    pub size: Value,
    /// The point about which the bodies turn.
    pub about: usize,
    /// The coordinate that turns; needed for formulae that contain it directly instead of through points.
    pub angle: Option<usize>,
}

impl OutputKind {
    /// Whether the output is a reaction force or moment.
    pub fn is_reaction(&self) -> bool {
        let is_free_body =
            matches!(self, Self::FreeBody { .. } | Self::ShakingForce(_) | Self::ShakingMoment(_) | Self::Norm { .. });
        is_free_body || self.reaction_of().is_some()
    }

    /// Whether the kind of the output implies a moment.
    pub fn is_moment(&self) -> bool {
        matches!(self, Self::ReactionMoment { .. } | Self::ShakingMoment(_))
    }

    /// All formulae of the output.
    pub fn formulae(&self) -> Vec<&Value> {
        match self {
            Self::Value(value) | Self::Rate(value) | Self::SecondRate(value) => vec![value],
            Self::ReactionForce { along, .. } | Self::ShakingForce(along) => along.iter().collect(),
            Self::FreeBody { displacements, multipliers, loads } => {
                let along = displacements.iter().filter_map(|own| own.along.as_ref()).flatten();
                let turns = displacements.iter().filter_map(|own| own.turn.as_ref()).map(|turn| &turn.size);
                let slides = displacements.iter().filter_map(|own| own.slide.as_ref()).map(|slide| &slide.size);
                along
                    .chain(turns)
                    .chain(slides)
                    .chain(multipliers.iter().chain(loads).map(|(_, factor)| factor))
                    .collect()
            }
            Self::ReactionMoment { .. }
            | Self::ShakingMoment(_)
            | Self::LoadPower(_)
            | Self::DrivePower(_)
            | Self::Norm { .. } => Vec::new(),
        }
    }

    /// The constraint of a reaction; `None` for other outputs.
    pub fn reaction_of(&self) -> Option<usize> {
        match self {
            Self::ReactionForce { constraint, .. } | Self::ReactionMoment { constraint, .. } => Some(*constraint),
            _ => None,
        }
    }

    /// Whether the output is a rate, a power or a formula of rates: such an output carries no information at rest.
    pub fn needs_motion(&self, scene: &super::Scene) -> bool {
        match self {
            Self::Rate(_) | Self::SecondRate(_) | Self::LoadPower(_) | Self::DrivePower(_) => true,
            Self::Value(value) => scene.depends_on_rates(value),
            _ => false,
        }
    }
}
