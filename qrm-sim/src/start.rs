//! The start of a motion, as the scene asks for it.

use qrm_core::{Mechanism, StartMut};

/// The start of a motion: some values are given, the others are first guesses (rates: unused) until they are solved
/// for.
#[derive(Clone, Debug, PartialEq)]
pub struct Start {
    /// Coordinates.
    pub q: Vec<f64>,
    /// Which of them are given.
    pub given: Vec<bool>,
    /// Rates.
    pub qd: Vec<f64>,
    /// Which of them are given.
    pub given_rates: Vec<bool>,
}

impl Start {
    /// The start that the scene of a mechanism asks for.
    pub fn of(mechanism: &dyn Mechanism) -> Self {
        let n = mechanism.description().coordinates.len();
        let mut start = Self { q: vec![0.0; n], given: vec![false; n], qd: vec![0.0; n], given_rates: vec![false; n] };
        mechanism.start(StartMut {
            q: &mut start.q,
            given: &mut start.given,
            qd: &mut start.qd,
            given_rates: &mut start.given_rates,
        });
        start
    }
}
