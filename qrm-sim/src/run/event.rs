//! The location of an event inside a step.

use crate::state::State;

/// The state inside a step at which a value rises through zero, by steps of other lengths from its beginning.
///
/// # Errors
/// A step could not be made.
pub(crate) fn locate<E>(
    from: &State,
    beyond: &State,
    value: impl Fn(&State) -> f64,
    mut step: impl FnMut(f64) -> Result<State, E>,
) -> Result<State, E> {
    let (mut low, mut f_low) = (from.t, value(from));
    let (mut high, mut f_high, mut found) = (beyond.t, value(beyond), beyond.clone());
    for iteration in 0..100 {
        if f_high == 0.0 || high - low <= 2.0 * f64::EPSILON * high.abs() {
            break;
        }
        // Regula falsi, kept from creeping by a bisection every third time.
        let secant = high - f_high * (high - low) / (f_high - f_low);
        let middle = 0.5 * (low + high);
        let t = if iteration % 3 == 2 || !(secant > low && secant < high) { middle } else { secant };
        let at = step(t)?;
        let f = value(&at);
        if f >= 0.0 {
            (high, f_high, found) = (t, f, at);
        } else {
            (low, f_low) = (t, f);
        }
    }
    Ok(found)
}
