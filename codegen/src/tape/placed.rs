//! A tape for evaluators: each function with the operations that it needs, in an order that is interpreted fast.

use qrm_core::{OwnedKernel, OwnedTape};
use qrm_scene::scene::{Coordinate, Scene, Start};

use super::places::Places;
use super::switching::Switching;
use super::{Tape, place};

/// The parts of `dynamics` in their order.
const DYNAMICS: [&str; 4] = ["mass_matrix", "generalized_forces", "constraint_jacobian", "constraint_bias"];
/// Those of `loop_constraints`.
const LOOP_CONSTRAINTS: [&str; 3] = ["residuals", "constraint_jacobian", "constraint_rate"];
/// Those of `linearization`.
const LINEARIZATION: [&str; 6] =
    ["stiffness", "damping", "constraint_stiffness", "constraint_damping", "forcing", "constraint_forcing"];

/// The tape for evaluators.
pub fn placed(scene: &Scene, tape: &Tape) -> OwnedTape {
    let [_, n, m] = tape.sizes();
    let results = |name: &str| -> Vec<u32> {
        tape.function(name).map(|function| function.results().collect()).unwrap_or_default()
    };
    let parts = |name: &str, parts: &[&str]| -> Vec<u32> {
        let Some(function) = tape.function(name) else { return Vec::new() };
        let parts = parts.iter().filter_map(|part| function.part(part));
        parts.flat_map(|part| part.values.values()).copied().collect()
    };
    let dynamics = parts("dynamics", &DYNAMICS);
    let loop_constraints = parts("loop_constraints", &LOOP_CONSTRAINTS);
    let [mass_matrix, energy, power] = ["mass_matrix", "energy", "power"].map(results);
    let [outputs, start, schedule] = ["outputs", "start", "schedule"].map(results);
    let linearization = scene.run.stiff.then(|| parts("linearization", &LINEARIZATION));
    let event = scene.run.until.as_ref().map(|_| results("event"));
    let is_given = |start: fn(&Coordinate) -> &Start| {
        scene.coordinates.iter().map(move |coordinate| matches!(start(coordinate), Start::Given(_)))
    };
    let given = is_given(|c| &c.position).chain(is_given(|c| &c.rate)).collect();
    let fields = results("position");
    let of_position = [results("growth_factor"), results("residuals")].concat();
    let [velocity_residual, correction, outputs_at] = ["velocity_residual", "correction", "outputs_at"].map(results);
    let mut accelerations = results("accelerations");
    let multipliers = accelerations.split_off(n);

    let mut places = Places::new(tape);
    let Switching { functions: switching_functions, linear_in_time, tanh_arguments } =
        Switching::of(tape, &places, &[&dynamics, &loop_constraints], scene.friction_by_forces().next().is_some());
    let of_state = [&dynamics, &loop_constraints, &mass_matrix, &energy, &power, &outputs, &start, &schedule];
    let of_kernel = [&fields, &of_position, &velocity_residual, &correction, &accelerations, &multipliers, &outputs_at];
    let all = of_state
        .into_iter()
        .chain(of_kernel)
        .chain(&linearization)
        .chain(&event)
        .chain([&switching_functions, &tanh_arguments]);
    let constants = places.constants(all.flatten().copied());
    let mut kernel = places.clone();
    OwnedTape {
        coordinates: place(n),
        constraints: place(m),
        is_driven: scene.is_driven(),
        parameters: places.parameters(&results("parameters")),
        constants,
        dynamics: places.function(&dynamics),
        loop_constraints: places.function(&loop_constraints),
        mass_matrix: places.function(&mass_matrix),
        energy: places.function(&energy),
        power: places.function(&power),
        outputs: places.function(&outputs),
        linearization: linearization.map(|results| places.function(&results)),
        event: event.map(|results| places.function(&results)),
        switching_functions: places.function(&switching_functions),
        linear_in_time,
        tanh_arguments: places.function(&tanh_arguments),
        start: places.function(&start),
        given,
        schedule: places.function(&schedule),
        kernel: OwnedKernel {
            operations: tape.solution.sum(),
            has_angle: tape.has_angle.clone(),
            position: kernel.first_part(&fields, &of_position),
            velocity_residual: kernel.part(&velocity_residual),
            correction: kernel.part(&correction),
            accelerations: kernel.clone().function(&accelerations),
            multipliers: kernel.part_after(&accelerations, &multipliers),
            outputs: kernel.part(&outputs_at),
        },
    }
}
