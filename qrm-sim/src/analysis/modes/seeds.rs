//! Numbers with derivatives by some of many seeds.

use qrm_core::Scalar;

use crate::differentiated::{Differentiated, PARTS, differentiated};

/// A number with derivatives.
pub(super) type First = Differentiated<f64>;

/// Numbers of these values, without derivatives.
pub(in crate::analysis) fn constants(values: &[f64]) -> Vec<First> {
    values.iter().map(|value| First::from_f64(*value)).collect()
}

/// Numbers of these values, which are the seeds from `first` on, with derivatives by those from `from` on.
pub(in crate::analysis) fn seeded(values: &[f64], first: usize, from: usize) -> Vec<First> {
    let part = |i: usize| (first + i).checked_sub(from).filter(|part| *part < PARTS);
    let number = |(i, value): (usize, &f64)| match part(i) {
        None => First::from_f64(*value),
        Some(part) => differentiated(*value, unit(part)),
    };
    values.iter().enumerate().map(number).collect()
}

/// The derivatives of the seed at a place.
pub(super) fn unit(place: usize) -> [f64; PARTS] {
    std::array::from_fn(|part| if part == place { 1.0 } else { 0.0 })
}
