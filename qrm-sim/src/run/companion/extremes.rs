//! Compares extremes of a run with its companion's motion.

use qrm_core::Mechanism;

use super::super::extremes::FoundExtreme;
use super::Companion;
use crate::columns::number;
use crate::integrate::{Corner, Integrator, StepError};
use crate::solve::MultiplierRounding;
use crate::state::State;

impl Companion {
    /// The state at a time after the first of the last rows, by a copy of the integrator, so that the companion itself
    /// is not affected. Steps of the run have the length `of_run`, those of the companion `step`.
    pub(super) fn step_to(
        &self,
        mechanism: &dyn Mechanism,
        integrator: &mut Integrator,
        made: usize,
        [of_run, step]: [f64; 2],
        t: f64,
    ) -> Option<State> {
        let width = self.layout.width();
        let states = &self.rows[..(made + 1) * width];
        let later = states.chunks_exact(width).rev().position(|row| row[0] <= t)?;
        let mut at = State::from_row(self.layout, &states[(made - later) * width..]);
        // The same steps from the common start would show no difference.
        let step = if at.t == self.start { 0.5 * (t - at.t) / ((t - at.t) / of_run).ceil() } else { step };
        while at.t < t {
            at = integrator.between(mechanism, &at, t.min(at.t + step)).ok()?;
        }
        Some(at)
    }

    /// Compares an extreme of the run with the companion's motion at that time.
    pub(super) fn compare_at(&mut self, mechanism: &dyn Mechanism, extreme: &FoundExtreme) -> Result<(), StepError> {
        if !self.may_matter(extreme) {
            return Ok(());
        }
        self.move_to(mechanism, extreme.t)?;
        let at = (self.at.t == extreme.t).then(|| self.at.clone());
        self.compare(mechanism, extreme, at.as_ref());
        Ok(())
    }

    /// Whether an extreme must be compared with the companion's motion: a rival only if the largest difference exceeds
    /// its distance from the extreme, by twice as much as for earlier rivals.
    pub(super) fn may_matter(&mut self, extreme: &FoundExtreme) -> bool {
        let Some(behind) = extreme.behind else { return true };
        let place = self.differences.quantities.place_of_column(extreme.column);
        let Some(difference) = place.and_then(|place| self.differences.each.get_mut(place)) else { return false };
        let reach = difference.largest - behind;
        let compared = &mut difference.reach_of_rivals[extreme.end];
        let may_matter = reach > 2.0 * *compared;
        if may_matter {
            *compared = reach;
        }
        may_matter
    }

    /// Compares an extreme of the run, or a rival of that, with a state at its time.
    pub(super) fn compare(&mut self, mechanism: &dyn Mechanism, extreme: &FoundExtreme, other: Option<&State>) {
        let Some(place) = self.differences.quantities.place_of_column(extreme.column) else { return };
        let rounding = match other {
            Some(at) if self.by_forces[place] => self.integrator.solver_mut().rounding_of_multipliers(mechanism, at),
            _ => MultiplierRounding::default(),
        };
        self.rounding_at_poles = self.rounding_at_poles.max(rounding.at_pole.unwrap_or(0.0));
        // Rounding errors do not grow with the step, unlike differences.
        let ratio = self.ratio();
        let Some(difference) = self.differences.each.get_mut(place) else { return };
        let error = other.map(|other| {
            let value = number(mechanism, other, extreme.column);
            let mut rounded = other.clone();
            rounded.multipliers.iter_mut().for_each(|multiplier| *multiplier *= 1.0 + rounding.error);
            let of_rounding = (number(mechanism, &rounded, extreme.column) - value).abs();
            let difference = (extreme.value - value).abs().max(ratio * of_rounding);
            let is_regular = !rounding.is_irregular;
            let change = is_regular.then(|| change_within_time_resolution(mechanism, other, extreme.column));
            difference.max(change.unwrap_or(0.0))
        });
        if extreme.behind.is_some() {
            error.into_iter().for_each(|error| difference.note_rival(extreme.end, (extreme.value, error)));
        } else {
            // If the other motion is unknown there, its largest difference is used.
            let found = error.unwrap_or(difference.largest);
            let before = std::mem::replace(&mut difference.at_extremes[extreme.end], (extreme.value, found));
            difference.note_rival(extreme.end, before);
        }
    }
}

/// The change of a column along the motion within the time resolution of corners. If the column has a corner there,
/// steps that end next to it miss its value by that much. Slopes and jumps do not count.
fn change_within_time_resolution(mechanism: &dyn Mechanism, at: &State, column: usize) -> f64 {
    let here = number(mechanism, at, column);
    let reach = Corner(at.t).just_after() - at.t;
    let mut neighbour = at.clone();
    let mut change = |h: f64| {
        neighbour.clone_from(at);
        neighbour.move_along(h);
        let State { t, q, qd, qdd, multipliers, .. } = &mut neighbour;
        let is_known = mechanism.accelerations(*t, q, qd, qdd, multipliers);
        if is_known { number(mechanism, &neighbour, column) - here } else { 0.0 }
    };
    // The corner may lie in the middle of the interval.
    let [mut backwards, mut forwards, mut bend] = [0.0_f64; 3];
    for h in [0.5 * reach, reach] {
        let [back, forth] = [change(-h), change(h)];
        backwards = backwards.max(back.abs());
        forwards = forwards.max(forth.abs());
        bend = bend.max((back + forth).abs());
    }
    bend.min(backwards).min(forwards)
}
