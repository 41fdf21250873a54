//! The value of a parameter with which a steady motion meets a condition.

use std::cmp::Ordering;

use qrm_pictures::Recording;
use qrm_sim::analysis::{SteadyMotion, SteadyRequest, steady_motion};
use qrm_sim::position::Start;
use serde::Serialize;

use super::columns::{Columns, record_period};
use super::condition::Condition;
use super::failure;
use super::period::Rates;
use crate::error::Error;
use crate::format::{number, with_error};
use crate::options::check_parameter;
use crate::progress::interrupted;
use crate::setup::Setup;

/// The value that was found.
#[derive(Serialize)]
pub(super) struct Solved {
    parameter: String,
    value: f64,
    error: f64,
    condition: String,
    /// The number of motions that were found on the way.
    motions: u32,
}

/// The first step, in parts of the parameter; the longest keeps its sign.
const FIRST: f64 = 0.01;
const LONGEST: f64 = 0.7;
/// The most motions, and the most halvings of a step to one that is found.
const MOST_MOTIONS: u32 = 60;
const MOST_HALVINGS: u32 = 10;
/// The largest and the smallest value, as multiples of that in the scene.
const FARTHEST: f64 = 1e6;
/// A change of this many errors is one.
const SIGNIFICANT: f64 = 10.0;
/// A step below this part of the parameter is the last one.
const CONVERGED: f64 = 4.0 * f64::EPSILON;

impl Solved {
    /// Finds the value near that of the scene, and gives it to the parameter. Returns the start of the motion there,
    /// too. The secant method stays inside an interval as soon as there is one.
    ///
    /// # Errors
    /// No motion is found, or none meets the condition: the nearest is named.
    pub(super) fn new(
        setup: &mut Setup,
        request: &SteadyRequest,
        name: &str,
        condition: &str,
    ) -> Result<(Self, Start), Error> {
        check_parameter(setup.description, name)?;
        let place = setup.description.parameters.iter().position(|parameter| parameter.name == name).unwrap_or(0);
        let first = setup.mechanism().parameters()[place];
        let mut search = Search::new(setup, request, name, first);
        let (motion, columns) = search.motion(setup, first, None)?;
        let condition = Condition::new(condition, &columns)?;
        let gap_of =
            |columns: &Columns| condition.value(columns).map(|[value, error]| [value - condition.target, error]);
        let unknown = || Error::run(format!("{} is not known", condition.name())).help("choose another condition");
        let mut last = At { value: first, gap: gap_of(&columns).ok_or_else(unknown)?, start: motion.start };
        let mut nearest = last.clone();
        // The values between which the condition is met.
        let mut between: Option<[At; 2]> = None;
        let mut step = if first == 0.0 { FIRST } else { FIRST * first };
        while search.motions < MOST_MOTIONS {
            let Some(next) = search.next(setup, &last, step, &gap_of) else { break };
            let slope = (next.gap[0] - last.gap[0]) / (next.value - last.value);
            let noise = SIGNIFICANT * (next.gap[1] + last.gap[1]);
            if search.motions == 2 && (next.gap[0] - last.gap[0]).abs() <= noise {
                return Err(Error::usage(format!("{} does not depend on `{name}`", condition.name()))
                    .help("choose another parameter"));
            }
            nearest = [nearest, next.clone()].into_iter().min_by(At::compare).unwrap_or(next.clone());
            let is_last = step.abs() <= CONVERGED * next.value.abs();
            if nearest.is_met() || is_last && between.is_some() {
                setup.set_parameter(name, nearest.value);
                let solved = Self {
                    parameter: name.to_owned(),
                    value: nearest.value,
                    error: (nearest.gap[0].abs() + nearest.gap[1]) / slope.abs(),
                    condition: condition.text.clone(),
                    motions: search.motions,
                };
                return Ok((solved, nearest.start));
            }
            between = match between {
                None => last.is_across(&next).then(|| [last, next.clone()]),
                Some([a, _]) if a.is_across(&next) => Some([a, next.clone()]),
                Some([_, b]) => Some([next.clone(), b]),
            };
            let mut target = next.value - next.gap[0] / slope;
            if let Some([a, b]) = &between {
                let is_inside = a.value.min(b.value) < target && target < a.value.max(b.value);
                target = if is_inside { target } else { 0.5 * (a.value + b.value) };
            }
            let longest = LONGEST * next.value.abs().max(FIRST * first.abs()).max(f64::MIN_POSITIVE);
            step = (target - next.value).clamp(-longest, longest);
            if step == 0.0 || !step.is_finite() || next.value.abs() > FARTHEST * first.abs().max(f64::MIN_POSITIVE) {
                break;
            }
            last = next;
        }
        if interrupted() {
            return Err(Error::run("interrupted before the condition was met"));
        }
        Err(Error::run(format!(
            "no value of `{name}` was found with {}. Nearest is {name} = {}, where it is {}",
            condition.text,
            number(nearest.value),
            number(nearest.gap[0] + condition.target)
        ))
        .help(format!("`--vary {name}=FROM:TO` shows it over a range of `{name}`")))
    }

    /// The value in words.
    pub(super) fn text(&self) -> String {
        format!("{} = {}, for {}", self.parameter, with_error(self.value, self.error), self.condition)
    }
}

/// A value of the parameter, and the motion there.
#[derive(Clone)]
struct At {
    value: f64,
    /// The difference from the condition, and its error.
    gap: [f64; 2],
    start: Start,
}

impl At {
    fn is_met(&self) -> bool {
        self.gap[0].abs() <= self.gap[1]
    }

    /// Whether the condition is met between two values.
    fn is_across(&self, other: &Self) -> bool {
        self.gap[0] * other.gap[0] <= 0.0
    }

    /// Compares distances from the condition.
    fn compare(&self, other: &Self) -> Ordering {
        self.gap[0].abs().total_cmp(&other.gap[0].abs())
    }
}

/// The search for motions at values of a parameter.
struct Search<'s> {
    rates: Rates,
    /// Whether the period is that of the loads at each value.
    has_own_period: bool,
    request: &'s SteadyRequest<'s>,
    name: &'s str,
    motions: u32,
}

impl<'s> Search<'s> {
    fn new(setup: &Setup, request: &'s SteadyRequest, name: &'s str, first: f64) -> Self {
        let rates = Rates::new(setup);
        let has_own_period = rates.is_own(request.period, name, first);
        Self { rates, has_own_period, request, name, motions: 0 }
    }

    /// The motion a step further, or half a step where there is none, and so on; `None` if there is none at all.
    fn next(
        &mut self,
        setup: &mut Setup,
        last: &At,
        step: f64,
        gap_of: &dyn Fn(&Columns) -> Option<[f64; 2]>,
    ) -> Option<At> {
        let mut step = step;
        for _ in 0..MOST_HALVINGS {
            let value = last.value + step;
            let found = self.motion(setup, value, Some(&last.start)).ok();
            let gap = found.as_ref().and_then(|(_, columns)| gap_of(columns));
            if let Some(((motion, _), gap)) = found.zip(gap) {
                return Some(At { value, gap, start: motion.start });
            }
            if interrupted() {
                return None;
            }
            step *= 0.5;
        }
        None
    }

    /// The motion at a value of the parameter, near that of a start.
    fn motion(
        &mut self,
        setup: &mut Setup,
        value: f64,
        near: Option<&Start>,
    ) -> Result<(SteadyMotion, Columns), Error> {
        self.motions += 1;
        setup.set_parameter(self.name, value);
        let mut request = self.request.clone();
        if let Some(near) = near {
            (request.start, request.settle) = (Some(near.clone()), 0);
        }
        if self.has_own_period {
            request.period = self.rates.period(self.name, value);
        }
        let found = steady_motion(&*setup.mechanism(), setup.model.tape(), &request);
        let found = found.map_err(|reason| failure::error(setup, request.cycles, reason))?;
        let columns = record_period(setup, &found, request.phase, &mut Recording::new(setup.description))?;
        Ok((found, columns))
    }
}
