//! The outputs that may change faster between rows than the motion does.

use std::borrow::Cow;

use qrm_core::{Mechanism, TapeFunction};

use super::function::FunctionBounds;

/// Outputs that are polynomials of lower degree, of the motion and of sines and cosines of angles, change no faster
/// between rows than the motion does.
const SMOOTH_DEGREE: u32 = 4;

/// An output with its bounds.
#[derive(Clone, Debug)]
pub(crate) struct BoundedOutput {
    /// Its number.
    pub(crate) output: usize,
    pub(crate) bounds: FunctionBounds,
}

/// The outputs that may change faster between rows than the motion does; none if the mechanism has no tape.
pub(crate) fn bounded_outputs(mechanism: &dyn Mechanism) -> Vec<BoundedOutput> {
    let Some(tape) = mechanism.tape() else { return Vec::new() };
    let bounded = tape.outputs.results.iter().enumerate().filter_map(|(output, place)| {
        let own = TapeFunction { operations: tape.outputs.operations.clone(), results: Cow::Owned(vec![*place]) };
        let bounds = FunctionBounds::new(tape, &own, mechanism);
        let is_smooth = bounds.degree().is_some_and(|degree| degree <= SMOOTH_DEGREE);
        (!is_smooth).then_some(BoundedOutput { output, bounds })
    });
    bounded.collect()
}
