//! The tape of a module against its printed functions, to the last bit: both do the same operations in the same order.

use qrm_core::{Tape, TapeEvaluator};

use super::sample::Sample;
use crate::interpret::{GeneratedModule, Value};
use qrm_scene::evaluate::parameter_values;
use qrm_scene::scene::Scene;

/// Compares every function at a state.
pub(super) fn agrees(scene: &Scene, module: &GeneratedModule, tape: &Tape, sample: &Sample) -> Result<(), String> {
    let kept = scene.parameters.iter().zip(&sample.parameters).filter(|(p, _)| !p.left_out);
    let kept: Vec<f64> = kept.map(|(_, value)| *value).collect();
    let mut evaluator = TapeEvaluator::<Vec<f64>>::with_parameters(tape, &kept);
    let model = module.model::<f64>(scene, &sample.parameters)?;
    let Sample { t, q, qd, qdd, multipliers, .. } = sample;
    let printed = |function: &str, parts: &[&str]| -> Result<Vec<f64>, String> {
        let value = module.value(function, &sample.arguments(scene, function, model.clone()))?;
        if parts.is_empty() {
            return Ok(value.numbers());
        }
        let parts: Result<Vec<&Value<f64>>, String> = parts.iter().map(|part| value.field(part)).collect();
        Ok(parts?.into_iter().flat_map(Value::numbers).collect())
    };
    let room = |function: &qrm_core::TapeFunction| vec![0.0; function.results.len()];

    let mut results = room(&tape.dynamics);
    evaluator.dynamics(*t, q, qd, &mut results);
    let parts = ["mass_matrix", "generalized_forces", "constraint_jacobian", "constraint_bias"];
    same("dynamics", &results, &printed("dynamics", &parts)?)?;

    let mut results = room(&tape.loop_constraints);
    evaluator.loop_constraints(*t, q, &mut results);
    let parts = ["residuals", "constraint_jacobian", "constraint_rate"];
    same("loop_constraints", &results, &printed("loop_constraints", &parts)?)?;

    let mut results = room(&tape.mass_matrix);
    evaluator.mass_matrix(q, &mut results);
    same("mass_matrix", &results, &printed("mass_matrix", &[])?)?;
    same("energy", &evaluator.energy(q, qd), &printed("energy", &[])?)?;
    same("power", &[evaluator.power(*t, q, qd, qdd, multipliers)], &printed("power", &[])?)?;

    let mut results = room(&tape.outputs);
    evaluator.outputs(*t, q, qd, qdd, multipliers, &mut results);
    same("outputs", &results, &printed("outputs", &[])?)?;

    if let Some(linearization) = &tape.linearization {
        let mut results = room(linearization);
        evaluator.linearization(*t, q, qd, qdd, multipliers, &mut results);
        let loads = ["stiffness", "damping", "constraint_stiffness", "constraint_damping"];
        let parts = [&loads[..], &["forcing", "constraint_forcing"]].concat();
        same("linearization", &results, &printed("linearization", &parts)?)?;
    }
    if let Some(event) = evaluator.event(*t, q, qd) {
        let arguments = [model.clone(), Value::Number(*t), Value::list(q), Value::list(qd)];
        same("event", &[event], &module.method("event", &arguments)?.numbers())?;
    }
    Ok(())
}

/// Compares parameters, start and schedule of the scene itself.
pub(super) fn agrees_at_start(scene: &Scene, module: &GeneratedModule, tape: &Tape) -> Result<(), String> {
    let model = module.model(scene, &parameter_values::<f64>(scene, |_| None))?;
    let mut evaluator = TapeEvaluator::new(tape);
    let set = module.method("with", &[Value::Nothing])?;
    let kept = scene.parameters.iter().filter(|p| !p.left_out);
    let printed: Result<Vec<f64>, String> =
        kept.map(|p| Ok(set.field(&crate::emit::field_name(&p.name))?.numbers()[0])).collect();
    same("parameters", evaluator.parameters(), &printed?)?;

    let n = scene.coordinates.len();
    let start = module.method("start", std::slice::from_ref(&model))?;
    let (mut q, mut qd) = (vec![0.0; n], vec![0.0; n]);
    evaluator.start(&mut q, &mut qd);
    same("start", &q, &start.field("q")?.numbers())?;
    same("start", &qd, &start.field("qd")?.numbers())?;
    let given = |name: &str| start.field(name)?.items();
    let is_given: Vec<Value<f64>> = tape.given.iter().map(|&given| Value::Truth(given)).collect();
    if [given("given")?, given("given_rates")?].concat() != is_given {
        return Err("generated tape of `start` is wrong: other values are given".to_owned());
    }
    let schedule = module.method("schedule", std::slice::from_ref(&model))?;
    let printed = [schedule.field("step")?.numbers()[0], schedule.field("end_time")?.numbers()[0]];
    let evaluated = evaluator.schedule();
    same("schedule", &[evaluated.step, evaluated.end_time], &printed)
}

/// Compares numbers that are computed by the same operations.
fn same(what: &str, got: &[f64], printed: &[f64]) -> Result<(), String> {
    let is_same = |(a, b): (&f64, &f64)| a == b || a.is_nan() && b.is_nan();
    if got.len() == printed.len() && got.iter().zip(printed).all(is_same) {
        return Ok(());
    }
    Err(format!("generated tape of `{what}` is wrong: {got:?} instead of {printed:?}"))
}
