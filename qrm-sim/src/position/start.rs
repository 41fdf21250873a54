//! The start of a motion, as the scene asks for it.

use qrm_core::{Description, Mechanism, StartMut};

/// The start of a motion: some values are given, the others are first guesses (rates: unused) until they are solved
/// for.
#[derive(Clone, Debug, PartialEq)]
pub struct Start {
    /// Coordinates.
    pub q: Vec<f64>,
    /// For each coordinate, whether it is given.
    pub given: Vec<bool>,
    /// Rates.
    pub qd: Vec<f64>,
    /// For each rate, whether it is given.
    pub given_rates: Vec<bool>,
}

impl Start {
    /// The start that the scene of a mechanism asks for.
    pub fn new(mechanism: &dyn Mechanism) -> Self {
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

    /// Gives a coordinate, or a rate such as `phi_dot`, another value; `None` if it is not given, so that it follows
    /// from the others.
    pub fn set(&mut self, description: &Description, name: &str, value: f64) -> Option<()> {
        let place = |name: &str| description.coordinates.iter().position(|coordinate| coordinate.name == name);
        let rate = || name.strip_suffix("_dot").and_then(place);
        let (place, values, given) = match place(name) {
            Some(place) => (place, &mut self.q, &self.given),
            None => (rate()?, &mut self.qd, &self.given_rates),
        };
        given[place].then(|| values[place] = value)
    }

    /// The coordinates and rates that are given, by their names.
    pub fn given_values(&self, description: &Description) -> Vec<(String, f64)> {
        let named = |values: &[f64], given: &[bool], suffix: &str| -> Vec<(String, f64)> {
            let given = description.coordinates.iter().zip(values).zip(given).filter(|(_, given)| **given);
            given.map(|((coordinate, value), _)| (format!("{}{suffix}", coordinate.name), *value)).collect()
        };
        [named(&self.q, &self.given, ""), named(&self.qd, &self.given_rates, "_dot")].concat()
    }
}
