//! The series of a column in bounded memory.

/// Up to twice as many spans of rows are kept.
const SPANS: usize = 1000;

/// Follows a column row by row. Of a long one it keeps the smallest and the largest value of each of many spans, so
/// that a
/// picture of it shows every peak.
#[derive(Clone, Debug, Default)]
pub(crate) struct Envelope {
    spans: Vec<Span>,
    /// The first row.
    first: Option<(f64, f64)>,
    /// The last row.
    last: Option<(f64, f64)>,
    /// The number of rows of the last span.
    filled: u64,
    /// The number of rows that each span is to have, less one.
    width: u64,
}

#[derive(Clone, Copy, Debug)]
struct Span {
    lowest: (f64, f64),
    highest: (f64, f64),
}

impl Span {
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
    pub(crate) fn row(&mut self, t: f64, value: f64) {
        let row = Span { lowest: (t, value), highest: (t, value) };
        self.first.get_or_insert((t, value));
        self.last = Some((t, value));
        match self.spans.last_mut() {
            Some(span) if self.filled <= self.width => {
                span.join(&row);
                self.filled += 1;
                return;
            }
            _ => {}
        }
        if self.spans.len() == 2 * SPANS {
            let (pairs, _) = self.spans.as_chunks::<2>();
            self.spans = pairs
                .iter()
                .map(|[first, second]| {
                    let mut both = *first;
                    both.join(second);
                    both
                })
                .collect();
            self.width = 2 * self.width + 1;
        }
        self.spans.push(row);
        self.filled = 1;
    }

    /// Times and values, in the order of time, from the first row to the last.
    pub(crate) fn points(&self) -> Vec<(f64, f64)> {
        let mut points: Vec<(f64, f64)> = Vec::with_capacity(2 * self.spans.len() + 2);
        let begins_later =
            |first: &(f64, f64)| self.spans.first().is_some_and(|span| span.lowest.0.min(span.highest.0) > first.0);
        points.extend(self.first.filter(begins_later));
        for Span { lowest, highest } in &self.spans {
            let (first, second) = if lowest.0 <= highest.0 { (lowest, highest) } else { (highest, lowest) };
            points.push(*first);
            points.extend(Some(*second).filter(|second| second.0 > first.0));
        }
        points.extend(self.last.filter(|last| points.last().is_some_and(|point| point.0 < last.0)));
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
        rows.iter().for_each(|(t, value)| envelope.row(*t, *value));
        assert_eq!(envelope.points(), rows);
    }

    #[test]
    fn every_peak_of_a_long_series_is_kept() {
        let mut envelope = Envelope::default();
        let count = 1_000_003;
        let peak = |i: usize| if i % 99_991 == 77 { 5.0 } else { (i as f64 * 0.37).sin() };
        (0..count).for_each(|i| envelope.row(i as f64, peak(i)));
        let points = envelope.points();
        assert!(points.len() <= 4 * SPANS + 2, "{}", points.len());
        assert_eq!(points[0], (0.0, peak(0)));
        assert!(points.is_sorted_by(|a, b| a.0 < b.0));
        assert_eq!(points.iter().filter(|point| point.1 == 5.0).count(), count.div_ceil(99_991));
        assert_eq!(points.last().map(|point| point.0), Some((count - 1) as f64));
    }
}
