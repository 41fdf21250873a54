//! The table of integration methods.

use qrm_core::Mechanism;

use super::auto::AUTO;
use super::classical::RK4;
use super::dop853::DOP853;
use super::dopri5::DOPRI5;
use super::gauss::GAUSS;
use super::rodas::RODAS;
use super::step_bounds::StepBounds;
use super::step_formula::StepFormula;
use super::tableau::Tableau;
use crate::solve::{NotConverged, Projection, ProjectionTolerance, Undetermined};

/// Makes the formula of a method for a mechanism.
type NewFormula = fn(&dyn Mechanism) -> Box<dyn StepFormula>;

/// An integration method.
#[derive(Debug)]
pub struct Method {
    /// The name in commands, files and tokens.
    pub name: &'static str,
    /// A one-line description.
    pub doc: &'static str,
    /// Order of a step.
    pub order: u32,
    /// Whether the method differs from others only in scenes that say `stiff = true`.
    pub is_for_stiff: bool,
    /// Whether the scene must give the derivatives of its equations of motion (`stiff = true`).
    pub needs_linearization: bool,
    /// The tableau of its explicit steps, if it makes any.
    pub(super) tableau: Option<&'static Tableau>,
    /// The formula of a method that chooses its steps; `None` for steps of a fixed length.
    pub(super) formula: Option<NewFormula>,
}

/// Every method; the first is the default.
pub static METHODS: [&Method; 6] = [RK4, DOPRI5, DOP853, GAUSS, RODAS, AUTO];

/// The method of this name.
pub fn method_named(name: &str) -> Option<&'static Method> {
    METHODS.into_iter().find(|method| method.name == name)
}

impl Method {
    /// Whether the method chooses its steps by a tolerance.
    pub fn is_adaptive(&self) -> bool {
        self.formula.is_some()
    }
}

impl PartialEq for Method {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

/// A method with its settings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MethodSettings {
    /// The method.
    pub method: &'static Method,
    /// Largest error of a step, in the unit of each coordinate and rate; methods of a fixed step do not use it.
    pub tolerance: f64,
    /// Metric of the projection after each step.
    pub projection: Projection,
    /// Goal of that projection.
    pub projection_tolerance: ProjectionTolerance,
    /// Bounds of steps that the method chooses.
    pub step_bounds: StepBounds,
}

impl Default for MethodSettings {
    fn default() -> Self {
        Self {
            method: RK4,
            tolerance: 1e-9,
            projection: Projection::default(),
            projection_tolerance: ProjectionTolerance::default(),
            step_bounds: StepBounds::default(),
        }
    }
}

impl MethodSettings {
    /// A method with a tolerance and the default projection.
    pub fn new(method: &'static Method, tolerance: f64) -> Self {
        Self { method, tolerance, ..Self::default() }
    }

    /// The largest error of a step, if the method chooses its steps by it.
    pub fn tolerance(&self) -> Option<f64> {
        self.method.is_adaptive().then_some(self.tolerance)
    }

    /// Whether rows are made by the generated kernel: RK4 with its projection.
    pub(crate) fn is_by_kernel(&self) -> bool {
        !self.method.is_adaptive() && self.projection.is_by_kernel(&self.projection_tolerance)
    }
}

/// Why a step could not be made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum StepError {
    /// The projection did not converge.
    NotConverged(NotConverged),
    /// No inertia resists a motion of this coordinate that the constraints allow.
    Massless(usize),
    /// The steps became so short that time stands still.
    StepTooShort {
        /// The last one.
        h: f64,
    },
    /// The steps are so short against the rows that the run would not end.
    TooManySteps {
        /// The number of attempts.
        attempts: u64,
        /// The last step.
        h: f64,
    },
    /// A number became infinite or undefined.
    NotFinite,
    /// A force became infinite or undefined.
    ForcesNotFinite,
    /// Friction depends on the forces in joints, and constraints repeat others: the forces are not unique.
    FrictionNotUnique,
    /// The method needs derivatives that the scene does not ask for.
    NoLinearization,
}

impl From<NotConverged> for StepError {
    fn from(e: NotConverged) -> Self {
        if e.residual.is_finite() { Self::NotConverged(e) } else { Self::NotFinite }
    }
}

impl From<Undetermined> for StepError {
    fn from(e: Undetermined) -> Self {
        match e {
            Undetermined::Massless(coordinate) => Self::Massless(coordinate),
            Undetermined::NotFinite => Self::NotFinite,
            Undetermined::ForcesNotFinite => Self::ForcesNotFinite,
        }
    }
}
