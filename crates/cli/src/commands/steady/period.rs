//! The period of the loads and drives of a scene.

use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::sync::Arc;

use qrm_core::{Description, Model};
use qrm_scene::evaluate::parameter_values;
use qrm_scene::scene::Scene;
use qrm_scene::time_scales::{depends_on_time, turning_rates};
use qrm_sim::solve::LoopConstraints;

use crate::error::Error;
use crate::format::number;
use crate::setup::Setup;

/// The most turns of the slowest load in a common period.
const MOST_TURNS: u32 = 64;
/// The largest difference from whole turns in a common period, in turns.
const WHOLE: f64 = 1e-9;
/// Times at which the rate of a drive is compared with that at the start, in s.
const TIMES: [f64; 3] = [0.0, 0.377_964_473, 1.618_033_989];

/// The period that a motion must have: the given one, or that of all loads and drives. `None` where nothing depends on
/// time.
///
/// # Errors
/// A period is given and nothing depends on time, or none is given and the formulae tell none.
pub(super) fn period(setup: &Setup, given: Option<f64>) -> Result<Option<f64>, Error> {
    let name = setup.description.name;
    if !depends_on_time(&setup.scene) {
        return match given {
            None => Ok(None),
            Some(_) => Err(Error::usage(format!(
                "`--period`: no load or drive of scene `{name}` depends on time, so that its motion has a period of its \
                 own"
            ))
            .help("leave it out; `--phase` and `--cycles` say what is a period")),
        };
    }
    if given.is_some() {
        return Ok(given);
    }
    let rates = Rates::new(setup).at(None);
    if rates.is_empty() {
        return Err(Error::usage(format!("the formulae of scene `{name}` depend on time, and tell no period"))
            .help("give it: `--period SECONDS`"));
    }
    common_period(&rates).map(Some).ok_or_else(|| {
        let rates: Vec<String> = rates.iter().map(|rate| number(*rate)).collect();
        Error::usage(format!(
            "loads and drives turn at {} rad/s, which have no common period of up to {MOST_TURNS} turns of the slowest",
            rates.join(", ")
        ))
        .help("give it: `--period SECONDS`")
    })
}

/// The shortest time in which each of some rates makes whole turns, the slowest first.
fn common_period(rates: &[f64]) -> Option<f64> {
    let slowest = *rates.first()?;
    let periods = (1..=MOST_TURNS).map(|turns| f64::from(turns) * TAU / slowest);
    periods.into_iter().find(|period| {
        rates.iter().all(|rate| {
            let turns = rate * period / TAU;
            (turns - turns.round()).abs() <= WHOLE * turns
        })
    })
}

/// The rates at which loads and drives turn, at values of a parameter.
pub(super) struct Rates {
    model: &'static Model,
    description: &'static Description,
    scene: Arc<Scene>,
    set: BTreeMap<String, f64>,
    /// The position at the start, where the rates of drives are taken; `None` where it cannot be assembled.
    q: Option<Vec<f64>>,
}

impl Rates {
    pub(super) fn new(setup: &Setup) -> Self {
        let q = setup.first_state().ok().map(|[q, _]| q);
        let Setup { model, description, scene, set, .. } = setup;
        Self { model, description, scene: scene.clone(), set: set.clone(), q }
    }

    /// The common period at a value of a parameter; `None` if there is none.
    pub(super) fn period(&self, name: &str, value: f64) -> Option<f64> {
        common_period(&self.at(Some((name, value))))
    }

    /// Whether a period is that of the loads at a value of a parameter, and so depends on it.
    pub(super) fn is_own(&self, period: Option<f64>, name: &str, value: f64) -> bool {
        period.is_some() && self.period(name, value) == period
    }

    /// The rates, the slowest first.
    fn at(&self, varied: Option<(&str, f64)>) -> Vec<f64> {
        let replace = |name: &str| match varied {
            Some((other, value)) if other == name => Some(value),
            _ => self.set.get(name).copied(),
        };
        let mut rates = turning_rates(&self.scene, &parameter_values(&self.scene, replace));
        rates.extend(self.drive_rates(&replace));
        rates.retain(|rate| *rate > 0.0);
        rates.sort_by(f64::total_cmp);
        rates.dedup();
        rates
    }

    /// The rates of the angles that drives turn evenly.
    fn drive_rates(&self, replace: &dyn Fn(&str) -> Option<f64>) -> Vec<f64> {
        let Some(q) = &self.q else { return Vec::new() };
        let mechanism = self.model.mechanism(replace);
        let at = TIMES.map(|t| LoopConstraints::at(&*mechanism, t, q));
        let rate = |drive: usize| {
            let rates = at.each_ref().map(|constraints| constraints.constraint_rate[drive]);
            let is_even = rates.iter().all(|rate| (rate - rates[0]).abs() <= WHOLE * rates[0].abs());
            let unit = self.description.constraints[drive].unit;
            (is_even && unit == "rad").then_some(rates[0].abs())
        };
        self.scene.drives().into_iter().filter_map(rate).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_common_period_has_whole_turns() {
        let close = |found: Option<f64>, expected: f64| found.is_some_and(|found| (found - expected).abs() < 1e-12);
        assert!(close(common_period(&[TAU]), 1.0) && close(common_period(&[TAU, 2.0 * TAU]), 1.0));
        assert!(close(common_period(&[2.0 * TAU, 3.0 * TAU]), 1.0));
        assert_eq!(common_period(&[1.0, 2.0_f64.sqrt()]), None);
    }
}
