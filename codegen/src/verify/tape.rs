//! Compares evaluators bitwise with the tape from which they were made: both perform the same operations.

use qrm_core::named_tape::Argument;
use qrm_core::{NamedTape, Tape, TapeEvaluator, TapeFunction};
use qrm_scene::evaluate::parameter_values;
use qrm_scene::scene::Scene;

use super::evaluation::Evaluation;
use super::sample::Sample;

/// The rounding errors of products of the mass matrix, relative to the size of their terms.
const ROUNDING: f64 = 1e-9;

/// Compares every function at a state.
pub(super) fn agrees(scene: &Scene, tape: &NamedTape, placed: &Tape, sample: &Sample) -> Result<(), String> {
    let kept = scene.parameters.iter().zip(&sample.parameters).filter(|(p, _)| !p.left_out);
    let kept: Vec<f64> = kept.map(|(_, value)| *value).collect();
    let mut evaluator = TapeEvaluator::<Vec<f64>>::with_parameters(placed, &kept);
    let evaluation: Evaluation<f64> = sample.evaluation(scene, tape, &[]);
    let expected = |function: &str, parts: &[&str]| -> Vec<f64> {
        match parts {
            [] => evaluation.results(function),
            parts => parts.iter().flat_map(|part| evaluation.results(&format!("{function}.{part}"))).collect(),
        }
    };
    let Sample { t, q, qd, qdd, multipliers, .. } = sample;
    let room = |function: &TapeFunction| vec![0.0; function.results.len()];

    let mut results = vec![0.0; placed.dynamics_length()];
    evaluator.dynamics(*t, q, qd, &mut results);
    let n = q.len();
    let mut momenta = vec![0.0; n];
    if evaluator.momenta(q, qd, &mut momenta) {
        same("momenta", &momenta, &expected("momenta", &[]))?;
        same("dynamics", &results[n * n..], &expected("generalized_forces", &[]))?;
        for (i, row) in results[..n * n].chunks_exact(n).enumerate() {
            let terms: Vec<f64> = row.iter().zip(qd).map(|(entry, v)| entry * v).collect();
            let size: f64 = terms.iter().map(|term| term.abs()).sum();
            let difference = (terms.iter().sum::<f64>() - momenta[i]).abs();
            // Written so that a difference that is not a number counts.
            if !(difference <= ROUNDING * size) && momenta[i].is_finite() {
                return Err(format!("generated `momenta` are wrong: row {i} differs from `Mbar qd` by {difference:e}"));
            }
        }
    } else {
        let parts = ["mass_matrix", "generalized_forces", "constraint_jacobian", "constraint_bias"];
        same("dynamics", &results, &expected("dynamics", &parts))?;
        let mut results = room(&placed.mass_matrix);
        evaluator.mass_matrix(q, &mut results);
        same("mass_matrix", &results, &expected("mass_matrix", &[]))?;
    }

    let mut results = room(&placed.loop_constraints);
    evaluator.loop_constraints(*t, q, &mut results);
    let parts = ["residuals", "constraint_jacobian", "constraint_rate"];
    same("loop_constraints", &results, &expected("loop_constraints", &parts))?;

    same("energy", &evaluator.energy(q, qd), &expected("energy", &[]))?;
    same("power", &[evaluator.power(*t, q, qd, qdd, multipliers)], &expected("power", &[]))?;

    let mut results = room(&placed.outputs);
    evaluator.outputs(*t, q, qd, qdd, multipliers, &mut results);
    same("outputs", &results, &expected("outputs", &[]))?;

    if let Some(linearization) = &placed.linearization {
        let mut results = room(linearization);
        evaluator.linearization(*t, q, qd, qdd, multipliers, &mut results);
        let loads = ["stiffness", "damping", "constraint_stiffness", "constraint_damping"];
        let parts = [&loads[..], &["forcing", "constraint_forcing"]].concat();
        same("linearization", &results, &expected("linearization", &parts))?;
    }
    if let Some(event) = evaluator.event(*t, q, qd, qdd, multipliers) {
        same("event", &[event], &expected("event", &[]))?;
    }
    Ok(())
}

/// Compares parameters, start and schedule for the scene's own values.
pub(super) fn agrees_at_start(scene: &Scene, tape: &NamedTape, placed: &Tape) -> Result<(), String> {
    let mut evaluator = TapeEvaluator::new(placed);
    same("parameters", evaluator.parameters(), &Evaluation::parameters(tape, |_| None))?;
    let values = scene.parameters.iter().zip(parameter_values::<f64>(scene, |_| None));
    let kept: Vec<f64> = values.filter(|(p, _)| !p.left_out).map(|(_, value)| value).collect();
    let evaluation = Evaluation::new(tape, &kept, &[(Argument::Time, &[0.0])]);
    let n = scene.coordinates.len();
    let (mut q, mut qd) = (vec![0.0; n], vec![0.0; n]);
    evaluator.start(&mut q, &mut qd);
    same("start", &q, &evaluation.results("start.q"))?;
    same("start", &qd, &evaluation.results("start.qd"))?;
    let schedule = evaluator.schedule();
    same("schedule", &[schedule.step, schedule.end_time], &evaluation.results("schedule"))
}

/// Compares numbers that are computed by the same operations.
fn same(what: &str, got: &[f64], expected: &[f64]) -> Result<(), String> {
    let is_same = |(a, b): (&f64, &f64)| a == b || a.is_nan() && b.is_nan();
    if got.len() == expected.len() && got.iter().zip(expected).all(is_same) {
        return Ok(());
    }
    Err(format!("generated tape of `{what}` is wrong: {got:?} instead of {expected:?}"))
}
