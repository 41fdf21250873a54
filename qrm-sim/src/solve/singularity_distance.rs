//! The distance of positions from singular ones.

use qrm_core::Mechanism;

use super::matrix::Matrix;
use super::rank::neighbours;
use super::smallest_singular_value::SmallestSingularValue;

/// The smallest singular value, as a fraction of the largest one, below which a row is near a singular position:
/// multipliers keep ten digits there, and lose four more with each tenth of that.
pub(crate) const NEAR: f64 = 0.03;
/// The fraction below which single states are near a singular position, and rounding errors of forces in rows are
/// irregular.
pub(crate) const IRREGULAR: f64 = 0.1;
/// The fraction below which derivatives are lost.
pub(crate) const SINGULAR: f64 = 3e-4;

/// The smallest singular value of `C_q`, compared with its values at other positions.
#[derive(Clone, Debug)]
pub(crate) struct SingularityDistance {
    smallest: SmallestSingularValue,
    /// The last `C_q` whose singular value was computed.
    jacobian: Matrix,
    /// The smallest singular value of it.
    value: f64,
    /// The smallest and the largest such value at any position.
    range: [f64; 2],
}

impl SingularityDistance {
    /// Creates the distance of Jacobians of this size and rank.
    pub(crate) fn new(constraints: usize, coordinates: usize, rank: usize) -> Self {
        Self {
            smallest: SmallestSingularValue::with_rank(constraints, coordinates, rank),
            jacobian: Matrix::zero(constraints, coordinates),
            value: 0.0,
            range: [f64::INFINITY, 0.0],
        }
    }

    /// Begins with a closed position, and with others along the motion from there.
    pub(crate) fn at(mechanism: &dyn Mechanism, rank: usize, t: f64, (q, qd): (&[f64], &[f64])) -> Self {
        let mut distance = Self::new(mechanism.description().constraints.len(), q.len(), rank);
        for jacobian in neighbours(mechanism, t, (q, qd), rank) {
            distance.measure(&jacobian);
        }
        distance.range[0] = f64::INFINITY;
        distance
    }

    /// The smallest singular value of a `C_q`; `None` if it is certainly neither the smallest one so far nor near zero.
    pub(crate) fn find(&mut self, jacobian: &Matrix) -> Option<f64> {
        // A singular value changes at most by the norm of the matrix's change (Weyl).
        let least = self.value - self.jacobian.distance(jacobian);
        let [smallest, largest] = self.range;
        if least > smallest && least > IRREGULAR * largest {
            return None;
        }
        self.measure(jacobian)
    }

    /// The smallest singular value of a `C_q`; `None` without constraints.
    pub(crate) fn measure(&mut self, jacobian: &Matrix) -> Option<f64> {
        let [smallest, largest] = self.range;
        self.value = self.smallest.find(jacobian)?;
        self.jacobian.copy_from(jacobian);
        self.range = [smallest.min(self.value), largest.max(self.value)];
        Some(self.value)
    }

    /// A singular value as a fraction of the largest one, if it is below a limit.
    pub(crate) fn fraction(&self, value: f64, limit: f64) -> Option<f64> {
        Some(value / self.range[1]).filter(|fraction| *fraction < limit)
    }

    /// The smallest singular value of a `C_q` as a fraction of the largest one.
    pub(crate) fn fraction_at(&mut self, jacobian: &Matrix) -> f64 {
        self.measure(jacobian).map_or(1.0, |value| value / self.range[1])
    }

    /// Whether a position came so near a singular one that rounding errors of forces are irregular.
    pub(crate) fn is_irregular(&self) -> bool {
        self.range[0] < IRREGULAR * self.range[1]
    }

    /// The largest value so far.
    pub(crate) fn largest(&self) -> f64 {
        self.range[1]
    }

    /// The normalized combination of constraints with the last value.
    pub(crate) fn combination(&self) -> &[f64] {
        &self.smallest.combination
    }
}
