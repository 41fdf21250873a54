//! The motion inside a step.

use super::pair::{MOST_STAGES, Pair, Row};
use crate::linear::Vector;
use crate::motion::Moment;

/// The derivatives at the stages of a step: rates, and accelerations.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stages<const N: usize> {
    pub(super) rates: [Vector<N>; MOST_STAGES],
    pub(super) accelerations: [Vector<N>; MOST_STAGES],
}

impl<const N: usize> Stages<N> {
    pub(super) fn new() -> Self {
        Self { rates: [[0.0; N]; MOST_STAGES], accelerations: [[0.0; N]; MOST_STAGES] }
    }

    /// Sums of both over the stages.
    #[inline(always)]
    pub(super) fn sum(&self, row: Row) -> (Vector<N>, Vector<N>) {
        let (mut rate, mut acceleration) = ([0.0; N], [0.0; N]);
        for &(stage, weight) in row {
            for i in 0..N {
                rate[i] += weight * self.rates[stage][i];
                acceleration[i] += weight * self.accelerations[stage][i];
            }
        }
        (rate, acceleration)
    }
}

/// A step that was made, between its corrected ends.
#[derive(Clone, Copy, Debug)]
pub struct Segment<const N: usize, const M: usize> {
    /// Its beginning.
    pub from: Moment<N, M>,
    /// Its end.
    pub to: Moment<N, M>,
    /// The higher coefficients for coordinates and rates, once they were asked for.
    higher: Option<[[Vector<N>; 4]; 2]>,
}

impl<const N: usize, const M: usize> Segment<N, M> {
    pub(super) fn new(from: Moment<N, M>, to: Moment<N, M>) -> Self {
        Self { from, to, higher: None }
    }

    pub(super) fn needs_more<P: Pair>(&self) -> bool {
        !P::DENSE.is_empty() && self.higher.is_none()
    }

    /// Takes the higher coefficients from stages that are complete.
    pub(super) fn complete<P: Pair>(&mut self, stages: &Stages<N>) {
        let h = self.to.t - self.from.t;
        let mut higher = [[[0.0; N]; 4]; 2];
        for (k, row) in P::DENSE.iter().enumerate() {
            let (rate, acceleration) = stages.sum(row);
            higher[0][k] = rate.map(|x| h * x);
            higher[1][k] = acceleration.map(|x| h * x);
        }
        self.higher = Some(higher);
    }

    /// Coordinates and rates at a time inside.
    pub(super) fn at(&self, t: f64) -> (Vector<N>, Vector<N>) {
        let (a, b) = (&self.from, &self.to);
        let h = b.t - a.t;
        let s = (t - a.t) / h;
        match &self.higher {
            Some([of_q, of_qd]) => (
                seventh(s, h, (&a.q, &a.qd), (&b.q, &b.qd), of_q),
                seventh(s, h, (&a.qd, &a.qdd), (&b.qd, &b.qdd), of_qd),
            ),
            None => fifth(s, h, a, b),
        }
    }
}

/// The polynomial of degree 7 through both ends with their derivatives, its other coefficients given.
fn seventh<const N: usize>(
    s: f64,
    h: f64,
    (x0, d0): (&Vector<N>, &Vector<N>),
    (x1, d1): (&Vector<N>, &Vector<N>),
    higher: &[Vector<N>; 4],
) -> Vector<N> {
    let r = 1.0 - s;
    std::array::from_fn(|i| {
        let change = x1[i] - x0[i];
        let bend = h * d0[i] - change;
        let twist = change - h * d1[i] - bend;
        let inner = higher[0][i] + s * (higher[1][i] + r * (higher[2][i] + s * higher[3][i]));
        x0[i] + s * (change + r * (bend + s * (twist + r * inner)))
    })
}

/// The polynomial of degree 5 through coordinates, rates and accelerations at both ends, and its derivative.
fn fifth<const N: usize, const M: usize>(s: f64, h: f64, a: &Moment<N, M>, b: &Moment<N, M>) -> (Vector<N>, Vector<N>) {
    let (mut q, mut qd) = ([0.0; N], [0.0; N]);
    for i in 0..N {
        let (v0, v1, a0, a1) = (h * a.qd[i], h * b.qd[i], h * h * a.qdd[i], h * h * b.qdd[i]);
        let position = b.q[i] - a.q[i] - v0 - 0.5 * a0;
        let rate = v1 - v0 - a0;
        let acceleration = a1 - a0;
        let third = 10.0 * position - 4.0 * rate + 0.5 * acceleration;
        let fourth = -15.0 * position + 7.0 * rate - acceleration;
        let fifth = 6.0 * position - 3.0 * rate + 0.5 * acceleration;
        q[i] = a.q[i] + s * (v0 + s * (0.5 * a0 + s * (third + s * (fourth + s * fifth))));
        qd[i] = a.qd[i] + s * (a0 + s * (3.0 * third + s * (4.0 * fourth + s * 5.0 * fifth))) / h;
    }
    (q, qd)
}
