//! The results of inverse dynamics as text, table, summary and figure.

use qrm_sim::analysis::{PrescribedState, Statistics};
use qrm_sim::columns::columns;
use qrm_view::figure::{Abscissa, Curve, Extremes, Figure, Panel, Scale};
use serde::Serialize;

use super::actuators::Actuators;
use crate::error::Error;
use crate::format::with_error;
use crate::output::{Named, csv};
use crate::setup::Setup;

/// The forces and torques of a motion, row by row, and their statistics.
#[derive(Serialize)]
pub(super) struct Report<'r> {
    scene: &'static str,
    end_time: f64,
    rows: usize,
    results: Named<Entry>,
    #[serde(skip)]
    setup: &'r Setup,
    #[serde(skip)]
    states: &'r [PrescribedState],
    /// A column for each force or torque, and the power.
    #[serde(skip)]
    columns: Vec<Vec<f64>>,
}

/// A force, torque or power over the motion; extremes have their times.
#[derive(Serialize)]
struct Entry {
    unit: &'static str,
    minimum: [f64; 2],
    maximum: [f64; 2],
    /// The error of both extremes.
    extreme_error: f64,
    mean: f64,
    mean_error: f64,
    root_mean_square: f64,
}

impl<'r> Report<'r> {
    pub(super) fn new(
        setup: &'r Setup,
        actuators: &Actuators,
        states: &'r [PrescribedState],
        statistics: Vec<Statistics>,
    ) -> Self {
        let forces: Vec<Vec<f64>> = states.iter().map(|state| actuators.forces(state)).collect();
        let mut columns: Vec<Vec<f64>> =
            (0..actuators.all.len()).map(|place| forces.iter().map(|row| row[place]).collect()).collect();
        let mechanism = setup.mechanism();
        columns.push(states.iter().map(|state| actuators.power(&*mechanism, state)).collect());
        let names = actuators.all.iter().map(|own| (own.name.clone(), own.unit));
        let taken = |name: &str| setup.description.outputs.iter().any(|output| output.name == name);
        // Outputs of the scene keep their names.
        let free = |mut name: String| {
            while taken(&name) {
                name.push('_');
            }
            name
        };
        let names = names.chain([("power".to_owned(), "W")]).map(|(name, unit)| (free(name), unit));
        let results = names.zip(statistics).map(|((name, unit), own)| (name, Entry::new(unit, &own)));
        Self {
            scene: setup.description.name,
            end_time: states.last().map_or(0.0, |state| state.t),
            rows: states.len(),
            results: Named(results.collect()),
            setup,
            states,
            columns,
        }
    }

    /// The results as text with this title.
    pub(super) fn text(&self, title: &str) -> String {
        let row = |(name, own): &(String, Entry)| {
            let [low, high] = [own.minimum, own.maximum].map(|[value, _]| with_error(value, own.extreme_error));
            let [mean, rms] = [own.mean, own.root_mean_square].map(|value| with_error(value, own.mean_error));
            ([name.clone(), low, high, mean, rms], [own.minimum[1], own.maximum[1]], own.unit)
        };
        let rows: Vec<_> = self.results.0.iter().map(row).collect();
        let longest = |i: usize| rows.iter().map(|(texts, ..)| texts[i].len()).max().unwrap_or(0);
        let [first, low, high, mean, rms] = [0, 1, 2, 3, 4].map(|i| longest(i).max(if i == 0 { 10 } else { 18 }) + 2);
        let head = ["", "minimum", "at t", "maximum", "at t", "mean", "rms"];
        let line = |texts: [&str; 7]| {
            let [name, minimum, from, maximum, to, average, root] = texts;
            format!("  {name:first$}{minimum:>low$}{from:>12}{maximum:>high$}{to:>12}{average:>mean$}{root:>rms$}")
        };
        let mut text = format!("{title}\n\n{}\n", line(head));
        for ([name, low, high, mean, rms], times, unit) in &rows {
            let [at_low, at_high] = times.map(|t| format!("{t:.6}"));
            text += &format!("{}  {unit}\n", line([name, low, &at_low, high, &at_high, mean, rms]));
        }
        text
    }

    /// The rows as a table.
    pub(super) fn csv(&self) -> Result<Vec<u8>, Error> {
        let columns = columns(self.setup.description).into_iter().filter(|column| !column.kind.is_check());
        let header = columns.map(|column| column.name).chain(self.results.0.iter().map(|(name, _)| name.clone()));
        let row = |(place, state): (usize, &PrescribedState)| {
            let motion = (0..state.q.len()).flat_map(|i| [state.q[i], state.qd[i], state.qdd[i]]);
            let results = self.columns.iter().map(|column| column[place]);
            let numbers = [state.t].into_iter().chain(motion).chain(state.multipliers.iter().copied());
            let numbers = numbers.chain(state.outputs.iter().copied()).chain(results);
            numbers.map(|number| format!("{number:?}")).collect::<Vec<_>>()
        };
        csv(header, self.states.iter().enumerate().map(row))
    }

    /// Forces and torques over time, a panel for each, and the power.
    pub(super) fn figure(&self) -> Figure {
        let panel = |((name, own), values): (&(String, Entry), &Vec<f64>)| {
            let points = self.states.iter().zip(values).map(|(state, value)| (state.t, *value)).collect();
            let mark = |[value, t]: [f64; 2]| (t, value);
            let extremes = Extremes { minimum: mark(own.minimum), maximum: mark(own.maximum) };
            let curve =
                Curve { name: name.clone(), doc: String::new(), points, extremes: Some(extremes), has_dots: false };
            Panel {
                quantity: name.clone(),
                unit: own.unit.to_owned(),
                scale: Scale::Linear,
                curves: vec![curve],
                floor: None,
            }
        };
        Figure {
            title: format!("{}: forces and torques that its motion takes", self.scene),
            abscissa: Abscissa::time(),
            panels: self.results.0.iter().zip(&self.columns).map(panel).collect(),
        }
    }
}

impl Entry {
    fn new(unit: &'static str, own: &Statistics) -> Self {
        let extreme = |(value, t): (f64, f64)| [value, t];
        Self {
            unit,
            minimum: extreme(own.minimum),
            maximum: extreme(own.maximum),
            extreme_error: own.extreme_error,
            mean: own.mean,
            mean_error: own.mean_error,
            root_mean_square: own.root_mean_square,
        }
    }
}
