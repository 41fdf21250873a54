//! Dense output: the motion inside a step.

use qrm_core::dop853::Row;

use super::tableau::Tableau;
use crate::solve::Matrix;
use crate::state::State;

/// The derivatives at the stages of a step: rates, and accelerations.
#[derive(Clone, Debug)]
pub(super) struct Stages {
    pub(super) rates: Matrix,
    pub(super) accelerations: Matrix,
}

impl Stages {
    /// Creates buffers for the stages of a method, including the end of the step and those of the dense output.
    pub(super) fn new(tableau: &Tableau, n: usize) -> Self {
        let count = tableau.rows.len().max(tableau.stages + 1);
        Self { rates: Matrix::zero(count, n), accelerations: Matrix::zero(count, n) }
    }

    /// The sums of rates and of accelerations over the stages of a row.
    pub(super) fn sum(&self, row: Row, rate: &mut [f64], acceleration: &mut [f64]) {
        rate.fill(0.0);
        acceleration.fill(0.0);
        for &(stage, weight) in row {
            let (rates, accelerations) = (&self.rates[stage], &self.accelerations[stage]);
            for i in 0..rate.len() {
                rate[i] += weight * rates[i];
                acceleration[i] += weight * accelerations[i];
            }
        }
    }
}

/// The polynomial between the projected ends of a step.
#[derive(Clone, Debug)]
pub(super) struct DenseOutput {
    /// The state at the beginning of the step.
    pub(super) from: State,
    /// The state at the end of the step.
    pub(super) to: State,
    /// The higher coefficients, coordinates first, then rates; set on first use.
    higher: Vec<f64>,
}

impl DenseOutput {
    pub(super) fn new(from: State, to: State) -> Self {
        Self { from, to, higher: Vec::new() }
    }

    /// Advances to the step that begins where this one ends.
    pub(super) fn go_on(&mut self, to: &mut State) {
        std::mem::swap(&mut self.from, &mut self.to);
        std::mem::swap(&mut self.to, to);
        self.higher.clear();
    }

    /// Whether the higher coefficients of the dense output of a method are missing.
    pub(super) fn lacks(&self, tableau: &Tableau) -> bool {
        !tableau.dense.is_empty() && self.higher.is_empty()
    }

    /// Computes the higher coefficients from complete stages.
    pub(super) fn complete_by(&mut self, tableau: &Tableau, stages: &Stages) {
        let (h, n) = (self.to.t - self.from.t, self.from.q.len());
        self.higher.resize(2 * tableau.dense.len() * n, 0.0);
        let (of_q, of_qd) = self.higher.split_at_mut(tableau.dense.len() * n);
        // A scene may have no coordinates.
        let size = n.max(1);
        for (row, (q, qd)) in tableau.dense.iter().zip(of_q.chunks_exact_mut(size).zip(of_qd.chunks_exact_mut(size))) {
            stages.sum(row, q, qd);
        }
        self.higher.iter_mut().for_each(|x| *x *= h);
    }

    /// Stores the higher coefficients.
    pub(super) fn complete(&mut self, higher: &[f64]) {
        self.higher.clear();
        self.higher.extend_from_slice(higher);
    }

    /// Coordinates and rates at a time inside.
    pub(super) fn at(&self, t: f64, q: &mut [f64], qd: &mut [f64]) {
        let (a, b) = (&self.from, &self.to);
        let h = b.t - a.t;
        let s = (t - a.t) / h;
        if self.higher.is_empty() {
            for i in 0..q.len() {
                [q[i], qd[i], _] = fifth(s, h, [a, b], i);
            }
        } else {
            let (of_q, of_qd) = self.higher.split_at(self.higher.len() / 2);
            seventh(s, h, (&a.q, &a.qd), (&b.q, &b.qd), of_q, q);
            seventh(s, h, (&a.qd, &a.qdd), (&b.qd, &b.qdd), of_qd, qd);
        }
    }
}

/// The polynomial of degree 7 through both ends and the derivatives there; its other coefficients are given.
fn seventh(s: f64, h: f64, (x0, d0): (&[f64], &[f64]), (x1, d1): (&[f64], &[f64]), higher: &[f64], result: &mut [f64]) {
    let (r, n) = (1.0 - s, x0.len());
    for (i, value) in result.iter_mut().enumerate() {
        let change = x1[i] - x0[i];
        let bend = h * d0[i] - change;
        let twist = change - h * d1[i] - bend;
        let inner = higher[i] + s * (higher[n + i] + r * (higher[2 * n + i] + s * higher[3 * n + i]));
        *value = x0[i] + s * (change + r * (bend + s * (twist + r * inner)));
    }
}

/// The state inside a step by the polynomial of degree 5, with the multipliers of its beginning.
pub(crate) fn quintic(from: &State, to: &State, t: f64) -> State {
    let mut at = from.clone();
    let h = to.t - from.t;
    for i in 0..at.q.len() {
        [at.q[i], at.qd[i], at.qdd[i]] = fifth((t - from.t) / h, h, [from, to], i);
    }
    at.t = t;
    at
}

/// The polynomial of degree 5 through a coordinate, its rate and its acceleration at both ends, with two derivatives.
fn fifth(s: f64, h: f64, ends: [&State; 2], i: usize) -> [f64; 3] {
    let [c0, c1, c2, c3, c4, c5] = quintic_coefficients(h, ends, i);
    [
        c0 + s * (c1 + s * (c2 + s * (c3 + s * (c4 + s * c5)))),
        ends[0].qd[i] + s * (2.0 * c2 + s * (3.0 * c3 + s * (4.0 * c4 + s * 5.0 * c5))) / h,
        (2.0 * c2 + s * (6.0 * c3 + s * (12.0 * c4 + s * 20.0 * c5))) / (h * h),
    ]
}

/// The coefficients of that polynomial, in powers of the part of the step.
pub(crate) fn quintic_coefficients(h: f64, [a, b]: [&State; 2], i: usize) -> [f64; 6] {
    let (v0, v1, a0, a1) = (h * a.qd[i], h * b.qd[i], h * h * a.qdd[i], h * h * b.qdd[i]);
    let position = b.q[i] - a.q[i] - v0 - 0.5 * a0;
    let rate = v1 - v0 - a0;
    let acceleration = a1 - a0;
    let third = 10.0 * position - 4.0 * rate + 0.5 * acceleration;
    let fourth = -15.0 * position + 7.0 * rate - acceleration;
    let fifth = 6.0 * position - 3.0 * rate + 0.5 * acceleration;
    [a.q[i], v0, 0.5 * a0, third, fourth, fifth]
}
