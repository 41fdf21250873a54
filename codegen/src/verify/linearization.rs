//! The generated derivatives of the equations of motion against differences of the equations themselves, which are
//! verified by automatic differentiation.

use super::Generated;
use super::equations::Residual;
use super::sample::Sample;
use crate::term::Equations;
use qrm_scene::scene::Scene;

/// Largest difference relative to the largest number of a matrix.
const TOLERANCE: f64 = 1e-6;
/// The step of the finer differences.
const STEP: f64 = 1e-3;
/// Where differences with two steps differ by more than this part of it, they say nothing.
const CONDITION: f64 = 0.1;

/// Compares all parts at a state.
pub(super) fn agrees(scene: &Scene, equations: &Equations, module: &Generated, sample: &Sample) -> Result<(), String> {
    if equations.linearization.is_none() {
        return Ok(());
    }
    let model = module.model(scene, &sample.parameters)?;
    let parts = [
        (By::Coordinates, ["stiffness", "constraint_stiffness"]),
        (By::Rates, ["damping", "constraint_damping"]),
        (By::Time, ["forcing", "constraint_forcing"]),
    ];
    let sides: [fn(&Residual) -> &Vec<f64>; 2] = [|residual| &residual.forces, |residual| &residual.constraints];
    for (by, names) in parts {
        let count = if by == By::Time { 1 } else { sample.q.len() };
        let columns = (0..count).map(|j| column(scene, equations, sample, by, j));
        let Some(columns) = columns.collect::<Option<Vec<[Residual; 2]>>>() else { continue };
        for (name, part) in names.into_iter().zip(sides) {
            let [coarse, fine] = [0, 1].map(|step| {
                let rows = columns.first().map_or(0, |column| part(&column[step]).len());
                let row = |i: usize| columns.iter().map(move |column| part(&column[step])[i]);
                (0..rows).flat_map(row).collect::<Vec<f64>>()
            });
            let arguments = sample.arguments(scene, "linearization", model.clone());
            let got = module.call(&format!("linearization.{name}"), &arguments)?;
            let largest = fine.iter().fold(1.0, |most: f64, number| most.max(number.abs()));
            let known = |i: usize| (coarse[i] - fine[i]).abs() <= CONDITION * TOLERANCE * largest;
            let allowed = |i: usize| if known(i) { TOLERANCE * largest } else { f64::INFINITY };
            super::compare(name, &got, &fine, allowed)
                .map_err(|(_, what)| format!("generated `linearization` is wrong: {what}"))?;
        }
    }
    Ok(())
}

/// By what the equations are differentiated.
#[derive(Clone, Copy, PartialEq)]
enum By {
    Coordinates,
    Rates,
    Time,
}

/// The derivative by time, or by one coordinate or rate, from central differences of fourth order with the steps
/// `2 STEP` and `STEP`.
fn column(scene: &Scene, equations: &Equations, sample: &Sample, by: By, j: usize) -> Option<[Residual; 2]> {
    let at = |steps: f64| {
        let mut moved = sample.clone();
        match by {
            By::Coordinates => moved.q[j] += steps * STEP,
            By::Rates => moved.qd[j] += steps * STEP,
            By::Time => moved.t += steps * STEP,
        }
        moved.residual(scene, equations)
    };
    // Derivatives by time are on the right-hand side of the linearized equations.
    let sign = if by == By::Time { -1.0 } else { 1.0 };
    let differences = [4.0, 2.0, 1.0].map(|steps| Some((at(steps)?, at(-steps)?)));
    let [Some(widest), Some(wide), Some(narrow)] = differences else { return None };
    let slope = |far: &(Residual, Residual), near: &(Residual, Residual), h: f64| {
        let each = |part: fn(&Residual) -> &Vec<f64>| {
            let difference = |pair: &(Residual, Residual), i: usize| part(&pair.0)[i] - part(&pair.1)[i];
            let count = part(&near.0).len();
            (0..count).map(|i| sign * (8.0 * difference(near, i) - difference(far, i)) / (12.0 * h)).collect()
        };
        Residual { forces: each(|r| &r.forces), constraints: each(|r| &r.constraints) }
    };
    Some([slope(&widest, &wide, 2.0 * STEP), slope(&wide, &narrow, STEP)])
}
