//! The smallest and largest value of a column and when it occurs, between the rows too.

/// Extremes of one column.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Extremes {
    /// Smallest value and its time.
    pub(crate) minimum: (f64, f64),
    /// Largest value and its time.
    pub(crate) maximum: (f64, f64),
}

/// Where a column is smooth, it bends at neighbouring rows by at least this part of what it bends at a vertex.
const EVEN: f64 = 0.3;

/// Follows a column row by row and looks between the rows with a polynomial of degree 4 through five of them.
#[derive(Clone, Debug, Default)]
pub(crate) struct Tracker {
    /// The last five rows: time, value.
    window: Vec<(f64, f64)>,
    found: Option<Extremes>,
}

impl Tracker {
    pub(crate) fn row(&mut self, t: f64, value: f64) {
        self.note(t, value);
        if self.window.len() == 5 {
            self.window.remove(0);
        }
        self.window.push((t, value));
        if self.window.len() == 5 {
            self.look_around(2);
        }
    }

    /// The extremes of the rows so far.
    pub(crate) fn finish(&self) -> Option<Extremes> {
        // The ends of the series have no five rows around them.
        let mut last = self.clone();
        (1..self.window.len().saturating_sub(1)).for_each(|i| last.look_around(i));
        last.found
    }

    fn note(&mut self, t: f64, value: f64) {
        let found = self.found.get_or_insert(Extremes { minimum: (value, t), maximum: (value, t) });
        if value < found.minimum.0 {
            found.minimum = (value, t);
        }
        if value > found.maximum.0 {
            found.maximum = (value, t);
        }
    }

    /// If the row in the middle is higher or lower than both its neighbours, notes the vertex near it.
    fn look_around(&mut self, middle: usize) {
        let [before, at, after] = [middle - 1, middle, middle + 1].map(|i| self.window[i].1);
        if (at - before) * (after - at) > 0.0 || at == before && at == after {
            return;
        }
        // A vertex near this row that cannot beat what was found already is not worth its search.
        let reach = (at - before).abs() + (after - at).abs();
        if self.found.is_some_and(|f| at + reach <= f.maximum.0 && at - reach >= f.minimum.0) {
            return;
        }
        let n = self.window.len();
        // At a corner one row bends alone, and a polynomial through it would overshoot.
        let bend = |i: usize| {
            let slope =
                |i: usize| (self.window[i + 1].1 - self.window[i].1) / (self.window[i + 1].0 - self.window[i].0);
            (slope(i) - slope(i - 1)) / (self.window[i + 1].0 - self.window[i - 1].0)
        };
        let own = bend(middle);
        let neighbours = [middle - 1, middle + 1].into_iter().filter(|&i| i >= 1 && i + 1 < n);
        if neighbours.into_iter().any(|i| bend(i) * own < EVEN * own * own) {
            return;
        }
        // Newton's divided differences.
        let times: Vec<f64> = self.window.iter().map(|row| row.0).collect();
        let mut coefficients: Vec<f64> = self.window.iter().map(|row| row.1).collect();
        for order in 1..n {
            for i in (order..n).rev() {
                coefficients[i] = (coefficients[i] - coefficients[i - 1]) / (times[i] - times[i - order]);
            }
        }
        let value = |t: f64| (0..n - 1).rev().fold(coefficients[n - 1], |p, i| p * (t - times[i]) + coefficients[i]);
        let sign = if at >= before { 1.0 } else { -1.0 };
        let (mut low, mut high) = (times[middle - 1], times[middle + 1]);
        // The polynomial has one vertex here: sections keep it inside.
        for _ in 0..60 {
            let (a, b) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
            if sign * value(a) < sign * value(b) { low = a } else { high = b }
        }
        let t = 0.5 * (low + high);
        let vertex = value(t);
        // Between neighbours a smooth column rises no higher; a polynomial through noise may.
        if (vertex - at).abs() <= reach {
            self.note(t, vertex);
        }
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
