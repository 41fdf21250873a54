//! The steps between rows of a motion in which an event may reach zero.

use std::ops::Range;

use qrm_core::{Interval, Mechanism};

use super::EventFunction;
use super::bounds::{EventBounds, ball};

impl EventFunction<'_> {
    /// The steps between rows of a motion in which the event may reach zero, from a row on.
    ///
    /// A step has the number of the row before it.
    ///
    /// A row has time, coordinates, rates, accelerations and multipliers.
    pub(crate) fn undecided_steps(&self, mechanism: &dyn Mechanism, rows: &[&[f64]], first: usize) -> Vec<usize> {
        let mut undecided = Vec::new();
        let n = mechanism.description().coordinates.len();
        self.with_bounds(mechanism, |bounds| add_undecided(bounds, (rows, n), first..rows.len() - 1, &mut undecided));
        undecided
    }
}

/// Adds those of some steps between rows in which the event may reach zero.
fn add_undecided(
    bounds: &mut EventBounds,
    (rows, n): (&[&[f64]], usize),
    steps: Range<usize>,
    undecided: &mut Vec<usize>,
) {
    if steps.is_empty() {
        return;
    }
    let is_single = steps.len() == 1;
    // The rows around a step show how fast numbers change that are computed from a state.
    let around = if is_single && bounds.takes_forces(n) {
        steps.start.saturating_sub(1)..(steps.end + 2).min(rows.len())
    } else {
        steps.start..steps.end + 1
    };
    let is_known = !bounds.takes_forces(n) || around.len() > 2;
    if is_known && !may_reach_zero(bounds, &rows[around], n) {
        return;
    }
    if is_single {
        return undecided.push(steps.start);
    }
    let middle = steps.start + steps.len() / 2;
    add_undecided(bounds, (rows, n), steps.start..middle, undecided);
    add_undecided(bounds, (rows, n), middle..steps.end, undecided);
}

/// Whether the event may reach zero between the first and the last of some rows.
fn may_reach_zero(bounds: &mut EventBounds, rows: &[&[f64]], n: usize) -> bool {
    let middle = rows[rows.len() / 2];
    let spacing = rows.windows(2).fold(0.0_f64, |largest, pair| largest.max(pair[1][0] - pair[0][0]));
    // Numbers that are computed from a state may change between rows as much as from one row to the next.
    let derived = |place: usize| {
        let [mut change, mut rate] = [0.0_f64; 2];
        for pair in rows.windows(2) {
            let difference = (pair[1][place] - pair[0][place]).abs();
            change = change.max(difference);
            rate = rate.max(difference / (pair[1][0] - pair[0][0]));
        }
        [wider(hull(rows, place), change), ball(0.0, 2.0 * rate)]
    };
    // The control points of the polynomials between two rows.
    let rate = |i: usize| wider(hull(rows, i + n), spacing / 3.0 * hull(rows, i + 2 * n).magnitude());
    let boxed = |argument: usize| match argument {
        0 => [hull(rows, 0), Interval::ONE],
        i if i <= n => {
            let [first, second] = [hull(rows, i + n), hull(rows, i + 2 * n)].map(Interval::magnitude);
            [wider(hull(rows, i), spacing * (0.4 * first + 0.05 * spacing * second)), rate(i)]
        }
        i if i <= 2 * n => [rate(i - n), derived(i + n)[0]],
        i => derived(i),
    };
    let last = rows.len() - 1;
    let (ranges, rates): (Vec<_>, Vec<_>) =
        bounds.arguments.iter().map(|&argument| boxed(argument)).map(|[range, rate]| (range, rate)).unzip();
    let at: Vec<Interval> = bounds.arguments.iter().map(|&argument| ball(middle[argument], 0.0)).collect();
    bounds.may_reach_zero([&ranges, &rates], &at, [middle[0] - rows[0][0], rows[last][0] - middle[0]])
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

/// An interval with some distance around it.
fn wider(interval: Interval, distance: f64) -> Interval {
    interval + ball(0.0, distance)
}
