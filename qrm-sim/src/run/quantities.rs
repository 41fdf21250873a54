//! The quantities of a motion whose errors are estimated, and their differences between two runs.

use std::ops::Range;

use qrm_core::{Description, Mechanism, StateRef};

use crate::columns::Kind;

/// The numbers of coordinates, constraints and outputs of a mechanism: its quantities are coordinates, rates,
/// accelerations, multipliers, outputs and the energy, in this order.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Quantities {
    pub(super) n: usize,
    m: usize,
    outputs: usize,
}

impl Quantities {
    pub(crate) fn new(description: &Description, has_outputs: bool) -> Self {
        let outputs = if has_outputs { description.outputs.len() } else { 0 };
        Self { n: description.coordinates.len(), m: description.constraints.len(), outputs }
    }

    pub(crate) fn count(self) -> usize {
        3 * self.n + self.m + self.outputs + 1
    }

    /// The places of quantities of one kind, that are computed from each other; each output by itself.
    pub(crate) fn groups(self) -> Vec<Range<usize>> {
        let Self { n, m, outputs } = self;
        let motion = (0..3).map(|order| order * n..(order + 1) * n);
        let multipliers = 3 * n..3 * n + m;
        let others = (3 * n + m..=3 * n + m + outputs).map(|i| i..i + 1);
        motion.chain([multipliers]).chain(others).collect()
    }

    /// The place of a quantity; `None` if errors of it are not estimated.
    pub(super) fn place(self, kind: Kind) -> Option<usize> {
        let Self { n, m, outputs } = self;
        match kind {
            Kind::Coordinate(i) => Some(i),
            Kind::Rate(i) => Some(n + i),
            Kind::Acceleration(i) => Some(2 * n + i),
            Kind::Multiplier(i) => Some(3 * n + i),
            Kind::Output(i) => (i < outputs).then_some(3 * n + m + i),
            Kind::Energy => Some(3 * n + m + outputs),
            Kind::Time | Kind::Parameter(_) | Kind::Residual | Kind::ResidualRate => None,
        }
    }

    /// Writes the quantities of a state.
    fn write(self, mechanism: &dyn Mechanism, at: &StateRef, to: &mut [f64]) {
        let StateRef { t, q, qd, qdd, multipliers } = *at;
        let motion = [q, qd, qdd, multipliers].into_iter().flatten();
        to.iter_mut().zip(motion).for_each(|(to, number)| *to = *number);
        let (outputs, energy) = to[3 * self.n + self.m..].split_at_mut(self.outputs);
        if !outputs.is_empty() {
            mechanism.outputs(t, q, qd, qdd, multipliers, outputs);
        }
        energy[0] = mechanism.energy(q, qd).iter().sum();
    }
}

/// Rows at which the effect of rounding errors is looked at.
const PROBES: usize = 16;

/// The differences of quantities between two runs of one motion.
#[derive(Clone, Debug)]
pub(crate) struct Differences {
    pub(crate) quantities: Quantities,
    /// The quantities of both runs in the same row.
    compared: [Vec<f64>; 2],
    /// Whether the runs were compared at all.
    pub(crate) has_met: bool,
    /// The largest difference in any row.
    pub(crate) largest: Vec<f64>,
    /// The largest difference in the row where the quantity is smallest and those beside it, and around the largest value.
    pub(crate) at_extremes: Vec<[f64; 2]>,
    /// Whether the last row was the one with an extreme.
    is_extreme: Vec<[bool; 2]>,
    /// The difference in the last row.
    pub(crate) latest: Vec<f64>,
    /// The smallest and the largest value of each quantity.
    pub(crate) ranges: Vec<[f64; 2]>,
    /// The largest change of each quantity where the coordinates change by rounding errors.
    pub(crate) noise: Vec<f64>,
    /// Rows at which that is still to be looked at.
    probes: usize,
}

impl Differences {
    /// Begins at a state that both runs share.
    pub(crate) fn new(quantities: Quantities, mechanism: &dyn Mechanism, first: &StateRef) -> Self {
        let zero = vec![0.0; quantities.count()];
        let mut numbers = zero.clone();
        quantities.write(mechanism, first, &mut numbers);
        Self {
            quantities,
            has_met: false,
            largest: zero.clone(),
            at_extremes: vec![[0.0; 2]; zero.len()],
            // The first row may be both.
            is_extreme: vec![[true; 2]; zero.len()],
            latest: zero.clone(),
            ranges: numbers.iter().map(|value| [*value; 2]).collect(),
            noise: zero.clone(),
            probes: PROBES,
            compared: [numbers, zero],
        }
    }

    /// Compares a row of a run with that of another one.
    pub(crate) fn take(&mut self, mechanism: &dyn Mechanism, of_run: &StateRef, of_other: &StateRef) {
        self.has_met = true;
        self.quantities.write(mechanism, of_run, &mut self.compared[0]);
        self.quantities.write(mechanism, of_other, &mut self.compared[1]);
        for (i, (value, other)) in self.compared[0].iter().zip(&self.compared[1]).enumerate() {
            let difference = (value - other).abs();
            self.largest[i] = self.largest[i].max(difference);
            let around = difference.max(std::mem::replace(&mut self.latest[i], difference));
            let [low, high] = &mut self.ranges[i];
            let is_extreme = [value < low, value > high];
            (*low, *high) = (low.min(*value), high.max(*value));
            for end in 0..2 {
                let at = &mut self.at_extremes[i][end];
                if is_extreme[end] {
                    *at = around;
                } else if self.is_extreme[i][end] {
                    *at = at.max(difference);
                }
            }
            self.is_extreme[i] = is_extreme;
        }
        if let Some(probes) = self.probes.checked_sub(1) {
            self.probes = probes;
            self.probe(mechanism, of_run);
        }
    }

    /// Looks at what rounding errors of the coordinates in a row of the run change, whose quantities were written last.
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
        for ((noise, own), other) in self.noise.iter_mut().zip(of_run).zip(of_other) {
            *noise = noise.max((*own - *other).abs());
        }
    }

    /// Begins anew, and returns the largest differences so far.
    pub(crate) fn restart(&mut self) -> Vec<f64> {
        self.at_extremes.fill([0.0; 2]);
        self.is_extreme.fill([true; 2]);
        self.latest.fill(0.0);
        let zero = vec![0.0; self.largest.len()];
        std::mem::replace(&mut self.largest, zero)
    }
}
