//! Tracks the extremes of columns row by row, including those between rows.

use super::extremes::{Extremes, Vertex, sign};
use crate::polynomial::{Number, Polynomial};

/// The smallest ratio of curvatures at neighbouring rows to that at a vertex, for a smooth column.
const EVEN: f64 = 0.3;

/// The largest number of iterations for a vertex; bisection alone needs fewer.
const MOST_ITERATIONS: usize = 60;

/// The possible error of a vertex's value, relative to its height above the row.
const SLACK: f64 = 0.1;

/// The largest difference between the values of a polynomial and of the motion, relative to the distance to the
/// neighbouring rows' values, for which the polynomial locates a vertex. The error of its time is then about a hundred
/// thousandth of the distance between rows.
const AGREEMENT: f64 = 1e-8;

/// The possible error of an estimated vertex, relative to the difference between its value and that of the motion.
const UNCERTAINTY: f64 = 3.0;

/// The largest number of candidates for the smallest or largest value of a column.
const MOST_VERTICES: usize = 3;

/// The distance of two rows, relative to the previous distance, below which they have the same time.
const SAME: f64 = 1e-6;

/// The number of rows for a polynomial.
const ROWS: usize = 5;

/// Tracks columns row by row, with polynomials of degree 4 through five rows for the values in between.
///
/// Polynomials locate possible extremes between rows. The caller evaluates the motion there and records the values.
#[derive(Clone, Debug)]
pub struct ExtremesTracker<D = f64> {
    /// Rows so far.
    rows: usize,
    /// The times of the last five rows; row `k` has the index `k` modulo 5.
    times: Vec<D>,
    /// The values of each column in these rows.
    values: Vec<[D; ROWS]>,
    found: Vec<Extremes<D>>,
    /// For each column, candidates for the smallest and for the largest value between rows, best first.
    vertices: Vec<[Vec<Vertex<D>>; 2]>,
}

impl<D> Default for ExtremesTracker<D> {
    fn default() -> Self {
        Self { rows: 0, times: Vec::new(), values: Vec::new(), found: Vec::new(), vertices: Vec::new() }
    }
}

impl<D: Number> ExtremesTracker<D> {
    /// Adds the next row, with as many values as the first one.
    pub fn row(&mut self, t: D, values: &[D]) {
        if self.rows == 0 {
            self.found = values.iter().map(|value| Extremes::new(t, *value)).collect();
            self.vertices = vec![[const { Vec::new() }; 2]; values.len()];
            self.times = vec![t; ROWS];
            self.values = values.iter().map(|value| [*value; ROWS]).collect();
        }
        let begin = (self.rows > 0).then(|| self.time(0));
        // Of rows with equal times, a polynomial uses only the last.
        let is_at_last = self.rows > 1 && {
            let [before, last] = [2, 1].map(|back| self.times[(self.rows - back) % ROWS].re());
            t.re() - last < SAME * (last - before)
        };
        self.rows -= usize::from(is_at_last);
        self.times[self.rows % ROWS] = t;
        let place = self.rows % ROWS;
        for ((found, kept), value) in self.found.iter_mut().zip(&mut self.values).zip(values) {
            found.note(t, *value, begin);
            kept[place] = *value;
        }
        self.rows += 1;
        if self.rows == 2 && !is_at_last {
            self.record_end_row([0, 1]);
        }
        if self.window() < ROWS || is_at_last {
            return;
        }
        // The rows around the middle of the window, and once those around the second row.
        let first = self.rows - ROWS;
        for middle in if first == 0 { 1..3 } else { 2..3 } {
            let [before, at, after] = [middle - 1, middle, middle + 1].map(|i| (first + i) % ROWS);
            for column in 0..self.values.len() {
                let kept = &self.values[column];
                if is_turn([before, at, after].map(|place| kept[place].re())) {
                    self.turn(column, middle);
                }
            }
        }
    }

    /// Records a turning point near a row: the vertex of a polynomial, or a corner at the row.
    fn turn(&mut self, column: usize, middle: usize) {
        let value = |i: usize| self.value(i, column).re();
        let [before, at, after] = [value(middle - 1), value(middle), value(middle + 1)];
        let end = usize::from(at > before || at > after);
        // A vertex that cannot exceed the values found so far need not be located.
        let reach = (at - before).abs() + (after - at).abs();
        if sign(end) * (self.extreme(column, end).0.re() - at) > reach {
            return;
        }
        let row = (self.value(middle, column), self.time(middle));
        // The polynomial is inaccurate at a corner.
        let (estimate, value_uncertainty, agreement) = match self.search(column, end, middle, reach) {
            Some(vertex) => (vertex, SLACK * (vertex.0.re() - at).abs(), Some(AGREEMENT * reach)),
            None => (row, reach, None),
        };
        let bracket = [self.time(middle - 1), self.time(middle + 1)];
        self.record_candidate(Vertex { column, end, estimate, bracket, value_uncertainty, agreement });
    }

    /// Records a candidate, unless better ones are known.
    fn record_candidate(&mut self, vertex: Vertex<D>) {
        if !self.may_be_extreme(&vertex) {
            return;
        }
        let tie = self.tie(vertex.column);
        let known = &mut self.vertices[vertex.column][vertex.end];
        let lead = |other: &Vertex<D>| sign(vertex.end) * (vertex.estimate.0.re() - other.estimate.0.re());
        let place = known.iter().position(|other| lead(other) > tie).unwrap_or(known.len());
        let mut worse = vertex;
        known[place..].iter_mut().for_each(|known| std::mem::swap(known, &mut worse));
        if known.len() < MOST_VERTICES {
            known.push(worse);
        }
    }

    /// Whether the column may be smaller or larger there than in any row.
    pub(crate) fn may_be_extreme(&self, vertex: &Vertex<D>) -> bool {
        let lead = vertex.estimate.0.re() - self.extreme(vertex.column, vertex.end).0.re();
        sign(vertex.end) * lead + vertex.value_uncertainty >= 0.0
    }

    /// Whether a candidate with this value at its estimated time certainly does not replace a known extreme before it.
    pub(crate) fn is_below(&mut self, vertex: &Vertex<D>, value: f64) -> bool {
        let (known, t) = self.extreme(vertex.column, vertex.end);
        let leads = [value, vertex.estimate.0.re()].map(|value| sign(vertex.end) * (value - known.re()));
        let uncertainty = match vertex.agreement {
            Some(_) => UNCERTAINTY * (leads[0] - leads[1]).abs(),
            None => vertex.value_uncertainty,
        };
        let lead = leads[0].max(leads[1]) + uncertainty;
        let is_below = t.re() < vertex.bracket[0].re() && lead <= self.tie(vertex.column);
        if is_below {
            self.found[vertex.column].note_rival(vertex.end, (D::from(value), vertex.estimate.1));
        }
        is_below
    }

    fn extreme(&self, column: usize, end: usize) -> (D, D) {
        let Extremes { minimum, maximum, .. } = self.found[column];
        [minimum, maximum][end]
    }

    /// Adds what five rows around a row cannot show: turning points near the last rows, and the last row itself, next
    /// to which a column may be larger.
    pub fn finish(&mut self) {
        for column in 0..self.found.len() {
            for middle in 1..self.window().saturating_sub(1) {
                let [before, at, after] = [middle - 1, middle, middle + 1].map(|i| self.value(i, column).re());
                if is_turn([before, at, after]) {
                    self.turn(column, middle);
                }
            }
        }
        if let Some(before) = self.window().checked_sub(2) {
            self.record_end_row([before + 1, before]);
        }
    }

    /// Records the first or the last row together with its neighbour: the column may rise from there, like from a row
    /// that is not an extreme.
    fn record_end_row(&mut self, [at, beside]: [usize; 2]) {
        let times = [at.min(beside), at.max(beside)].map(|i| self.time(i));
        for column in 0..self.found.len() {
            let [own, other] = [at, beside].map(|i| self.value(i, column));
            let end = usize::from(own.re() > other.re());
            let (estimate, value_uncertainty) = ((own, self.time(at)), (own.re() - other.re()).abs());
            self.record_candidate(Vertex { column, end, estimate, bracket: times, value_uncertainty, agreement: None });
        }
    }

    /// Removes and returns the candidates between rows, so that the caller can evaluate the motion there.
    pub(crate) fn take_vertices(&mut self) -> Vec<Vertex<D>> {
        let mut all = Vec::new();
        self.vertices.iter_mut().flatten().for_each(|known| all.append(known));
        all.retain(|vertex| self.may_be_extreme(vertex));
        all
    }

    /// Records the value and the time of a candidate; among tied values at different times, the first one counts.
    pub(crate) fn note(&mut self, vertex: &Vertex<D>, found: (D, D)) {
        if self.replaces(vertex, found) {
            self.set(vertex, found);
        } else if found.1.re() != self.extreme(vertex.column, vertex.end).1.re() {
            self.found[vertex.column].note_rival(vertex.end, found);
        }
    }

    /// Records the value and the time of a candidate, also where a row that happens to lie at the extreme has the same
    /// value: its time does not depend on parameters.
    pub(crate) fn note_located(&mut self, vertex: &Vertex<D>, found: (D, D)) {
        let (known, t) = self.extreme(vertex.column, vertex.end);
        let is_here = vertex.bracket[0].re() <= t.re() && t.re() <= vertex.bracket[1].re();
        let is_same = is_here && (found.0.re() - known.re()).abs() <= self.tie(vertex.column);
        if is_same || self.replaces(vertex, found) {
            self.set(vertex, found);
        }
    }

    fn set(&mut self, vertex: &Vertex<D>, found: (D, D)) {
        let known = self.extreme(vertex.column, vertex.end);
        let extremes = &mut self.found[vertex.column];
        // A row next to the extreme belongs to the same peak, unless its value lies beyond.
        if known.1.re() < vertex.bracket[0].re() || sign(vertex.end) * (known.0.re() - found.0.re()) > 0.0 {
            extremes.note_rival(vertex.end, known);
        }
        let Extremes { minimum, maximum, .. } = extremes;
        *(if vertex.end == 0 { minimum } else { maximum }) = found;
    }

    /// Whether the value and the time of a candidate replace the known extreme.
    pub(crate) fn replaces(&self, vertex: &Vertex<D>, found: (D, D)) -> bool {
        let (known, t) = self.extreme(vertex.column, vertex.end);
        let lead = sign(vertex.end) * (found.0.re() - known.re());
        let is_here = vertex.bracket[0].re() <= t.re() && t.re() <= vertex.bracket[1].re();
        let tie = if is_here { 0.0 } else { self.tie(vertex.column) };
        lead > tie || (!is_here && lead > -tie && found.1.re() < t.re())
    }

    /// The largest difference between tied values of a column.
    fn tie(&self, column: usize) -> f64 {
        self.found[column].tie()
    }

    /// Records the candidates between rows with their estimated values.
    pub(crate) fn note_estimates(&mut self) {
        for vertex in self.take_vertices() {
            self.note(&vertex, vertex.estimate);
        }
    }

    /// The extremes of all columns so far; empty without rows.
    pub fn found(&self) -> &[Extremes<D>] {
        &self.found
    }

    /// The number of rows that are kept.
    fn window(&self) -> usize {
        self.rows.min(ROWS)
    }

    /// The time of a kept row, the oldest first.
    fn time(&self, i: usize) -> D {
        self.times[(self.rows - self.window() + i) % ROWS]
    }

    /// The value of a column in a kept row, the oldest first.
    fn value(&self, i: usize, column: usize) -> D {
        self.values[column][(self.rows - self.window() + i) % ROWS]
    }

    /// Locates the vertex near a row; returns its time and value. The value differs from that of the row by at most
    /// `reach`.
    fn search(&self, column: usize, end: usize, middle: usize, reach: f64) -> Option<(D, D)> {
        let row = |i: usize| (self.time(i).re(), self.value(i, column).re());
        // At a corner only one row has curvature, and a polynomial through it would overshoot.
        let bend = |i: usize| {
            let slope = |i: usize| (row(i + 1).1 - row(i).1) / (row(i + 1).0 - row(i).0);
            (slope(i) - slope(i - 1)) / (row(i + 1).0 - row(i - 1).0)
        };
        let own = bend(middle);
        let neighbours = [middle - 1, middle + 1].into_iter().filter(|&i| i >= 1 && i + 1 < self.window());
        if neighbours.into_iter().any(|i| bend(i) * own < EVEN * own * own) {
            return None;
        }
        let points: Vec<(D, D)> = (0..self.window()).map(|i| (self.time(i), self.value(i, column))).collect();
        let polynomial = Polynomial::through(&points);
        let (at, sign) = (row(middle).1, sign(end));
        let (mut low, mut high) = (row(middle - 1).0, row(middle + 1).0);
        let enough = f64::EPSILON * (high - low);
        let mut t = row(middle).0;
        // The polynomial has one vertex here; if Newton's method leaves the bracket, the bracket is halved.
        for _ in 0..MOST_ITERATIONS {
            let [_, slope, curve] = polynomial.at(D::from(t)).map(|value| value.re());
            if sign * slope > 0.0 {
                low = t
            } else {
                high = t
            }
            let newton = t - slope / curve;
            let next = if low < newton && newton < high { newton } else { 0.5 * (low + high) };
            let moved = (next - t).abs();
            t = next;
            if moved <= enough {
                break;
            }
        }
        // One more step gives the derivative of the time with respect to the column.
        let [_, slope, curve] = polynomial.at(D::from(t));
        let shift = slope / curve;
        let is_small = shift.re().abs() < 1e-3 * (row(middle + 1).0 - row(middle - 1).0);
        let t = if is_small { D::from(t) - shift } else { D::from(t) };
        let vertex = polynomial.value(t);
        // Between neighbours a smooth column rises no higher; a polynomial through noise may, or may miss the row.
        let rise = sign * (vertex.re() - at);
        (0.0..=reach).contains(&rise).then_some((vertex, t))
    }
}

/// Whether the second of three values is higher or lower than both others, or equal to one of them.
#[inline]
fn is_turn([before, at, after]: [f64; 3]) -> bool {
    !((at - before) * (after - at) > 0.0 || at == before && at == after)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_the_vertices_between_the_rows() {
        let mut tracker = ExtremesTracker::default();
        let row = |i: i32| 0.05 * f64::from(i);
        (0..100).map(row).for_each(|t| tracker.row(t, &[(1.3 * t).sin()]));
        tracker.finish();
        tracker.note_estimates();
        let found = tracker.found()[0];
        assert!((found.maximum.0 - 1.0).abs() < 1e-8, "{found:?}");
        assert!((found.minimum.0 + 1.0).abs() < 1e-8, "{found:?}");
        assert!((found.maximum.1 - std::f64::consts::FRAC_PI_2 / 1.3).abs() < 1e-5, "{found:?}");
    }

    #[test]
    fn corners_are_not_overshot() {
        let mut tracker = ExtremesTracker::default();
        (0..100).for_each(|i| tracker.row(f64::from(i), &[f64::from(i - 50).clamp(0.0, 20.0)]));
        tracker.finish();
        tracker.note_estimates();
        let found = tracker.found()[0];
        assert_eq!((found.minimum.0, found.maximum.0), (0.0, 20.0));
    }

    #[test]
    fn ends_of_the_series_count() {
        let mut tracker = ExtremesTracker::default();
        [1.0, 2.0, 4.0].iter().enumerate().for_each(|(i, v)| tracker.row(i as f64, &[*v]));
        tracker.finish();
        tracker.note_estimates();
        let found = tracker.found()[0];
        assert_eq!((found.minimum, found.maximum), ((1.0, 0.0), (4.0, 2.0)));
    }
}
