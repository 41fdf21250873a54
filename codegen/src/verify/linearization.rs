//! The generated derivatives of the equations of motion against differences of the equations themselves, which are
//! verified by automatic differentiation.

use super::Generated;
use super::expected::Sample;
use crate::term::Equations;
use qrm_scene::scene::Scene;

/// Largest difference relative to the largest number of a matrix.
const TOLERANCE: f64 = 1e-6;
/// Where differences with two steps differ by more than this part of it, they say nothing.
const CONDITION: f64 = 0.1;

/// Compares all parts at a state.
pub(super) fn agrees(scene: &Scene, equations: &Equations, module: &Generated, sample: &Sample) -> Result<(), String> {
    if equations.linearization.is_none() {
        return Ok(());
    }
    let model = module.model(scene, &sample.parameters)?;
    let n = sample.q.len();
    let m = scene.constraints.len();
    let matrix = |of: Of, by: By, h: f64| -> Option<Vec<f64>> {
        let count = if by == By::Time { 1 } else { n };
        let columns: Option<Vec<Vec<f64>>> =
            (0..count).map(|j| difference(scene, equations, sample, (of, by), j, h)).collect();
        let columns = columns?;
        let rows = if of == Of::Forces { n } else { m };
        // What changes by itself stands on the other side.
        let sign = if by == By::Time { -1.0 } else { 1.0 };
        Some((0..rows).flat_map(|i| columns.iter().map(move |column| sign * column[i])).collect())
    };
    let parts = [
        ("stiffness", Of::Forces, By::Coordinates),
        ("damping", Of::Forces, By::Rates),
        ("constraint_stiffness", Of::Loops, By::Coordinates),
        ("constraint_damping", Of::Loops, By::Rates),
        ("forcing", Of::Forces, By::Time),
        ("constraint_forcing", Of::Loops, By::Time),
    ];
    for (name, of, by) in parts {
        let (Some(coarse), Some(fine)) = (matrix(of, by, 2e-3), matrix(of, by, 1e-3)) else { continue };
        let got =
            module.call(&format!("linearization.{name}"), &sample.arguments(scene, "linearization", model.clone()))?;
        let largest = fine.iter().fold(1.0, |most: f64, number| most.max(number.abs()));
        let known = |i: usize| (coarse[i] - fine[i]).abs() <= CONDITION * TOLERANCE * largest;
        let allowed = |i: usize| if known(i) { TOLERANCE * largest } else { f64::INFINITY };
        super::compare(name, &got, &fine, allowed)
            .map_err(|(_, what)| format!("generated `linearization` is wrong: {what}"))?;
    }
    Ok(())
}

/// Which equations are differentiated.
#[derive(Clone, Copy, PartialEq)]
enum Of {
    /// `Mbar qdd + C_q' lambda - fbar`
    Forces,
    /// `C_q qdd + bias`
    Loops,
}

/// By what.
#[derive(Clone, Copy, PartialEq)]
enum By {
    Coordinates,
    Rates,
    Time,
}

/// The derivative by time, or by one coordinate or rate, from central differences of fourth order.
fn difference(
    scene: &Scene,
    equations: &Equations,
    sample: &Sample,
    (of, by_what): (Of, By),
    j: usize,
    h: f64,
) -> Option<Vec<f64>> {
    let at = |by: f64| {
        let mut moved = sample.clone();
        match by_what {
            By::Coordinates => moved.q[j] += by * h,
            By::Rates => moved.qd[j] += by * h,
            By::Time => moved.t += by * h,
        }
        residual(scene, equations, &moved, of)
    };
    let [a, b, c, d] = [at(-2.0)?, at(-1.0)?, at(1.0)?, at(2.0)?];
    Some((0..a.len()).map(|i| (a[i] - 8.0 * b[i] + 8.0 * c[i] - d[i]) / (12.0 * h)).collect())
}

fn residual(scene: &Scene, equations: &Equations, sample: &Sample, of: Of) -> Option<Vec<f64>> {
    let expected = sample.expected(scene, equations)?;
    let known = |name: &str| expected.iter().find(|(n, _)| *n == name).map_or(&[][..], |(_, numbers)| numbers);
    let jacobian = known("dynamics.constraint_jacobian");
    let (n, m) = (sample.q.len(), scene.constraints.len());
    let (qdd, multipliers) = (&sample.qdd, &sample.multipliers);
    let dot = |row: &[f64]| row.iter().zip(qdd).map(|(entry, a)| entry * a).sum::<f64>();
    Some(match of {
        Of::Forces => {
            let (mass, forces) = (known("mass_matrix"), known("generalized_forces"));
            let pull = |i: usize| (0..m).map(|k| jacobian[k * n + i] * multipliers[k]).sum::<f64>();
            (0..n).map(|i| dot(&mass[i * n..(i + 1) * n]) + pull(i) - forces[i]).collect()
        }
        Of::Loops => {
            let bias = known("dynamics.constraint_bias");
            (0..m).map(|k| dot(&jacobian[k * n..(k + 1) * n]) + bias[k]).collect()
        }
    })
}
