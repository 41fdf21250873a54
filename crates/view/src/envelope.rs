//! The series of columns in bounded memory.

/// The number of spans of rows; up to twice as many are stored.
const SPANS: usize = 1000;

/// Records columns row by row. Long columns are reduced to the smallest and the largest value of each of many spans, so
/// that a picture shows every peak.
#[derive(Clone, Debug, Default)]
pub struct Envelope {
    /// The spans, each with its range of every column.
    ranges: Vec<Range>,
    /// The number of columns.
    columns: usize,
    /// The first row: time and values.
    first: Option<(f64, Vec<f64>)>,
    /// The last row: time and values.
    last: Option<(f64, Vec<f64>)>,
    /// The number of rows of the last span.
    filled: u64,
    /// The number of rows in a full span, less one.
    width: u64,
}

/// The smallest and the largest value of a column in a span, each with its time.
#[derive(Clone, Copy, Debug)]
struct Range {
    lowest: (f64, f64),
    highest: (f64, f64),
}

impl Range {
    fn join(&mut self, other: &Self) {
        if other.lowest.1 < self.lowest.1 {
            self.lowest = other.lowest;
        }
        if other.highest.1 > self.highest.1 {
            self.highest = other.highest;
        }
    }
}

impl Envelope {
    /// Adds the next row, with as many values as the first one.
    pub fn row(&mut self, t: f64, values: &[f64]) {
        if self.first.is_none() {
            self.first = Some((t, values.to_vec()));
            self.columns = values.len();
        }
        if self.filled > 0 && self.filled <= self.width {
            let begin = self.ranges.len() - self.columns;
            for (range, value) in self.ranges[begin..].iter_mut().zip(values) {
                if *value < range.lowest.1 {
                    range.lowest = (t, *value);
                }
                if *value > range.highest.1 {
                    range.highest = (t, *value);
                }
            }
            self.filled += 1;
            return;
        }
        if self.ranges.len() == 2 * SPANS * self.columns {
            self.halve();
        }
        self.ranges.extend(values.iter().map(|value| Range { lowest: (t, *value), highest: (t, *value) }));
        self.filled = 1;
    }

    /// Joins the spans in pairs.
    fn halve(&mut self) {
        let columns = self.columns;
        for span in 0..SPANS {
            for column in 0..columns {
                let mut both = self.ranges[2 * span * columns + column];
                both.join(&self.ranges[(2 * span + 1) * columns + column]);
                self.ranges[span * columns + column] = both;
            }
        }
        self.ranges.truncate(SPANS * columns);
        self.width = 2 * self.width + 1;
    }

    /// Adds the last row again, since its span may show other rows.
    pub fn finish(&mut self, t: f64, values: &[f64]) {
        self.last = Some((t, values.to_vec()));
    }

    /// Times and values of a column, in the order of time, from the first row to the last.
    pub fn points(&self, column: usize) -> Vec<(f64, f64)> {
        let Some((first_time, first)) = &self.first else { return Vec::new() };
        let ranges = || self.ranges.iter().skip(column).step_by(self.columns);
        let mut points: Vec<(f64, f64)> = Vec::with_capacity(2 * ranges().len() + 2);
        if ranges().next().is_some_and(|range| range.lowest.0.min(range.highest.0) > *first_time) {
            points.push((*first_time, first[column]));
        }
        for Range { lowest, highest } in ranges() {
            let (first, second) = if lowest.0 <= highest.0 { (lowest, highest) } else { (highest, lowest) };
            points.push(*first);
            points.extend(Some(*second).filter(|second| second.0 > first.0));
        }
        if let Some((t, values)) = &self.last
            && points.last().is_some_and(|point| point.0 < *t)
        {
            points.push((*t, values[column]));
        }
        points
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_short_series_is_kept_whole() {
        let mut envelope = Envelope::default();
        let rows: Vec<(f64, f64)> = (0..2 * SPANS).map(|i| (i as f64, (i as f64).sin())).collect();
        rows.iter().for_each(|(t, value)| envelope.row(*t, &[0.0, *value]));
        assert_eq!(envelope.points(1), rows);
    }

    #[test]
    fn every_peak_of_a_long_series_is_kept() {
        let mut envelope = Envelope::default();
        let count = 1_000_003;
        let peak = |i: usize| if i % 99_991 == 77 { 5.0 } else { (i as f64 * 0.37).sin() };
        (0..count).for_each(|i| envelope.row(i as f64, &[peak(i)]));
        envelope.finish((count - 1) as f64, &[peak(count - 1)]);
        let points = envelope.points(0);
        assert!(points.len() <= 4 * SPANS + 2, "{}", points.len());
        assert_eq!(points[0], (0.0, peak(0)));
        assert!(points.is_sorted_by(|a, b| a.0 < b.0));
        assert_eq!(points.iter().filter(|point| point.1 == 5.0).count(), count.div_ceil(99_991));
        assert_eq!(points.last().map(|point| point.0), Some((count - 1) as f64));
    }
}
