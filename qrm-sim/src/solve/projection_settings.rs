//! The metric and the tolerance of projections.

use qrm_core::MAX_CORRECTIONS;

/// The metric in which a correction is smallest.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Projection {
    /// No correction.
    None,
    /// Smallest change of the coordinates.
    Euclidean,
    /// Smallest change of the mass-weighted coordinates.
    #[default]
    Mass,
}

impl Projection {
    /// All projections by name.
    pub const ALL: [(&'static str, Self); 3] =
        [("none", Self::None), ("euclidean", Self::Euclidean), ("mass", Self::Mass)];

    /// Finds a projection by its name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|(other, _)| *other == name).map(|(_, projection)| projection)
    }

    /// Whether generated kernels support this projection.
    pub(crate) fn is_by_kernel(self, tolerance: &ProjectionTolerance) -> bool {
        self == Self::Mass && tolerance.iterations >= MAX_CORRECTIONS
    }

    /// The name of the projection.
    pub fn name(self) -> &'static str {
        Self::ALL.into_iter().find(|(_, projection)| *projection == self).map_or("", |(name, _)| name)
    }
}

/// The tolerance of a projection of coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProjectionTolerance {
    /// Largest residual of a constraint, in its unit.
    pub residual: f64,
    /// The largest number of iterations.
    pub iterations: u32,
}

impl Default for ProjectionTolerance {
    fn default() -> Self {
        Self { residual: 1e-12, iterations: 10 }
    }
}

/// The projection of coordinates did not converge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NotConverged {
    /// The constraint with the largest residual.
    pub constraint: usize,
    /// The residual of this constraint.
    pub residual: f64,
    /// The number of iterations that were made.
    pub iterations: u32,
}
