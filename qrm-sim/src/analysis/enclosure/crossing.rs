//! The time at which a coordinate of an enclosed motion reaches a value.

use qrm_core::Interval;

use super::Reason;
use super::flow::{Flow, NoSeries};
use super::state_set::StateSet;
use super::step::Step;

/// The result of a step towards a value of a coordinate.
pub(super) enum CrossingResult {
    /// The coordinate has not reached the value by the time of these states.
    NotReached(StateSet),
    /// The time at which it reached the value, and the states at that time.
    At(Interval, Vec<Interval>),
}

/// The fraction of a step around the estimated time within which the value must be reached.
const WINDOW: f64 = 1e-3;
/// The number of halvings of a step that ends too near the value.
const HALVINGS: u32 = 20;
/// The number of bisections for the estimate of a time.
const BISECTIONS: u32 = 60;

impl Step {
    /// Returns the states at a time of the step, or at the earlier time at which a coordinate reaches one of two
    /// values.
    ///
    /// The coordinate has not reached them at the beginning of the step. If its rate has one sign in the whole bound of
    /// the step, it reaches a value at most once. A step that ends too near a value is shortened.
    ///
    /// # Errors
    /// It is not certain whether the value is reached.
    pub(super) fn states_or_crossing(
        &self,
        flow: &mut Flow,
        coordinate: usize,
        targets: [Interval; 2],
        mut to: f64,
    ) -> Result<CrossingResult, Reason> {
        let begin = self.begin();
        let n = self.bound.len() / 2;
        let mut near = targets.into_iter().filter(|target| self.bound[coordinate].intersection(*target).is_some());
        let states = |flow: &mut Flow, to: f64| self.states(flow, to).ok_or(Reason::NoSeries(NoSeries::Singular));
        let Some(target) = near.next() else { return states(flow, to).map(CrossingResult::NotReached) };
        let is_monotonic = near.next().is_none() && !self.bound[n + coordinate].contains(0.0);
        let before = |x: Interval| x.intersection(target).is_none();
        for _ in 0..HALVINGS {
            if before(self.range(coordinate, Interval::new(0.0, to - begin))) {
                return states(flow, to).map(CrossingResult::NotReached);
            }
            if is_monotonic {
                let rises = self.bound[n + coordinate].lo() > 0.0;
                let is_beyond = |x: Interval| if rises { x.lo() > target.hi() } else { x.hi() < target.lo() };
                let end = states(flow, to)?;
                let reached = end.hull[coordinate];
                if !is_beyond(reached) && before(reached) {
                    return Ok(CrossingResult::NotReached(end));
                }
                if is_beyond(reached)
                    && let Some((t, states)) = self.cross(flow, coordinate, target, to)
                {
                    return Ok(CrossingResult::At(t, states));
                }
            }
            to = begin + 0.5 * (to - begin);
        }
        Err(Reason::NotCrossed)
    }

    /// The time at which a coordinate reaches a value, and the states at that time: one step of the interval Newton
    /// method in time, from an estimate.
    fn cross(
        &self,
        flow: &mut Flow,
        coordinate: usize,
        target: Interval,
        to: f64,
    ) -> Option<(Interval, Vec<Interval>)> {
        let (begin, n) = (self.begin(), self.bound.len() / 2);
        let [mut low, mut high] = [begin, to];
        let is_before = self.range(coordinate, Interval::ZERO).mid() < target.mid();
        for _ in 0..BISECTIONS {
            let middle = 0.5 * (low + high);
            let value = self.range(coordinate, Interval::point(middle - begin)).mid();
            *(if (value < target.mid()) == is_before { &mut low } else { &mut high }) = middle;
        }
        let estimate = low;
        let part = WINDOW * (to - begin);
        let window = Interval::new((estimate - part).max(begin), (estimate + part).min(to));
        let range = |i: usize, times: Interval| self.range(i, times - Interval::point(begin));
        let at = self.states(flow, estimate)?.hull;
        let change = (target - at[coordinate]) / range(n + coordinate, window);
        let time = Interval::point(estimate) + change;
        if !time.is_inside(window) {
            return None;
        }
        let times = time.hull(Interval::point(estimate));
        let states: Vec<Interval> = (0..2 * n).map(|i| range(i, times)).collect();
        let slopes = flow.expand(times, &states, None, 1).ok()?;
        Some((time, at.iter().enumerate().map(|(i, at)| *at + change * slopes.at(1, i)[0]).collect()))
    }
}
