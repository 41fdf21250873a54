//! The start of a motion as requested by the scene.

use qrm_core::{Description, Mechanism, StartMut};

/// The start of a motion. Some values are given; the others are first guesses (unused for rates) until they are solved
/// for.
#[derive(Clone, Debug, PartialEq)]
pub struct Start {
    /// Coordinates.
    pub q: Vec<f64>,
    /// Whether each coordinate is given.
    pub given: Vec<bool>,
    /// Rates.
    pub qd: Vec<f64>,
    /// Whether each rate is given.
    pub given_rates: Vec<bool>,
}

impl Start {
    /// The start requested by the scene of a mechanism.
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

    /// Sets a given coordinate, or a given rate such as `phi_dot`; `None` if it is not given and follows from the
    /// others.
    pub fn set(&mut self, description: &Description, name: &str, value: f64) -> Option<()> {
        let place = |name: &str| description.coordinates.iter().position(|coordinate| coordinate.name == name);
        let rate = || name.strip_suffix("_dot").and_then(place);
        let (place, values, given) = match place(name) {
            Some(place) => (place, &mut self.q, &self.given),
            None => (rate()?, &mut self.qd, &self.given_rates),
        };
        given[place].then(|| values[place] = value)
    }

    /// The names and values of the given coordinates and rates.
    pub fn given_values(&self, description: &Description) -> Vec<(String, f64)> {
        let named = |values: &[f64], given: &[bool], suffix: &str| -> Vec<(String, f64)> {
            let given = description.coordinates.iter().zip(values).zip(given).filter(|(_, given)| **given);
            given.map(|((coordinate, value), _)| (format!("{}{suffix}", coordinate.name), *value)).collect()
        };
        [named(&self.q, &self.given, ""), named(&self.qd, &self.given_rates, "_dot")].concat()
    }
}
