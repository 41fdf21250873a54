//! States, and buffers for the results of a mechanism's functions.

/// A state of a mechanism.
#[derive(Clone, Copy, Debug)]
pub struct StateRef<'a> {
    /// Time.
    pub t: f64,
    /// Coordinates, `n`.
    pub q: &'a [f64],
    /// Rates, `n`.
    pub qd: &'a [f64],
    /// Accelerations, `n`.
    pub qdd: &'a [f64],
    /// Multipliers, `m`.
    pub multipliers: &'a [f64],
}

/// Energy and power in a state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RowQuantities {
    /// See [`Mechanism::energy`](crate::Mechanism::energy).
    pub energy: [f64; 2],
    /// See [`Mechanism::power`](crate::Mechanism::power).
    pub power: f64,
}

/// A buffer for the start of a motion. Some values are given; the others are first guesses (unused for rates) until
/// they are solved for.
#[derive(Debug)]
pub struct StartMut<'a> {
    /// Coordinates.
    pub q: &'a mut [f64],
    /// For each coordinate, whether it is given.
    pub given: &'a mut [bool],
    /// Rates.
    pub qd: &'a mut [f64],
    /// For each rate, whether it is given.
    pub given_rates: &'a mut [bool],
}

/// A buffer for the parts of the equations of motion: see [`Dynamics`](crate::Dynamics).
#[derive(Debug)]
pub struct DynamicsMut<'a> {
    /// Mbar, `n` by `n`.
    pub mass_matrix: &'a mut [f64],
    /// fbar, `n`.
    pub generalized_forces: &'a mut [f64],
    /// C_q, `m` by `n`.
    pub constraint_jacobian: &'a mut [f64],
    /// The bias of the constraints, `m`.
    pub constraint_bias: &'a mut [f64],
}

/// A buffer for the loop constraints: see [`LoopConstraints`](crate::LoopConstraints).
#[derive(Debug)]
pub struct LoopConstraintsMut<'a> {
    /// C, `m`.
    pub residuals: &'a mut [f64],
    /// C_q, `m` by `n`.
    pub constraint_jacobian: &'a mut [f64],
    /// C_t, `m`.
    pub constraint_rate: &'a mut [f64],
}

/// A buffer for the derivatives of the equations of motion: see [`Linearization`](crate::Linearization).
#[derive(Debug)]
pub struct LinearizationMut<'a> {
    /// Stiffness, `n` by `n`.
    pub stiffness: &'a mut [f64],
    /// Damping, `n` by `n`.
    pub damping: &'a mut [f64],
    /// Stiffness of the constraints, `m` by `n`.
    pub constraint_stiffness: &'a mut [f64],
    /// Damping of the constraints, `m` by `n`.
    pub constraint_damping: &'a mut [f64],
    /// Forcing, `n`.
    pub forcing: &'a mut [f64],
    /// Forcing of the constraints, `m`.
    pub constraint_forcing: &'a mut [f64],
}
