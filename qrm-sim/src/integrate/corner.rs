//! A corner of the equations of motion, and the times just before and after it.

/// The relative difference below which times are equal.
pub(super) const EQUAL: f64 = 16.0 * f64::EPSILON;

/// The time at which the equations of motion have a corner or a jump.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Corner(pub(crate) f64);

impl Corner {
    /// The shortest distance of a step from `t` to a corner.
    pub(crate) fn resolution(t: f64) -> f64 {
        4.0 * equal(t)
    }

    /// The end of a step towards the corner: no stage lies behind it yet.
    pub(crate) fn just_before(self) -> f64 {
        self.0 - equal(self.0)
    }

    /// The beginning of a step from the corner.
    pub(crate) fn just_after(self) -> f64 {
        self.0 + equal(self.0)
    }
}

/// The distance within which times are equal.
pub(super) fn equal(t: f64) -> f64 {
    (EQUAL * t.abs()).max(f64::MIN_POSITIVE)
}
