//! The differences of quantities between two runs of one motion.

use qrm_core::{Mechanism, StateRef};

use super::extremes::reach;
use super::quantities::Quantities;

/// The effect of rounding errors is measured in rows whose numbers grow by this part.
const PROBE_INTERVAL: f64 = 0.1;

/// The differences of quantities between two runs of one motion.
#[derive(Clone, Debug)]
pub(crate) struct Differences {
    pub(crate) quantities: Quantities,
    /// The difference of each quantity.
    pub(crate) each: Vec<Difference>,
    /// The quantities of both runs in the same row.
    compared: [Vec<f64>; 2],
    /// Whether the runs were ever compared.
    pub(crate) has_met: bool,
    /// The number of compared rows, and that at which the effect of rounding errors is measured next.
    rows: u64,
    next_probe: u64,
}

/// The difference of one quantity between two runs of one motion.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Difference {
    /// The largest difference in any row.
    pub(crate) largest: f64,
    /// The difference in the last row.
    pub(crate) latest: f64,
    /// The smallest and the largest value, and the differences there.
    pub(crate) at_extremes: [(f64, f64); 2],
    /// The values and differences of the turning point that may be smallest, and of that which may be largest, if that
    /// is not the one found.
    pub(crate) rivals: [(f64, f64); 2],
    /// The largest difference beyond the distance of a rival from the extreme so far.
    pub(crate) reach_of_rivals: [f64; 2],
    /// The smallest and the largest value of the quantity.
    pub(crate) range: [f64; 2],
    /// The largest change of the quantity caused by rounding errors of the coordinates.
    pub(crate) noise: f64,
}

impl Difference {
    /// Begins with a value that both runs share and that may be both extremes.
    fn new(value: f64) -> Self {
        Self {
            largest: 0.0,
            latest: 0.0,
            at_extremes: [(value, 0.0); 2],
            rivals: [(f64::INFINITY, 0.0), (f64::NEG_INFINITY, 0.0)],
            reach_of_rivals: [0.0; 2],
            range: [value; 2],
            noise: 0.0,
        }
    }

    /// Records the value and the difference of a turning point that may be an extreme.
    pub(crate) fn note_rival(&mut self, end: usize, rival: (f64, f64)) {
        if reach(end, rival) > reach(end, self.rivals[end]) {
            self.rivals[end] = rival;
        }
    }

    /// Compares a value of a run with that of another run.
    fn take(&mut self, value: f64, other: f64) {
        self.latest = (value - other).abs();
        self.largest = self.largest.max(self.latest);
        let [low, high] = &mut self.range;
        (*low, *high) = (low.min(value), high.max(value));
    }
}

impl Differences {
    /// Begins with a state that both runs share.
    pub(crate) fn new(quantities: Quantities, mechanism: &dyn Mechanism, first: &StateRef) -> Self {
        let zero = vec![0.0; quantities.count()];
        let mut numbers = zero.clone();
        quantities.write(mechanism, first, &mut numbers);
        Self {
            quantities,
            each: numbers.iter().map(|value| Difference::new(*value)).collect(),
            has_met: false,
            rows: 0,
            next_probe: 0,
            compared: [numbers, zero],
        }
    }

    /// Compares a row of a run with that of another run.
    pub(crate) fn take(&mut self, mechanism: &dyn Mechanism, of_run: &StateRef, of_other: &StateRef) {
        self.has_met = true;
        let [own, others] = &mut self.compared;
        self.quantities.write(mechanism, of_run, own);
        self.quantities.write(mechanism, of_other, others);
        for (difference, (value, other)) in self.each.iter_mut().zip(own.iter().zip(others)) {
            difference.take(*value, *other);
        }
        if self.rows >= self.next_probe {
            self.next_probe = self.rows + 1 + (PROBE_INTERVAL * self.rows as f64) as u64;
            self.probe(mechanism, of_run);
        }
        self.rows += 1;
    }

    /// The differences of the quantities between two states.
    pub(crate) fn between(&self, mechanism: &dyn Mechanism, states: [&StateRef; 2]) -> Vec<f64> {
        let [one, other] = states.map(|state| {
            let mut numbers = vec![0.0; self.quantities.count()];
            self.quantities.write(mechanism, state, &mut numbers);
            numbers
        });
        one.iter().zip(&other).map(|(one, other)| (one - other).abs()).collect()
    }

    /// Measures how much rounding errors of the coordinates change the quantities in a row of the run, which were
    /// written last.
    fn probe(&mut self, mechanism: &dyn Mechanism, of_run: &StateRef) {
        let error = |i: usize| if i.is_multiple_of(2) { f64::EPSILON } else { -f64::EPSILON };
        let q: Vec<f64> = of_run.q.iter().enumerate().map(|(i, q)| q * (1.0 + error(i))).collect();
        let (mut qdd, mut multipliers) = (of_run.qdd.to_vec(), of_run.multipliers.to_vec());
        if !mechanism.accelerations(of_run.t, &q, of_run.qd, &mut qdd, &mut multipliers) {
            return;
        }
        let beside = StateRef { q: &q, qdd: &qdd, multipliers: &multipliers, ..*of_run };
        let [of_run, of_other] = &mut self.compared;
        self.quantities.write(mechanism, &beside, of_other);
        for (difference, (own, other)) in self.each.iter_mut().zip(of_run.iter().zip(of_other)) {
            difference.noise = difference.noise.max((*own - *other).abs());
        }
    }

    /// Restarts, and returns the largest differences so far.
    pub(crate) fn restart(&mut self) -> Vec<f64> {
        let largest = self.each.iter().map(|difference| difference.largest).collect();
        for difference in &mut self.each {
            let Difference { range, noise, .. } = *difference;
            *difference = Difference { range, noise, ..Difference::new(0.0) };
        }
        largest
    }
}
