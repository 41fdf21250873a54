//! The steps between rows of a motion in which an event may come near zero.

use std::ops::Range;

use qrm_core::{Interval, Mechanism};

use super::EventFunction;
use super::bounds::EventBounds;
use crate::bounds::{RowBoxes, ball};

impl EventFunction<'_> {
    /// The steps between rows of a motion in which the event may come near zero, from a row on.
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

/// Adds those of some steps between rows in which the event may come near zero.
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
    let around = if is_single && bounds.function.takes_forces(n) {
        steps.start.saturating_sub(1)..(steps.end + 2).min(rows.len())
    } else {
        steps.start..steps.end + 1
    };
    let is_known = !bounds.function.takes_forces(n) || around.len() > 2;
    if is_known && !may_come_near_zero(bounds, &rows[around], n) {
        return;
    }
    if is_single {
        return undecided.push(steps.start);
    }
    let middle = steps.start + steps.len() / 2;
    add_undecided(bounds, (rows, n), steps.start..middle, undecided);
    add_undecided(bounds, (rows, n), middle..steps.end, undecided);
}

/// Whether the event may come near zero between the first and the last of some rows.
fn may_come_near_zero(bounds: &mut EventBounds, rows: &[&[f64]], n: usize) -> bool {
    let arguments = &bounds.function.arguments;
    let boxes = RowBoxes::new(rows, n, arguments);
    let (middle, last) = (rows[rows.len() / 2], rows.len() - 1);
    let [ranges, rates] = [0, 1].map(|order| boxes.coefficients(order, arguments));
    let at: Vec<Interval> = arguments.iter().map(|&argument| ball(middle[argument], 0.0)).collect();
    bounds.may_come_near_zero([&ranges, &rates], &at, [middle[0] - rows[0][0], rows[last][0] - middle[0]])
}
