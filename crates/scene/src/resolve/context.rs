//! Which names a formula may contain.

/// The kinds of formulae, by the names that they may contain.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub(super) enum Context {
    /// Numbers and parameters.
    Constant,
    /// The length that a load acts along too.
    Potential,
    /// The polar angle in the frame of a cam too.
    Profile,
    /// Coordinates, points and time too; it will be differentiated.
    Geometry,
    /// Numbers, parameters, coordinates, points and time; the formula will not be differentiated.
    Picture,
    /// Rates too; it must be continuous but for jumps.
    Load,
    /// The length that the load acts along, and its rate, too.
    Law,
    /// Everything but these, and what follows from a motion, also by functions without derivative.
    Condition,
}
