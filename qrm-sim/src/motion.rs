//! The state of a motion under way, step by step.

use qrm_core::Mechanism;

use crate::acceleration::evaluate;
use crate::linear::Vector;
use crate::projection::{NotConverged, Projection, Tolerance, project};
use crate::rk4;
use crate::solve::{Care, Undetermined};

/// How steps are made.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Method {
    /// The formula, and how its step is chosen.
    pub scheme: Scheme,
    /// Metric of the projection after each step.
    pub projection: Projection,
    /// When a projection is good enough.
    pub tolerance: Tolerance,
}

/// Runge-Kutta formulae.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Scheme {
    /// The classical formula of order 4, with steps of the length of the request.
    #[default]
    Rk4,
    /// The same as the assignment's script does it, with what it does to the rows: see [`document`](crate::document).
    Document,
    /// Dormand and Prince's pair of order 5, with steps of its own choice and rows by dense output.
    Dopri5 {
        /// Largest error of a step, in the unit of each coordinate and rate.
        tolerance: f64,
    },
    /// The pair of order 8, likewise.
    Dop853 {
        /// Largest error of a step, in the unit of each coordinate and rate.
        tolerance: f64,
    },
    /// The pair of order 8 where the motion is not stiff, RODAS where it is and the mechanism has its derivatives.
    Auto {
        /// Largest error of a step, in the unit of each coordinate and rate.
        tolerance: f64,
    },
    /// The linearly implicit method RODAS of order 4, likewise.
    Rodas {
        /// Largest error of a step, in the unit of each coordinate and rate.
        tolerance: f64,
    },
}

impl Scheme {
    /// The largest error of a step, if the method chooses its steps by it.
    pub fn tolerance(self) -> Option<f64> {
        match self {
            Self::Rk4 | Self::Document => None,
            Self::Dopri5 { tolerance }
            | Self::Dop853 { tolerance }
            | Self::Rodas { tolerance }
            | Self::Auto { tolerance } => Some(tolerance),
        }
    }
}

/// A corrected state with the accelerations and multipliers that belong to it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moment<const N: usize, const M: usize> {
    /// Time.
    pub t: f64,
    /// Coordinates.
    pub q: Vector<N>,
    /// Rates.
    pub qd: Vector<N>,
    /// Accelerations.
    pub qdd: Vector<N>,
    /// Multipliers.
    pub multipliers: Vector<M>,
    /// How often the coordinates were corrected after the step to here.
    pub corrections: u32,
}

/// Why a step could not be made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Breakdown {
    /// The projection did not converge.
    NotConverged(NotConverged),
    /// No inertia resists a motion of this coordinate that the constraints allow.
    Massless(usize),
    /// Steps of the method's choice became so short that time stands still.
    StepTooShort {
        /// The last one.
        h: f64,
    },
    /// Steps of the method's choice are so short against the rows that the run would not end.
    TooManySteps {
        /// How many were tried.
        attempts: u64,
        /// The last one.
        h: f64,
    },
    /// A number became infinite or undefined.
    NotFinite,
    /// The method needs derivatives that the scene does not ask for.
    NoLinearization,
}

impl Method {
    /// The method of a second run that tells the error of a first one; fixed steps it makes in pairs.
    pub(crate) fn shadow(&self) -> Self {
        let scheme = match self.scheme {
            Scheme::Rk4 | Scheme::Document => self.scheme,
            Scheme::Dopri5 { tolerance } => Scheme::Dopri5 { tolerance: 0.1 * tolerance },
            Scheme::Dop853 { tolerance } => Scheme::Dop853 { tolerance: 0.1 * tolerance },
            Scheme::Rodas { tolerance } => Scheme::Rodas { tolerance: 0.1 * tolerance },
            Scheme::Auto { tolerance } => Scheme::Auto { tolerance: 0.1 * tolerance },
        };
        Self { scheme, ..*self }
    }
}

impl From<NotConverged> for Breakdown {
    fn from(e: NotConverged) -> Self {
        if e.residual.is_finite() { Self::NotConverged(e) } else { Self::NotFinite }
    }
}

impl From<Undetermined> for Breakdown {
    fn from(e: Undetermined) -> Self {
        match e {
            Undetermined::Massless(coordinate) => Self::Massless(coordinate),
            Undetermined::NotFinite => Self::NotFinite,
        }
    }
}

/// Completes a state to a moment.
///
/// # Errors
/// The accelerations are not determined, or not finite.
#[inline(always)]
pub fn moment<X: Mechanism<N, M>, const N: usize, const M: usize>(
    mechanism: &X,
    t: f64,
    q: Vector<N>,
    qd: Vector<N>,
    care: &mut Care,
) -> Result<Moment<N, M>, Breakdown> {
    let (qdd, multipliers) = evaluate(mechanism, t, &q, &qd, care)?;
    let is_finite = [&q, &qd, &qdd].into_iter().all(all_finite) && all_finite(&multipliers);
    if is_finite { Ok(Moment { t, q, qd, qdd, multipliers, corrections: 0 }) } else { Err(Breakdown::NotFinite) }
}

#[inline(always)]
fn all_finite<const N: usize>(x: &Vector<N>) -> bool {
    let mut sum = 0.0;
    // Zero times a number that is not finite is not a number, and stays so in a sum.
    for value in x {
        sum += value * 0.0;
    }
    sum == 0.0
}

/// The moment after a step that ends at `t_next`.
///
/// # Errors
/// The step could not be made.
#[inline(always)]
pub fn advance<X: Mechanism<N, M>, const N: usize, const M: usize>(
    mechanism: &X,
    method: &Method,
    from: &Moment<N, M>,
    t_next: f64,
    care: &mut Care,
) -> Result<Moment<N, M>, Breakdown> {
    let (mut q, mut qd, mass) = rk4::step(mechanism, from.t, t_next - from.t, (&from.q, &from.qd, &from.qdd), care)?;
    let projection = (method.projection, method.tolerance);
    let corrections = project(mechanism, projection, mass.as_ref(), t_next, &mut q, &mut qd, care)?;
    Ok(Moment { corrections, ..moment(mechanism, t_next, q, qd, care)? })
}
