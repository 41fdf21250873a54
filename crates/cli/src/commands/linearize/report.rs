//! A linear model in words and numbers.

use qrm_scene::time_scales::depends_on_time;
use qrm_sim::analysis::{Equilibrium, EquilibriumStability, LinearModel, LinearOutput, Modes};
use serde::Serialize;

use super::super::modes::report::stability_name;
use super::response::FrequencyResponse;
use crate::format::{counted, heading, quantity, with_error};
use crate::output::{Named, written};
use crate::setup::Setup;

/// A linear model, in the order of `linear.json`.
#[derive(Serialize)]
pub(super) struct LinearReport {
    #[serde(skip)]
    heading: String,
    pub(super) scene: &'static str,
    equilibrium: Named<f64>,
    equilibrium_errors: Named<f64>,
    stability: &'static str,
    /// States, inputs and outputs are deviations from the values given here.
    pub(super) states: Vec<Quantity>,
    pub(super) inputs: Vec<Quantity>,
    pub(super) outputs: Vec<Quantity>,
    #[serde(rename = "A")]
    pub(super) a: Vec<Vec<f64>>,
    #[serde(rename = "B")]
    pub(super) b: Vec<Vec<f64>>,
    #[serde(rename = "C")]
    pub(super) c: Vec<Vec<f64>>,
    #[serde(rename = "D")]
    pub(super) d: Vec<Vec<f64>>,
    errors: Named<Vec<Vec<f64>>>,
    notes: Vec<&'static str>,
    #[serde(skip)]
    coordinate_units: Vec<&'static str>,
}

/// A state, an input or an output.
#[derive(Serialize)]
pub(super) struct Quantity {
    pub(super) name: String,
    pub(super) unit: String,
    pub(super) value: f64,
}

/// The most states of a model whose matrices are printed.
const PRINTED: usize = 6;

impl LinearReport {
    pub(super) fn new(
        setup: &Setup,
        (at, modes): (&Equilibrium, &Modes),
        model: &LinearModel,
        (inputs, outputs): (&[usize], &[LinearOutput]),
    ) -> Self {
        let description = setup.description;
        let coordinates = description.coordinates;
        let values = setup.mechanism().parameters().to_vec();
        let named = |values: &[f64]| {
            Named(coordinates.iter().zip(values).map(|(own, value)| (own.name.to_owned(), *value + 0.0)).collect())
        };
        let per_time = |i: usize, dots: usize| Quantity {
            name: format!("{}{}", coordinates[i].name, ["", "_dot", "_ddot"][dots]),
            unit: format!("{}{}", coordinates[i].unit, ["", "/s", "/s^2"][dots]),
            value: if dots == 0 { at.q[i] } else { 0.0 },
        };
        let states = [0, 1].into_iter().flat_map(|dots| model.independent.iter().map(move |&i| (i, dots)));
        let output = |(output, value): (&LinearOutput, &f64)| match *output {
            LinearOutput::Coordinate(i) => per_time(i, 0),
            LinearOutput::Rate(i) => per_time(i, 1),
            LinearOutput::Acceleration(i) => per_time(i, 2),
            LinearOutput::Output(i) => {
                let own = &description.outputs[i];
                Quantity { name: own.name.to_owned(), unit: own.unit.to_owned(), value: *value }
            }
        };
        let input = |&i: &usize| {
            let own = &description.parameters[i];
            Quantity { name: own.name.to_owned(), unit: own.unit.to_owned(), value: values[i] }
        };
        let mut notes = Vec::new();
        if depends_on_time(&setup.scene) {
            notes.push("loads that depend on time are those at t = 0");
        }
        if modes.stability == EquilibriumStability::Unstable {
            notes.push(
                "the equilibrium is unstable: the response is that of the equations, and no motion settles to it",
            );
        }
        let [a, b, c, d] = model.matrices.clone();
        let errors = ["A", "B", "C", "D"].map(str::to_owned).into_iter().zip(model.errors.clone());
        Self {
            heading: heading(description),
            scene: description.name,
            equilibrium: named(&at.q),
            equilibrium_errors: named(&modes.q_errors),
            stability: stability_name(modes.stability),
            states: states.map(|(i, dots)| per_time(i, dots)).collect(),
            inputs: inputs.iter().map(input).collect(),
            outputs: outputs.iter().zip(&model.values).map(output).collect(),
            a,
            b,
            c,
            d,
            errors: Named(errors.collect()),
            notes,
            coordinate_units: coordinates.iter().map(|coordinate| coordinate.unit).collect(),
        }
    }

    /// The text that the command prints.
    pub(super) fn text(&self, response: &FrequencyResponse, files: &[String]) -> String {
        let mut text = format!("{}\n\n", self.heading);
        let mut line = |topic: &str, line: &str| text += &format!("  {topic:11} {line}\n");
        let coordinates = self.equilibrium.0.iter().zip(&self.coordinate_units);
        let place: Vec<String> =
            coordinates.map(|((name, value), unit)| format!("{name} = {}", quantity(*value, unit))).collect();
        line("equilibrium", &place.join(", "));
        line("stability", &self.stability.replace('_', " "));
        let list = |all: &[Quantity]| {
            let text = |own: &Quantity| format!("{} {}", own.name, own.unit).trim_end().to_owned();
            all.iter().map(text).collect::<Vec<_>>().join(", ")
        };
        line("states", &list(&self.states));
        line("inputs", &list(&self.inputs));
        line("outputs", &list(&self.outputs));
        if self.states.len() <= PRINTED {
            let matrices = [&self.a, &self.b, &self.c, &self.d];
            for (matrix, (name, errors)) in matrices.into_iter().zip(&self.errors.0) {
                text.push('\n');
                for (place, (row, errors)) in matrix.iter().zip(errors).enumerate() {
                    let entries: Vec<String> =
                        row.iter().zip(errors).map(|(value, error)| format!("{:>24}", entry(*value, *error))).collect();
                    let name = if place == 0 { name } else { "" };
                    text += &format!("  {name:2}{}\n", entries.join(""));
                }
            }
        }
        text += &response.text(self);
        for note in &self.notes {
            text += &format!("\nnote: {note}\n");
        }
        format!(
            "{text}\n{}",
            written(files).replacen(
                "frequency_response.csv",
                &format!("frequency_response.csv ({})", counted(response.len() as u64, "row")),
                1
            )
        )
    }
}

/// An entry of a matrix: whole numbers are exact.
fn entry(value: f64, error: f64) -> String {
    if error == 0.0 && value.fract() == 0.0 { format!("{value}") } else { with_error(value, error) }
}
