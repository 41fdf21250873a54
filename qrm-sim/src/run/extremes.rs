//! The smallest and largest values of columns and when they occur, between the rows too.

use num_dual::DualNum;

/// A number with or without derivatives.
pub trait Number: DualNum<Primitive = f64> + Copy {}

impl<D: DualNum<Primitive = f64> + Copy> Number for D {}

/// Extremes of one column.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extremes<D = f64> {
    /// Smallest value and its time.
    pub minimum: (D, D),
    /// Largest value and its time.
    pub maximum: (D, D),
}

/// Where a column is smooth, it bends at neighbouring rows by at least this part of what it bends at a vertex.
const EVEN: f64 = 0.3;

/// Iterations for a vertex; halving alone takes fewer.
const MOST_ITERATIONS: usize = 60;

/// Of extremes that differ by less than this part of the range, rounding errors would choose: the first one counts.
const TIE: f64 = 1e-9;

/// Rows that a polynomial goes through.
const ROWS: usize = 5;

/// Follows columns row by row and looks between the rows with polynomials of degree 4 through five of them.
#[derive(Clone, Debug)]
pub struct ExtremesTracker<D = f64> {
    /// Rows so far.
    rows: usize,
    /// The times of the last five rows; row `k` stands at `k` modulo 5.
    times: Vec<D>,
    /// Their values, one row after another.
    values: Vec<D>,
    found: Vec<Extremes<D>>,
    /// The times of the first two rows.
    begin: Vec<D>,
    /// Between which rows they are to be looked for, the smallest and the largest.
    brackets: Vec<[Bracket<D>; 2]>,
}

/// The times of two rows between which a column turns; none where it does not.
type Bracket<D> = Option<[D; 2]>;

impl<D> Default for ExtremesTracker<D> {
    fn default() -> Self {
        Self {
            rows: 0,
            times: Vec::new(),
            values: Vec::new(),
            found: Vec::new(),
            begin: Vec::new(),
            brackets: Vec::new(),
        }
    }
}

impl<D: Number> ExtremesTracker<D> {
    /// Takes the next row, with as many values as the first one.
    pub fn row(&mut self, t: D, values: &[D]) {
        if self.rows == 0 {
            self.found = values.iter().map(|value| Extremes { minimum: (*value, t), maximum: (*value, t) }).collect();
            self.brackets = vec![[None; 2]; values.len()];
            self.times = vec![t; ROWS];
            self.values = values.repeat(ROWS);
        }
        if self.rows < 2 {
            self.begin.push(t);
        }
        let begin = (self.rows > 0).then(|| self.time(0));
        self.times[self.rows % ROWS] = t;
        let place = self.place(self.rows);
        self.values[place].copy_from_slice(values);
        self.rows += 1;
        if self.window() < ROWS {
            for (column, value) in values.iter().enumerate() {
                self.note(column, (t, *value), begin, None);
            }
            return;
        }
        // The rows around the middle of the window, and around the second row once.
        let first = self.rows - ROWS;
        for middle in if first == 0 { 1..3 } else { 2..3 } {
            let [before, at, after] = [middle - 1, middle, middle + 1].map(|i| self.place(first + i).start);
            for column in 0..values.len() {
                self.note(column, (t, values[column]), begin, None);
                let value = |place: usize| self.values[place + column].re();
                if is_turn([value(before), value(at), value(after)]) {
                    self.turn(column, middle);
                }
            }
        }
    }

    #[inline]
    fn note(&mut self, column: usize, (t, value): (D, D), begin: Option<D>, bracket: Bracket<D>) {
        let changed = self.found[column].note(t, value, begin);
        for (own, _) in self.brackets[column].iter_mut().zip(changed).filter(|(_, changed)| *changed) {
            *own = bracket;
        }
    }

    /// Takes up a turn near a row: the vertex of a polynomial, or a corner at the row.
    fn turn(&mut self, column: usize, middle: usize) {
        let bracket = Some([self.time(middle - 1), self.time(middle + 1)]);
        if let Some(vertex) = self.vertex(column, middle, &self.found[column]) {
            self.note(column, vertex, Some(self.time(0)), bracket);
            return;
        }
        let at = self.time(middle).re();
        let Extremes { minimum, maximum } = self.found[column];
        for (own, (_, t)) in self.brackets[column].iter_mut().zip([minimum, maximum]) {
            if t.re() == at {
                *own = bracket;
            }
        }
    }

    /// Takes up what five rows around a row do not tell: turns near the last rows, and extremes in the first row and the
    /// last one, which may be larger beside it.
    pub fn finish(&mut self) {
        let last: Vec<D> = (0..self.window()).rev().take(2).map(|i| self.time(i)).collect();
        for column in 0..self.found.len() {
            for middle in 1..self.window().saturating_sub(1) {
                let [before, at, after] = [middle - 1, middle, middle + 1].map(|i| self.value(i, column).re());
                if is_turn([before, at, after]) {
                    self.turn(column, middle);
                }
            }
            let Extremes { minimum, maximum } = self.found[column];
            for (own, (_, t)) in self.brackets[column].iter_mut().zip([minimum, maximum]) {
                match (&self.begin[..], &last[..]) {
                    ([first, second], _) if t.re() == first.re() => *own = Some([*first, *second]),
                    (_, [last, before]) if t.re() == last.re() => *own = Some([*before, *last]),
                    _ => {}
                }
            }
        }
    }

    /// The extremes that lie between rows: column, 0 for the smallest value and 1 for the largest, the time as far as
    /// rows tell it, and the times of the rows beside it.
    pub(crate) fn between_rows(&self) -> Vec<(usize, usize, D, [D; 2])> {
        let extremes = self.found.iter().zip(&self.brackets).enumerate();
        let of_column = |(column, (found, brackets)): (usize, (&Extremes<D>, &[Bracket<D>; 2]))| {
            let times = [found.minimum.1, found.maximum.1];
            (0..2).filter_map(|end| Some((column, end, times[end], brackets[end]?))).collect::<Vec<_>>()
        };
        extremes.flat_map(of_column).collect()
    }

    /// Replaces an extreme by what was found between the rows.
    pub(crate) fn refine(&mut self, column: usize, end: usize, found: (D, D)) {
        let Extremes { minimum, maximum } = &mut self.found[column];
        *(if end == 0 { minimum } else { maximum }) = found;
        self.brackets[column][end] = None;
    }

    /// The extremes of all columns so far; none without rows.
    pub fn found(&self) -> &[Extremes<D>] {
        &self.found
    }

    /// The number of rows that are kept.
    fn window(&self) -> usize {
        self.rows.min(ROWS)
    }

    /// The place of the values of a row.
    fn place(&self, row: usize) -> std::ops::Range<usize> {
        let count = self.found.len();
        let begin = row % ROWS * count;
        begin..begin + count
    }

    /// The time of a kept row, the oldest first.
    fn time(&self, i: usize) -> D {
        self.times[(self.rows - self.window() + i) % ROWS]
    }

    /// The value of a column in a kept row, the oldest first.
    fn value(&self, i: usize, column: usize) -> D {
        self.values[self.place(self.rows - self.window() + i).start + column]
    }

    /// The vertex near a row that is higher or lower than both its neighbours: time and value.
    fn vertex(&self, column: usize, middle: usize, found: &Extremes<D>) -> Option<(D, D)> {
        let value = |i: usize| self.value(i, column).re();
        let [before, at, after] = [value(middle - 1), value(middle), value(middle + 1)];
        // A vertex near this row that cannot beat what was found already is not worth its search.
        let reach = (at - before).abs() + (after - at).abs();
        if at + reach <= found.maximum.0.re() && at - reach >= found.minimum.0.re() {
            return None;
        }
        self.search(column, middle, reach)
    }

    /// Searches the vertex near a row; its value differs from that of the row by `reach` at most.
    fn search(&self, column: usize, middle: usize, reach: f64) -> Option<(D, D)> {
        let row = |i: usize| (self.time(i).re(), self.value(i, column).re());
        // At a corner one row bends alone, and a polynomial through it would overshoot.
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
        let (at, sign) = (row(middle).1, if row(middle).1 >= row(middle - 1).1 { 1.0 } else { -1.0 });
        let (mut low, mut high) = (row(middle - 1).0, row(middle + 1).0);
        let enough = f64::EPSILON * (high - low);
        let mut t = row(middle).0;
        // The polynomial has one vertex here: where Newton's method leaves the bracket, it is halved.
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
        // One more step tells how the time changes with the column.
        let [_, slope, curve] = polynomial.at(D::from(t));
        let shift = slope / curve;
        let is_small = shift.re().abs() < 1e-3 * (row(middle + 1).0 - row(middle - 1).0);
        let t = if is_small { D::from(t) - shift } else { D::from(t) };
        let vertex = polynomial.value(t);
        // Between neighbours a smooth column rises no higher; a polynomial through noise may.
        ((vertex.re() - at).abs() <= reach).then_some((t, vertex))
    }
}

/// Whether the second of three values is higher or lower than both others, or as high as one of them.
#[inline]
fn is_turn([before, at, after]: [f64; 3]) -> bool {
    !((at - before) * (after - at) > 0.0 || at == before && at == after)
}

impl<D: Number> Extremes<D> {
    /// Takes up a value; of values that tie with one from before the time `begin`, that one counts. Returns whether it
    /// is the smallest one now, and whether it is the largest.
    #[inline]
    fn note(&mut self, t: D, value: D, begin: Option<D>) -> [bool; 2] {
        if self.minimum.0.re() <= value.re() && value.re() <= self.maximum.0.re() {
            return [false; 2];
        }
        let tie = TIE * (self.maximum.0.re() - self.minimum.0.re());
        let margin = |of: D| if begin.is_some_and(|begin| of.re() < begin.re()) { tie } else { 0.0 };
        let is_smallest = value.re() < self.minimum.0.re() - margin(self.minimum.1);
        let is_largest = value.re() > self.maximum.0.re() + margin(self.maximum.1);
        if is_smallest {
            self.minimum = (value, t);
        }
        if is_largest {
            self.maximum = (value, t);
        }
        [is_smallest, is_largest]
    }
}

/// A polynomial in Newton's form.
pub(crate) struct Polynomial<D> {
    times: Vec<D>,
    coefficients: Vec<D>,
}

impl<D: Number> Polynomial<D> {
    /// The polynomial through points of different times.
    pub(crate) fn through(points: &[(D, D)]) -> Self {
        let times: Vec<D> = points.iter().map(|point| point.0).collect();
        let mut coefficients: Vec<D> = points.iter().map(|point| point.1).collect();
        for order in 1..points.len() {
            for i in (order..points.len()).rev() {
                coefficients[i] = (coefficients[i] - coefficients[i - 1]) / (times[i] - times[i - order]);
            }
        }
        Self { times, coefficients }
    }

    /// Its value.
    pub(crate) fn value(&self, t: D) -> D {
        let terms = self.coefficients.iter().zip(&self.times).rev();
        terms.fold(D::from(0.0), |value, (coefficient, time)| value * (t - *time) + *coefficient)
    }

    /// Its value and first two derivatives.
    fn at(&self, t: D) -> [D; 3] {
        let zero = D::from(0.0);
        let [mut value, mut slope, mut curve] = [zero; 3];
        for (coefficient, time) in self.coefficients.iter().zip(&self.times).rev() {
            curve = curve * (t - *time) + slope * 2.0;
            slope = slope * (t - *time) + value;
            value = value * (t - *time) + *coefficient;
        }
        [value, slope, curve]
    }
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
        let found = tracker.found()[0];
        assert_eq!((found.minimum.0, found.maximum.0), (0.0, 20.0));
    }

    #[test]
    fn ends_of_the_series_count() {
        let mut tracker = ExtremesTracker::default();
        [1.0, 2.0, 4.0].iter().enumerate().for_each(|(i, v)| tracker.row(i as f64, &[*v]));
        tracker.finish();
        let found = tracker.found()[0];
        assert_eq!(found, Extremes { minimum: (1.0, 0.0), maximum: (4.0, 2.0) });
    }
}
