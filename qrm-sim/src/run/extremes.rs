//! The smallest and largest value of a column and when it occurs, between the rows too.

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

/// Follows a column row by row and looks between the rows with a polynomial of degree 4 through five of them.
#[derive(Clone, Debug)]
pub struct Tracker<D = f64> {
    /// The last five rows: time, value.
    window: Vec<(D, D)>,
    found: Option<Extremes<D>>,
}

impl<D> Default for Tracker<D> {
    fn default() -> Self {
        Self { window: Vec::new(), found: None }
    }
}

impl<D: Number> Tracker<D> {
    /// Takes the next row.
    pub fn row(&mut self, t: D, value: D) {
        self.note(t, value);
        if self.window.len() == 5 {
            self.window.remove(0);
        }
        self.window.push((t, value));
        if self.window.len() == 5 {
            self.look_around(2);
        }
    }

    /// The extremes of the rows so far; `None` without rows.
    pub fn finish(&self) -> Option<Extremes<D>> {
        // The ends of the series have no five rows around them.
        let mut last = self.clone();
        (1..self.window.len().saturating_sub(1)).for_each(|i| last.look_around(i));
        last.found
    }

    fn note(&mut self, t: D, value: D) {
        let found = self.found.get_or_insert(Extremes { minimum: (value, t), maximum: (value, t) });
        let is_inside = found.minimum.0.re() <= value.re() && value.re() <= found.maximum.0.re();
        if is_inside {
            return;
        }
        let tie = TIE * (found.maximum.0.re() - found.minimum.0.re());
        let margin = |of: D| if self.window.first().is_some_and(|first| of.re() < first.0.re()) { tie } else { 0.0 };
        if value.re() < found.minimum.0.re() - margin(found.minimum.1) {
            found.minimum = (value, t);
        }
        if value.re() > found.maximum.0.re() + margin(found.maximum.1) {
            found.maximum = (value, t);
        }
    }

    /// If the row in the middle is higher or lower than both its neighbours, notes the vertex near it.
    fn look_around(&mut self, middle: usize) {
        let row = |i: usize| (self.window[i].0.re(), self.window[i].1.re());
        let [before, at, after] = [middle - 1, middle, middle + 1].map(|i| row(i).1);
        if (at - before) * (after - at) > 0.0 || at == before && at == after {
            return;
        }
        // A vertex near this row that cannot beat what was found already is not worth its search.
        let reach = (at - before).abs() + (after - at).abs();
        if self.found.is_some_and(|f| at + reach <= f.maximum.0.re() && at - reach >= f.minimum.0.re()) {
            return;
        }
        // At a corner one row bends alone, and a polynomial through it would overshoot.
        let bend = |i: usize| {
            let slope = |i: usize| (row(i + 1).1 - row(i).1) / (row(i + 1).0 - row(i).0);
            (slope(i) - slope(i - 1)) / (row(i + 1).0 - row(i - 1).0)
        };
        let own = bend(middle);
        let neighbours = [middle - 1, middle + 1].into_iter().filter(|&i| i >= 1 && i + 1 < self.window.len());
        if neighbours.into_iter().any(|i| bend(i) * own < EVEN * own * own) {
            return;
        }
        let polynomial = Polynomial::through(&self.window);
        let sign = if at >= before { 1.0 } else { -1.0 };
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
        let t = if shift.re().abs() < 1e-3 * (row(middle + 1).0 - row(middle - 1).0) {
            D::from(t) - shift
        } else {
            D::from(t)
        };
        let vertex = polynomial.value(t);
        // Between neighbours a smooth column rises no higher; a polynomial through noise may.
        if (vertex.re() - at).abs() <= reach {
            self.note(t, vertex);
        }
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
        let mut tracker = Tracker::default();
        let row = |i: i32| 0.05 * f64::from(i);
        (0..100).map(row).for_each(|t| tracker.row(t, (1.3 * t).sin()));
        let found = tracker.finish().expect("rows were given");
        assert!((found.maximum.0 - 1.0).abs() < 1e-8, "{found:?}");
        assert!((found.minimum.0 + 1.0).abs() < 1e-8, "{found:?}");
        assert!((found.maximum.1 - std::f64::consts::FRAC_PI_2 / 1.3).abs() < 1e-5, "{found:?}");
    }

    #[test]
    fn corners_are_not_overshot() {
        let mut tracker = Tracker::default();
        (0..100).for_each(|i| tracker.row(f64::from(i), f64::from(i - 50).clamp(0.0, 20.0)));
        let found = tracker.finish().expect("rows were given");
        assert_eq!((found.minimum.0, found.maximum.0), (0.0, 20.0));
    }

    #[test]
    fn ends_of_the_series_count() {
        let mut tracker = Tracker::default();
        [1.0, 2.0, 4.0].iter().enumerate().for_each(|(i, v)| tracker.row(i as f64, *v));
        let found = tracker.finish().expect("rows were given");
        assert_eq!(found, Extremes { minimum: (1.0, 0.0), maximum: (4.0, 2.0) });
    }
}
