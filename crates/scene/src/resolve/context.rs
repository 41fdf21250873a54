//! The names that formulae may contain, by context.

/// The kinds of formulae, by the names that they may contain.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub(super) enum Context {
    /// Numbers and parameters.
    Constant,
    /// Also the length along which a load acts.
    Potential,
    /// Also the polar angle in the frame of a cam.
    Profile,
    /// Also coordinates, points and time; the formula will be differentiated.
    Geometry,
    /// Numbers, parameters, coordinates, points and time; the formula will not be differentiated.
    Picture,
    /// Also rates; the formula must be continuous except for jumps.
    Load,
    /// Also the length along which the load acts, and its rate.
    Law,
    /// Everything except that length and rate, and also results of a motion; functions need not be differentiable.
    Condition,
}
