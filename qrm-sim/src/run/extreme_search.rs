//! The search for extremes between the rows of a run, on the motion itself.

use qrm_core::{Mechanism, RowLayout};

use super::extremes::Vertex;
use super::extremes_tracker::ExtremesTracker;
use crate::columns::number;
use crate::integrate::Integrator;
use crate::maximum::peak_between;
use crate::state::State;

/// Whether extremes are searched for between rows.
const SEARCHES: bool = cfg!(feature = "extremes");

/// The distance from a row, relative to that of rows, at which a column is tested for a rise.
const NEIGHBOUR_DISTANCE: f64 = 1e-3;

/// The number of rows for the polynomial of an extreme.
const TAIL: usize = 5;

/// The rows of a run from which steps lead to extremes between them.
#[derive(Clone, Debug)]
pub(super) struct ExtremeSearch {
    layout: RowLayout,
    /// The first row.
    first: Vec<f64>,
    /// The rows before the last block between which extremes may still be found.
    tail: Vec<f64>,
    /// The time at which multipliers grow without bound, if a search met one.
    pub(super) unbounded_at: Option<f64>,
}

impl ExtremeSearch {
    /// Begins with a run at its first row.
    pub(super) fn new(layout: RowLayout, first: &[f64]) -> Self {
        Self { layout, first: if SEARCHES { first.to_vec() } else { Vec::new() }, tail: Vec::new(), unbounded_at: None }
    }

    /// Searches for each extreme between rows; `rows` are the last ones.
    pub(super) fn refine(
        &mut self,
        mechanism: &dyn Mechanism,
        run: &Integrator,
        rows: &[f64],
        extremes: &mut ExtremesTracker,
    ) {
        if !SEARCHES {
            extremes.note_estimates();
            return;
        }
        let vertices = extremes.take_vertices();
        if vertices.is_empty() {
            return;
        }
        // A copy, so that the run itself is not affected.
        let mut integrator = run.clone();
        let mut from = State::zero(self.layout.n, self.layout.m);
        for vertex in vertices {
            if !extremes.may_be_extreme(&vertex) {
                continue;
            }
            let Vertex { column, end, estimate, bracket, .. } = vertex;
            let t = estimate.1;
            let sign = if end == 0 { -1.0 } else { 1.0 };
            let mut value = |t: f64| {
                // States between rows are closer, but only those of the last block are available.
                let known = [rows, run.inner_rows(), &self.tail, &self.first].into_iter();
                let last =
                    known.filter_map(|states| self.last_until(states, t)).max_by(|a, b| a[0].total_cmp(&b[0]))?;
                from.read(last);
                let at = integrator.between(mechanism, &from, t).ok()?;
                Some(sign * number(mechanism, &at, column)).filter(|value| value.is_finite())
            };
            let at = value(t);
            // A value at an end is an extreme, unless the column rises from there.
            let other = bracket[0] + bracket[1] - t;
            if bracket.contains(&t) && !(value(t + NEIGHBOUR_DISTANCE * (other - t)) > at) {
                continue;
            }
            let peak = at.and_then(|at| {
                if vertex.agrees(sign * at) { Some((t, at)) } else { peak_between(bracket, (t, at), &mut value) }
            });
            extremes.note(&vertex, peak.map_or(estimate, |(t, value)| (sign * value, t)));
        }
        self.unbounded_at = self.unbounded_at.or(integrator.stats().unbounded_at);
    }

    /// Keeps the last rows; the very last one is also the first of the next block.
    pub(super) fn keep(&mut self, rows: &[f64]) {
        if !SEARCHES {
            return;
        }
        let width = self.layout.width();
        let made = rows.len() / width - 1;
        self.tail.extend_from_slice(&rows[made.saturating_sub(TAIL) * width..made * width]);
        let excess = self.tail.len().saturating_sub(TAIL * width);
        self.tail.drain(..excess);
    }

    /// The last state in a row whose time is at most `t`; the times increase.
    fn last_until<'a>(&self, states: &'a [f64], t: f64) -> Option<&'a [f64]> {
        let width = self.layout.width();
        let (mut begin, mut end) = (0, states.len() / width);
        while begin < end {
            let middle = (begin + end) / 2;
            if states[middle * width] <= t { begin = middle + 1 } else { end = middle }
        }
        let place = begin.checked_sub(1)? * width;
        Some(&states[place..place + width])
    }
}
