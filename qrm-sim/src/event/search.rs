//! The search for the first time at which an event reaches zero.
//!
//! Parts of the motion in which the event's bound is negative are excluded. Others are halved, until the event is known to
//! rise, to fall or to have one maximum. Its zero or its maximum is then evaluated on the motion itself.

use qrm_core::{Interval, Mechanism};

use super::{EventFunction, HAS_BOUNDS};
use crate::bounds::{ArgumentPolynomials, FunctionBounds};
use crate::state::State;

/// The largest number of bounds for one step.
const MOST_BOUNDS: u32 = 20_000;
/// The shortest step that is looked into, in parts of the scene's step: corners lie between states as near as that.
const SHORTEST_STEP: f64 = 1e-10;
/// The shortest part of a step.
const SHORTEST: f64 = 1e-15;
/// The shortest part of a step, in parts of the time.
const RESOLUTION: f64 = 4.0 * f64::EPSILON;
/// The longest part of a step that is looked at by numbers alone, where the event has no bound.
const UNBOUNDED: f64 = 1.0 / 32.0;
/// The part of a step behind a maximum at which the event is lower.
const LATER: f64 = 1e-3;
/// The ratio of distances from a pole, their number, and the least growth of an event over all of them.
const POLE_RATIO: f64 = 16.0;
const MOST_DISTANCES: i32 = 9;
const POLE_GROWTH: f64 = 100.0;
/// The largest rounding error of an event at zero, in parts of its distance from zero at the begin of a step.
const MOST_ROUNDING: f64 = 1e-3;
/// The largest number of times that a step is halved for its motion to be a polynomial.
const MOST_HALVINGS: u32 = 5;

/// Where an event reaches zero first.
#[derive(Clone, Debug)]
pub(crate) enum Reached {
    /// It rises through zero before this state, at which it is not negative.
    Crossed(State),
    /// It is largest here, where it differs from zero by rounding errors at most; a corner has no smooth maximum.
    Touched(State, Option<Maximum>),
    /// It has no value at this time.
    Undefined(f64),
    /// Between these times its bounds do not tell.
    Undecided([f64; 2]),
}

/// A smooth maximum of an event along the motion.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Maximum {
    /// The rounding error of its value.
    pub(crate) rounding: f64,
    /// Half of the second derivative by time.
    pub(crate) half_curvature: f64,
}

impl Maximum {
    /// The time that the value takes to fall by an amount and by its rounding error.
    pub(crate) fn time_to_fall(self, amount: f64) -> f64 {
        ((amount + self.rounding) / self.half_curvature.abs()).sqrt()
    }
}

/// Whether the event is negative, by its bound.
fn is_below(bound: Interval) -> bool {
    bound.hi() < 0.0
}

impl EventFunction<'_> {
    /// Where the event reaches zero first in a step, at whose begin it is negative; `at` computes states of the motion
    /// inside, with accelerations and multipliers if the event takes them.
    pub(crate) fn first_inside(
        &self,
        mechanism: &dyn Mechanism,
        ends: [&State; 2],
        at: &mut dyn FnMut(f64) -> Option<State>,
    ) -> Option<Reached> {
        if !HAS_BOUNDS {
            return None;
        }
        let found = self.first_in_parts(mechanism, (ends, MOST_HALVINGS), at);
        // The motion may jump later than its polynomials.
        found.or_else(|| {
            self.value(mechanism, ends[1]).filter(|value| *value >= 0.0).map(|_| Reached::Crossed(ends[1].clone()))
        })
    }

    /// Whether the event may come near zero in a step, by its bound.
    pub(crate) fn may_come_near_zero(&self, mechanism: &dyn Mechanism, ends: [&State; 2]) -> bool {
        let mut solver = self.solver.as_ref().map(|solver| solver.borrow_mut());
        let is_negative = self.with_bounds(mechanism, |bounds| {
            let arguments = &bounds.function.arguments;
            let motion = ArgumentPolynomials::between(mechanism, solver.as_deref_mut(), ends, arguments);
            motion.is_some_and(|motion| bounds.is_negative_in(&motion))
        });
        is_negative != Some(true)
    }

    /// Halves the step until the motion is a polynomial, and looks at each part.
    #[inline(never)] // One copy: pages are to be small.
    fn first_in_parts(
        &self,
        mechanism: &dyn Mechanism,
        ([from, to], halvings): ([&State; 2], u32),
        at: &mut dyn FnMut(f64) -> Option<State>,
    ) -> Option<Reached> {
        let (begin, h) = (from.t, to.t - from.t);
        if h <= SHORTEST_STEP * mechanism.schedule().step || h <= RESOLUTION * to.t.abs() {
            let has_crossed = self.value(mechanism, to).is_some_and(|value| value >= 0.0);
            return has_crossed.then(|| Reached::Crossed(to.clone()));
        }
        let mut solver = self.solver.as_ref().map(|solver| solver.borrow_mut());
        let motion = self.with_bounds(mechanism, |bounds| {
            ArgumentPolynomials::between(mechanism, solver.as_deref_mut(), [from, to], &bounds.function.arguments)
        })?;
        drop(solver);
        let Some(mut motion) = motion else { return Some(Reached::Undecided([from.t, to.t])) };
        if self.with_bounds(mechanism, |bounds| bounds.is_negative_in(&motion))? {
            return None;
        }
        let has_crossed = self.value(mechanism, to).is_some_and(|value| value >= 0.0);
        // The natural bound of the slope often suffices, and takes a fifth of the time of the others.
        if has_crossed && self.with_bounds(mechanism, |bounds| bounds.function.rises(&motion))? {
            return Some(Reached::Crossed(to.clone()));
        }
        let bound = self.with_bounds(mechanism, |bounds| bounds.function.within(&motion, [0.0, 1.0], is_below))?;
        if bound.value.hi() < 0.0 {
            return None;
        }
        if has_crossed && bound.slope.lo() > 0.0 {
            return Some(Reached::Crossed(to.clone()));
        }
        if let Some(middle) = at(begin + 0.5 * h) {
            let is_polynomial = motion.compare_with(&middle);
            if self.with_bounds(mechanism, |bounds| bounds.function.within(&motion, [0.0, 1.0], is_below))?.value.hi()
                < 0.0
            {
                return None;
            }
            if !is_polynomial && halvings > 0 {
                let first = self.first_in_parts(mechanism, ([from, &middle], halvings - 1), at);
                return first.or_else(|| self.first_in_parts(mechanism, ([&middle, to], halvings - 1), at));
            }
        }
        let errors = motion.take_errors();
        let shortest = SHORTEST.max(RESOLUTION * begin.abs().max(to.t.abs()) / h);
        self.with_bounds(mechanism, |bounds| {
            let mut value = |at: &State| self.value(mechanism, at).unwrap_or(f64::NAN);
            let mut at = |s: f64| if s >= 1.0 { Some(to.clone()) } else { at(begin + s * h) };
            let deepest = self.value(mechanism, from).map_or(0.0, f64::abs);
            let step =
                Step { motion: &motion, errors: &errors, begin, h, shortest, deepest, value: &mut value, at: &mut at };
            Search { step, bounds: &mut bounds.function, left: MOST_BOUNDS }.first_in([0.0, 1.0])
        })?
    }
}

/// The motion of a step.
struct Step<'s> {
    motion: &'s ArgumentPolynomials,
    /// The motion with its errors.
    errors: &'s ArgumentPolynomials,
    begin: f64,
    h: f64,
    /// The shortest part of the step that is looked at.
    shortest: f64,
    /// How far the event is from zero at the begin.
    deepest: f64,
    /// The event at a state.
    value: &'s mut dyn FnMut(&State) -> f64,
    /// The state at a part of the step.
    at: &'s mut dyn FnMut(f64) -> Option<State>,
}

struct Search<'s> {
    step: Step<'s>,
    bounds: &'s mut FunctionBounds,
    /// The number of bounds that may still be computed.
    left: u32,
}

impl Search<'_> {
    /// Where the event reaches zero first in a part of the step; it does not before.
    fn first_in(&mut self, [begin, end]: [f64; 2]) -> Option<Reached> {
        let bound = self.bounds.within(self.step.motion, [begin, end], is_below);
        if bound.value.hi() < 0.0 {
            return None;
        }
        if bound.slope.hi() < 0.0 {
            // It may have jumped before, or jumps on the motion later than on its polynomials.
            return self.crossed(begin).or_else(|| self.crossed(end));
        }
        if bound.value.lo() > 0.0 || bound.slope.lo() > 0.0 {
            return self.crossed(end);
        }
        let middle = 0.5 * (begin + end);
        if bound.curvature.hi() < 0.0 {
            let (motion, shortest) = (self.step.motion, self.step.shortest);
            let (place, half_curvature) = self.bounds.turning_point(motion, [begin, end], (1.0, shortest));
            return self.touched(place, Some(half_curvature));
        }
        let rounding = self.bounds.rounding(self.step.motion, end);
        if bound.value.lo() >= -2.0 * rounding {
            let reached = self.crossed(end).or_else(|| self.touched(middle, None))?;
            let first = (self.step.at)(begin)?;
            let at_first = (self.step.value)(&first);
            // In all of this part it differs from zero by rounding errors.
            return Some(match reached {
                _ if at_first >= 0.0 => Reached::Crossed(first),
                _ if at_first >= -4.0 * rounding => Reached::Touched(first, None),
                reached => reached,
            });
        }
        let uncertainty = self.bounds.at(self.step.motion, middle).width();
        let is_rounding = uncertainty.is_finite() && bound.value.width() <= 2.0 * uncertainty;
        // The bounds of some numbers are infinite, such as those of large exponentials.
        let is_unbounded = !uncertainty.is_finite()
            && end - begin <= UNBOUNDED
            && [begin, end].iter().all(|s| !self.bounds.at(self.step.motion, *s).is_finite());
        if is_rounding || is_unbounded {
            // Halves would tell no more than numbers.
            return self.touched(end, None);
        }
        let undecided = Reached::Undecided([begin, end].map(|s| self.step.begin + s * self.step.h));
        if end - begin <= self.step.shortest {
            let found = self.touched(middle, None);
            return if found.is_some() || bound.value.is_finite() {
                found
            } else {
                self.beside_pole(middle, undecided)
            };
        }
        self.left = self.left.saturating_sub(1);
        if self.left == 0 {
            return Some(undecided);
        }
        self.first_in([begin, middle]).or_else(|| self.first_in([middle, end]))
    }

    /// Where the event is not negative next to a place at which its bound is infinite; undecided if it grows towards it.
    fn beside_pole(&mut self, s: f64, undecided: Reached) -> Option<Reached> {
        let mut grows = false;
        for side in [-1.0, 1.0] {
            let mut sizes = Vec::new();
            for k in 1..=MOST_DISTANCES {
                let place = s + side * self.step.shortest * POLE_RATIO.powi(k);
                let inside = if (0.0..=1.0).contains(&place) { (self.step.at)(place) } else { None };
                let Some(at) = inside else { continue };
                let value = (self.step.value)(&at);
                if value >= 0.0 {
                    return Some(Reached::Crossed(at));
                }
                sizes.push(if value.is_nan() { 0.0 } else { value.abs() });
            }
            grows |= matches!(sizes[..], [near, .., far] if near > POLE_GROWTH * far);
        }
        grows.then_some(undecided)
    }

    /// Whether the event is not negative at the end of a part in which it rises.
    fn crossed(&mut self, s: f64) -> Option<Reached> {
        if self.bounds.at(self.step.motion, s).hi() < 0.0 {
            return None;
        }
        let at = (self.step.at)(s)?;
        ((self.step.value)(&at) >= 0.0).then_some(Reached::Crossed(at))
    }

    /// Whether the event reaches zero where it is largest in a part of the step, with half of its second derivative by
    /// the part there; `None` where it may jump or have a corner.
    fn touched(&mut self, s: f64, half_curvature: Option<f64>) -> Option<Reached> {
        if self.bounds.at(self.step.errors, s).hi() < 0.0 {
            return None;
        }
        let at = (self.step.at)(s)?;
        let value = (self.step.value)(&at);
        if value.is_nan() {
            return Some(Reached::Undefined(at.t));
        }
        let (own, of_motion) = (self.step.motion, self.step.errors);
        let mut rounding = self.bounds.rounding(own, s);
        if value < -rounding {
            // The motion may differ from its polynomials, where it falls behind this place: else it is crossed later.
            let later = (self.step.at)((s + LATER).min(1.0))?;
            if (self.step.value)(&later) < value {
                rounding = rounding.max(self.bounds.rounding(of_motion, s));
            }
        }
        if rounding > MOST_ROUNDING * self.step.deepest {
            rounding = 0.0;
        }
        if value > rounding || value >= 0.0 && half_curvature.is_none() {
            return Some(Reached::Crossed(at));
        }
        let h = self.step.h;
        let maximum =
            half_curvature.map(|half_curvature| Maximum { rounding, half_curvature: half_curvature / (h * h) });
        (value >= -rounding).then_some(Reached::Touched(at, maximum))
    }
}
