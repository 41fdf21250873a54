//! A tape for evaluators: each function has its own operations, in an order that runs fast.

use std::vec::Vec;

use super::places::Places;
use super::{NamedTape, place};
use crate::tape::{Tape, TapeFunction, TapeKernel};

/// The parts of `dynamics` in their order.
const DYNAMICS: [&str; 4] = ["mass_matrix", "generalized_forces", "constraint_jacobian", "constraint_bias"];
/// The parts of `loop_constraints` in their order.
const LOOP_CONSTRAINTS: [&str; 3] = ["residuals", "constraint_jacobian", "constraint_rate"];
/// The parts of `linearization` in their order.
const LINEARIZATION: [&str; 6] =
    ["stiffness", "damping", "constraint_stiffness", "constraint_damping", "forcing", "constraint_forcing"];

impl NamedTape {
    /// Converts the tape into one for evaluators.
    pub fn placed(&self) -> Tape {
        let results = |name: &str| self.function(name).map(|own| own.results().collect()).unwrap_or_default();
        let optional = |name: &str| self.function(name).map(|own| own.results().collect());
        let parts = |name: &str, parts: &[&str]| -> Vec<u32> {
            let function = self.function(name).into_iter();
            let parts = function.flat_map(|own| parts.iter().filter_map(|part| own.part(part)));
            parts.flat_map(|part| part.values.values()).copied().collect()
        };
        let momenta: Option<Vec<u32>> = optional("momenta");
        let dynamics = match momenta {
            Some(_) => results("generalized_forces"),
            None => parts("dynamics", &DYNAMICS),
        };
        let loop_constraints = parts("loop_constraints", &LOOP_CONSTRAINTS);
        let [mass_matrix, energy, power]: [Vec<u32>; 3] = ["mass_matrix", "energy", "power"].map(results);
        let [outputs, start, schedule]: [Vec<u32>; 3] = ["outputs", "start", "schedule"].map(results);
        let linearization = self.function("linearization").map(|_| parts("linearization", &LINEARIZATION));
        let event: Option<Vec<u32>> = optional("event");
        let [switching_functions, tanh_arguments]: [Vec<u32>; 2] =
            ["switching_functions", "tanh_arguments"].map(results);
        let fields: Vec<u32> = results("position");
        let of_position = ["growth_factor", "residuals"].map(results).concat();
        let [velocity_residual, correction, outputs_at]: [Vec<u32>; 3] =
            ["velocity_residual", "correction", "outputs_at"].map(results);
        let mut accelerations: Vec<u32> = results("accelerations");
        let multipliers = accelerations.split_off(self.coordinates.min(accelerations.len()));

        let mut places = Places::new(self);
        let from_state = [&dynamics, &loop_constraints, &mass_matrix, &energy, &power, &outputs, &start, &schedule];
        let from_kernel =
            [&fields, &of_position, &velocity_residual, &correction, &accelerations, &multipliers, &outputs_at];
        let all = from_state
            .into_iter()
            .chain(from_kernel)
            .chain(&momenta)
            .chain(&linearization)
            .chain(&event)
            .chain([&switching_functions, &tanh_arguments]);
        let constants = places.constants(all.flatten().copied());
        let mut kernel = places.clone();
        let linear_in_time = self.function("switching_functions").and_then(|own| own.part("linear_in_time"));
        let function = |roots: &Vec<u32>| -> TapeFunction { places.function(roots) };
        Tape {
            coordinates: place(self.coordinates),
            constraints: place(self.constraints),
            is_driven: self.is_driven,
            parameters: places.parameters(&results("parameters")),
            constants: constants.into(),
            dynamics: function(&dynamics),
            loop_constraints: function(&loop_constraints),
            mass_matrix: function(&mass_matrix),
            momenta: momenta.as_ref().map(function),
            energy: function(&energy),
            power: function(&power),
            outputs: function(&outputs),
            linearization: linearization.as_ref().map(function),
            event: event.as_ref().map(function),
            switching_functions: function(&switching_functions),
            linear_in_time: linear_in_time.map_or(0, |part| place(part.values.values().len())),
            tanh_arguments: function(&tanh_arguments),
            start: function(&start),
            given: self.given.clone().into(),
            schedule: function(&schedule),
            kernel: TapeKernel {
                operations: self.solution.sum(),
                has_angle: self.has_angle.clone().into(),
                position: kernel.first_part(&fields, &of_position),
                velocity_residual: kernel.part(&velocity_residual),
                correction: kernel.part(&correction),
                accelerations: kernel.clone().function(&accelerations),
                multipliers: kernel.part_after(&accelerations, &multipliers),
                outputs: kernel.part(&outputs_at),
            },
        }
    }
}
