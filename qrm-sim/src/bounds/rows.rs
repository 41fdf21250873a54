//! The intervals of a function's arguments among rows of a motion.

use qrm_core::Interval;

use super::arguments::ball;

/// Rows of a motion of `n` coordinates, and the states between them: time, coordinates, rates, accelerations and
/// multipliers, which are numbered as arguments are.
pub(crate) struct RowBoxes<'r> {
    rows: &'r [&'r [f64]],
    n: usize,
    /// The largest time between neighbouring rows.
    pub(crate) spacing: f64,
    /// The intervals of the values in the rows, of arguments and their derivatives.
    hulls: Vec<Option<Interval>>,
}

impl<'r> RowBoxes<'r> {
    /// Prepares the intervals of some arguments among at least two rows.
    pub(crate) fn new(rows: &'r [&'r [f64]], n: usize, arguments: &[usize]) -> Self {
        let spacing = rows.windows(2).fold(0.0_f64, |largest, pair| largest.max(pair[1][0] - pair[0][0]));
        let mut hulls = Vec::new();
        for &argument in arguments {
            // Rates and accelerations of a coordinate follow it at distances of n.
            let derivatives = (argument..=3 * n).step_by(n.max(1)).skip(1).filter(|_| argument > 0);
            for place in [argument].into_iter().chain(derivatives) {
                hulls.resize(hulls.len().max(place + 1), None);
                hulls[place] = hulls[place].or_else(|| Some(hull(rows, place)));
            }
        }
        Self { rows, n, spacing, hulls }
    }

    /// The intervals of the Taylor coefficients of this order of some arguments: their values, their rates, or half of
    /// their second derivatives.
    pub(crate) fn coefficients(&self, order: usize, arguments: &[usize]) -> Vec<Interval> {
        let coefficient = match order {
            0 => Self::value,
            1 => Self::rate,
            _ => Self::half_curvature,
        };
        arguments.iter().map(|&argument| coefficient(self, argument)).collect()
    }

    /// The interval of an argument from the first row to the last one.
    ///
    /// It contains the control points of the polynomials between two rows. A number that is computed from a state may
    /// change between rows as much as from one row to the next.
    fn value(&self, argument: usize) -> Interval {
        let Self { n, spacing, .. } = *self;
        let size = |argument: usize| self.hull(argument).magnitude();
        match argument {
            0 => self.hull(0),
            i if i <= n => wider(self.hull(i), spacing * (0.4 * size(i + n) + 0.05 * spacing * size(i + 2 * n))),
            i if i <= 2 * n => wider(self.hull(i), spacing / 3.0 * size(i + n)),
            i => wider(self.hull(i), self.change(i)),
        }
    }

    /// The interval of the rate of an argument.
    ///
    /// That of a number that is computed from a state is between those from row to row, as far as these change.
    fn rate(&self, argument: usize) -> Interval {
        match argument {
            0 => Interval::ONE,
            i if i <= 2 * self.n => self.value(i + self.n),
            i => with_changes(self.rows.windows(2).map(|pair| slope(pair, i))),
        }
    }

    /// The interval of half of the second derivative of an argument.
    fn half_curvature(&self, argument: usize) -> Interval {
        match argument {
            0 => Interval::ZERO,
            i if i <= 2 * self.n => self.rate(i + self.n) * Interval::point(0.5),
            i => with_changes(
                self.rows
                    .windows(3)
                    .map(|rows| (slope(&rows[1..], i) - slope(&rows[..2], i)) / (rows[2][0] - rows[0][0])),
            ),
        }
    }

    /// The largest change of an argument from one row to the next.
    fn change(&self, argument: usize) -> f64 {
        let pairs = self.rows.windows(2);
        pairs.fold(0.0, |largest, pair| largest.max((pair[1][argument] - pair[0][argument]).abs()))
    }

    /// The interval of an argument's values in the rows.
    fn hull(&self, argument: usize) -> Interval {
        self.hulls.get(argument).copied().flatten().unwrap_or_else(|| hull(self.rows, argument))
    }
}

/// The interval of the numbers of rows at a place.
fn hull(rows: &[&[f64]], place: usize) -> Interval {
    let [mut low, mut high] = [rows[0][place]; 2];
    for row in rows {
        let value = row[place];
        if value < low {
            low = value;
        }
        if value > high {
            high = value;
        }
    }
    Interval::new(low, high)
}

/// The difference quotient of an argument from a row to the next one.
fn slope(pair: &[&[f64]], argument: usize) -> f64 {
    (pair[1][argument] - pair[0][argument]) / (pair[1][0] - pair[0][0])
}

/// The interval of some numbers, with their largest change from one to the next around it; around a single number lies
/// its own size.
fn with_changes(mut numbers: impl Iterator<Item = f64>) -> Interval {
    let Some(first) = numbers.next() else { return Interval::ZERO };
    let (mut low, mut high, mut last, mut change) = (first, first, first, None);
    for number in numbers {
        (low, high) = (low.min(number), high.max(number));
        change = Some(change.unwrap_or(0.0_f64).max((number - last).abs()));
        last = number;
    }
    wider(Interval::new(low, high), change.unwrap_or(first.abs()))
}

/// An interval with some distance around it.
fn wider(interval: Interval, distance: f64) -> Interval {
    interval + ball(0.0, distance)
}
