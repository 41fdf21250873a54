//! The state of a motion at one time.

use qrm_core::{Mechanism, RowLayout, StateRef};

/// A state on the constraints, with its accelerations and multipliers.
#[derive(Debug, Default, PartialEq)]
pub struct State {
    /// Time, in s.
    pub t: f64,
    /// Coordinates, in rad or m.
    pub q: Vec<f64>,
    /// Rates.
    pub qd: Vec<f64>,
    /// Accelerations.
    pub qdd: Vec<f64>,
    /// Multipliers.
    pub multipliers: Vec<f64>,
    /// The number of corrections of the coordinates in the step that ended here.
    pub corrections: u32,
}

/// The state in a row: see [`RowLayout`].
pub(crate) fn state_in(layout: RowLayout, row: &[f64]) -> StateRef<'_> {
    let RowLayout { n, m } = layout;
    StateRef {
        t: row[0],
        q: &row[1..=n],
        qd: &row[1 + n..=2 * n],
        qdd: &row[1 + 2 * n..=3 * n],
        multipliers: &row[1 + 3 * n..=3 * n + m],
    }
}

impl Clone for State {
    fn clone(&self) -> Self {
        let Self { t, q, qd, qdd, multipliers, corrections } = self;
        Self {
            t: *t,
            q: q.clone(),
            qd: qd.clone(),
            qdd: qdd.clone(),
            multipliers: multipliers.clone(),
            corrections: *corrections,
        }
    }

    /// Copies another state without a new allocation.
    fn clone_from(&mut self, other: &Self) {
        self.t = other.t;
        self.q.clone_from(&other.q);
        self.qd.clone_from(&other.qd);
        self.qdd.clone_from(&other.qdd);
        self.multipliers.clone_from(&other.multipliers);
        self.corrections = other.corrections;
    }
}

impl State {
    /// Creates a state of `n` coordinates and `m` constraints, all zero.
    pub fn zero(n: usize, m: usize) -> Self {
        Self { t: 0.0, q: vec![0.0; n], qd: vec![0.0; n], qdd: vec![0.0; n], multipliers: vec![0.0; m], corrections: 0 }
    }

    /// Reads the state of a row: see [`RowLayout`].
    pub fn from_row(layout: RowLayout, row: &[f64]) -> Self {
        let mut state = Self::zero(layout.n, layout.m);
        state.read(row);
        state
    }

    /// Replaces the state by that of a row.
    pub fn read(&mut self, row: &[f64]) {
        let n = self.q.len();
        self.t = row[0];
        self.q.copy_from_slice(&row[1..=n]);
        self.qd.copy_from_slice(&row[1 + n..=2 * n]);
        self.qdd.copy_from_slice(&row[1 + 2 * n..=3 * n]);
        let end = 1 + 3 * n + self.multipliers.len();
        self.multipliers.copy_from_slice(&row[1 + 3 * n..end]);
        // A row of a batch ends with the multipliers.
        self.corrections = row.get(end).map_or(0, |corrections| *corrections as u32);
    }

    /// Writes the state into a row.
    pub fn write(&self, row: &mut [f64]) {
        let n = self.q.len();
        row[0] = self.t;
        row[1..=n].copy_from_slice(&self.q);
        row[1 + n..=2 * n].copy_from_slice(&self.qd);
        row[1 + 2 * n..=3 * n].copy_from_slice(&self.qdd);
        let end = 1 + 3 * n + self.multipliers.len();
        row[1 + 3 * n..end].copy_from_slice(&self.multipliers);
        if let Some(corrections) = row.get_mut(end) {
            *corrections = f64::from(self.corrections);
        }
    }

    /// Moves coordinates and rates by a short time along their Taylor series up to the accelerations.
    pub(crate) fn move_along(&mut self, h: f64) {
        self.t += h;
        for i in 0..self.q.len() {
            self.q[i] += h * (self.qd[i] + 0.5 * h * self.qdd[i]);
            self.qd[i] += h * self.qdd[i];
        }
    }

    /// The state after a short time, by [`State::move_along`].
    pub(crate) fn moved_along(&self, h: f64) -> Self {
        let mut moved = self.clone();
        moved.move_along(h);
        moved
    }

    /// The kinetic energy and the potential of the conservative loads, in J.
    pub(crate) fn energy(&self, mechanism: &dyn Mechanism) -> f64 {
        mechanism.energy(&self.q, &self.qd).iter().sum()
    }

    /// The power of the loads without potential, in W.
    pub(crate) fn power(&self, mechanism: &dyn Mechanism) -> f64 {
        mechanism.power(self.t, &self.q, &self.qd, &self.qdd, &self.multipliers)
    }

    /// The state as an argument of a mechanism's functions.
    pub(crate) fn as_ref(&self) -> StateRef<'_> {
        let Self { t, q, qd, qdd, multipliers, .. } = self;
        StateRef { t: *t, q, qd, qdd, multipliers }
    }

    /// Whether all numbers are finite.
    pub fn is_finite(&self) -> bool {
        let parts = [&self.q, &self.qd, &self.qdd, &self.multipliers];
        parts.into_iter().flatten().all(|value| value.is_finite())
    }
}
