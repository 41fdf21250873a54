//! The time at which an event ends an enclosed motion.

use qrm_core::Interval;

use super::Reason;
use super::event::Event;
use super::flow::{Flow, NoSeries};
use super::state_set::StateSet;
use super::step::Step;

/// The result of a step towards an event.
pub(super) enum CrossingResult {
    /// The event has not come by the time of these states.
    NotReached(StateSet),
    /// The time of the event, and the states at that time.
    At(Interval, Vec<Interval>),
}

/// The fraction of a step around the estimated time within which the event must come.
const WINDOW: f64 = 1e-3;
/// The number of halvings of a step that ends too near the event.
const HALVINGS: u32 = 20;
/// The number of bisections for the estimate of a time.
const BISECTIONS: u32 = 60;

impl Step {
    /// Returns the states at a time of the step, or at the earlier time of an event.
    ///
    /// The event has not come at the beginning of the step. It comes once if its function rises in all of the step. A
    /// step that ends too near the event is shortened.
    ///
    /// # Errors
    /// It is not certain whether the event comes.
    pub(super) fn states_or_crossing(
        &self,
        flow: &mut Flow,
        event: &mut Event,
        mut to: f64,
    ) -> Result<CrossingResult, Reason> {
        let begin = self.begin();
        let states = |flow: &mut Flow, to: f64| self.states(flow, to).ok_or(Reason::NoSeries(NoSeries::Singular));
        if event.value(Interval::new(begin, to), &self.bound).hi() < 0.0 {
            return states(flow, to).map(CrossingResult::NotReached);
        }
        for _ in 0..HALVINGS {
            let times = Interval::new(begin, to);
            let within = self.ranges(times);
            if event.value(times, &within).hi() < 0.0 {
                return states(flow, to).map(CrossingResult::NotReached);
            }
            if event.rate(flow, times, &within).is_some_and(|rate| rate.lo() > 0.0) {
                let end = states(flow, to)?;
                let value = event.value(Interval::point(to), &end.hull);
                if value.hi() < 0.0 {
                    return Ok(CrossingResult::NotReached(end));
                }
                if value.lo() > 0.0
                    && let Some((t, states)) = self.cross(flow, event, to)
                {
                    return Ok(CrossingResult::At(t, states));
                }
            }
            to = begin + 0.5 * (to - begin);
        }
        Err(Reason::NotCrossed)
    }

    /// The time of an event whose function rises, and the states at that time: one step of the interval Newton method
    /// in time, from an estimate.
    fn cross(&self, flow: &mut Flow, event: &mut Event, to: f64) -> Option<(Interval, Vec<Interval>)> {
        let begin = self.begin();
        let [mut low, mut high] = [begin, to];
        for _ in 0..BISECTIONS {
            let middle = 0.5 * (low + high);
            let time = Interval::point(middle);
            let value = event.value(time, &self.ranges(time)).mid();
            *(if value < 0.0 { &mut low } else { &mut high }) = middle;
        }
        let estimate = low;
        let part = WINDOW * (to - begin);
        let window = Interval::new((estimate - part).max(begin), (estimate + part).min(to));
        let at = self.states(flow, estimate)?.hull;
        let value = event.value(Interval::point(estimate), &at);
        let change = -value / event.rate(flow, window, &self.ranges(window))?;
        let time = Interval::point(estimate) + change;
        if !time.is_inside(window) {
            return None;
        }
        let times = time.hull(Interval::point(estimate));
        let slopes = flow.expand(times, &self.ranges(times), None, 1).ok()?;
        Some((time, at.iter().enumerate().map(|(i, at)| *at + change * slopes.at(1, i)[0]).collect()))
    }

    /// All components in an interval of time.
    fn ranges(&self, times: Interval) -> Vec<Interval> {
        let since = times - Interval::point(self.begin());
        (0..self.bound.len()).map(|i| self.range(i, since)).collect()
    }
}
