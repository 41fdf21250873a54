//! An integration method.

use qrm_core::Mechanism;

use super::step_formula::StepFormula;
use super::tableau::Tableau;

/// Creates the formula of a method for a mechanism.
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
    /// Whether the method differs from others only in scenes with `stiff = true`.
    pub is_for_stiff: bool,
    /// Whether the scene must give the derivatives of its equations of motion (`stiff = true`).
    pub needs_linearization: bool,
    /// The tableau of its explicit steps, if it makes any.
    pub(super) tableau: Option<&'static Tableau>,
    /// The formula of a method that chooses its steps; `None` for steps of a fixed length.
    pub(super) formula: Option<NewFormula>,
}

impl Method {
    /// Whether the method chooses its steps by a tolerance.
    pub fn is_adaptive(&self) -> bool {
        self.formula.is_some()
    }

    /// Whether sweeps make its steps in lanes.
    pub fn has_lanes(&self) -> bool {
        self == super::DOP853 || self == super::AUTO
    }
}

impl PartialEq for Method {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}
