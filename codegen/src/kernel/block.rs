//! The parts of the computation of a kernel.

/// The parts of a kernel's computation, in order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Block {
    /// Named roots and their slopes.
    Roots,
    /// Other named quantities and their slopes.
    Names,
    /// Constraint residuals, C.
    Constraints,
    /// Constraint Jacobian, C_q.
    Jacobian,
    /// Mass matrix, Mbar.
    Mass,
    /// Tangents T of the constraints, with C_q T = 0.
    Tangents,
    /// Reduced inertia of the independent coordinates, T' Mbar T.
    Inertia,
    /// Accelerations per unit multiplier, Mbar^-1 C_q'.
    InverseMassJacobian,
    /// Matrix of the range-space method, C_q Mbar^-1 C_q'.
    RangeSpaceMatrix,
    /// Rates of named roots.
    Rates,
    /// Rates of other named quantities.
    NamedRates,
    /// Bias of the constraints, (C_q qd)_q qd.
    Bias,
    /// Generalized forces, fbar.
    Forces,
    /// Accelerations, qdd.
    Accelerations,
    /// Multipliers, lambda.
    Multipliers,
    /// Normal forces N, and the contribution of friction to accelerations and multipliers.
    Friction,
    /// Correction of the coordinates.
    Correction,
    /// Inverse dynamics, Mbar qdd + C_q' lambda - fbar.
    Inverse,
}

impl Block {
    /// Whether the block depends on the position alone.
    pub fn is_position(self) -> bool {
        self <= Self::RangeSpaceMatrix
    }

    /// The title of the block as a comment.
    pub fn title(self) -> &'static str {
        match self {
            Self::Roots => "Lengths, and their derivatives.",
            Self::Names => "Points and angles, and their derivatives.",
            Self::Constraints => "The residuals of the constraints: C.",
            Self::Jacobian => "The constraint Jacobian C_q.",
            Self::Mass => "The reduced mass matrix Mbar.",
            Self::Tangents => "How dependent coordinates follow the others: C_q T = 0.",
            Self::Inertia => "What moves with the others: Mbar T, and T' Mbar T.",
            Self::InverseMassJacobian => "What the forces of the loops do: Mbar = L D L', Mbar^-1 C_q'.",
            Self::RangeSpaceMatrix => "How the loops resist: C_q Mbar^-1 C_q' = L D L'.",
            Self::Rates => "Rates of the lengths.",
            Self::NamedRates => {
                "Rates of points and angles, and what their second rates have beside the accelerations."
            }
            Self::Bias => "Convective terms of the loops: (C_q qd)_q qd.",
            Self::Forces => "The reduced forces fbar.",
            Self::Accelerations => "Accelerations.",
            Self::Multipliers => "Multipliers.",
            Self::Friction => "Normal forces of friction, and what friction adds.",
            Self::Inverse => "Forces and torques along the coordinates that move freely.",
            Self::Correction => "The correction: no motion that the loops allow is part of it.",
        }
    }
}
