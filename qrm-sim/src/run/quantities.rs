//! The quantities of a motion whose errors are estimated, and their differences between two runs.

use std::ops::Range;

use qrm_core::{Description, Mechanism, RowLayout};

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

    /// Writes the quantities in a row of states.
    pub(crate) fn write(self, mechanism: &dyn Mechanism, layout: RowLayout, row: &[f64], to: &mut [f64]) {
        let RowLayout { n, m } = layout;
        let motion = 3 * n + m;
        to[..motion].copy_from_slice(&row[1..=motion]);
        let (q, qd, qdd) = (&row[1..=n], &row[1 + n..=2 * n], &row[1 + 2 * n..=3 * n]);
        let multipliers = &row[1 + 3 * n..=motion];
        if self.outputs > 0 {
            mechanism.outputs(row[0], q, qd, qdd, multipliers, &mut to[motion..motion + self.outputs]);
        }
        to[motion + self.outputs] = mechanism.energy(q, qd).iter().sum();
    }
}

/// The differences of quantities between two runs of one motion.
#[derive(Clone, Debug)]
pub(crate) struct Differences {
    /// Whether the runs were compared at all.
    pub(crate) has_met: bool,
    /// The largest one in any row.
    pub(crate) largest: Vec<f64>,
    /// The largest ones in the row where the quantity is smallest and those beside it, and around the largest value.
    pub(crate) at_extremes: Vec<[f64; 2]>,
    /// Whether the last row was one of these.
    is_extreme: Vec<[bool; 2]>,
    /// Those in the last row.
    pub(crate) latest: Vec<f64>,
    /// The smallest and the largest value of each quantity.
    pub(crate) ranges: Vec<[f64; 2]>,
}

impl Differences {
    /// Begins at quantities that both runs share.
    pub(crate) fn new(first: &[f64]) -> Self {
        let zero = vec![0.0; first.len()];
        Self {
            has_met: false,
            largest: zero.clone(),
            at_extremes: vec![[0.0; 2]; first.len()],
            // The first row may be both.
            is_extreme: vec![[true; 2]; first.len()],
            latest: zero,
            ranges: first.iter().map(|value| [*value; 2]).collect(),
        }
    }

    /// Compares the quantities of a run with those of another one.
    pub(crate) fn take(&mut self, of_run: &[f64], of_other: &[f64]) {
        self.has_met = true;
        for (i, (value, other)) in of_run.iter().zip(of_other).enumerate() {
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
