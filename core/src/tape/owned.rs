//! A tape with the lists that it refers to.

use std::vec::Vec;

use super::{Operation, Tape, TapeFunction, TapeKernel};

/// A [`Tape`] with its lists.
#[derive(Clone, Debug, Default, PartialEq)]
#[allow(missing_docs, reason = "the fields are those of a tape")]
pub struct OwnedTape {
    pub coordinates: u32,
    pub constraints: u32,
    pub is_driven: bool,
    pub parameters: OwnedFunction,
    pub constants: Vec<Operation>,
    pub dynamics: OwnedFunction,
    pub loop_constraints: OwnedFunction,
    pub mass_matrix: OwnedFunction,
    pub energy: OwnedFunction,
    pub power: OwnedFunction,
    pub outputs: OwnedFunction,
    pub linearization: Option<OwnedFunction>,
    pub event: Option<OwnedFunction>,
    pub switching_functions: OwnedFunction,
    pub linear_in_time: u32,
    pub tanh_arguments: OwnedFunction,
    pub start: OwnedFunction,
    pub given: Vec<bool>,
    pub schedule: OwnedFunction,
    pub kernel: OwnedKernel,
}

/// A [`TapeFunction`] with its lists.
#[derive(Clone, Debug, Default, PartialEq)]
#[allow(missing_docs, reason = "the fields are those of a function")]
pub struct OwnedFunction {
    pub operations: Vec<Operation>,
    pub results: Vec<u32>,
}

/// A [`TapeKernel`] with its lists.
#[derive(Clone, Debug, Default, PartialEq)]
#[allow(missing_docs, reason = "the fields are those of a kernel")]
pub struct OwnedKernel {
    pub operations: usize,
    pub has_angle: Vec<bool>,
    pub position: OwnedFunction,
    pub velocity_residual: OwnedFunction,
    pub correction: OwnedFunction,
    pub accelerations: OwnedFunction,
    pub multipliers: OwnedFunction,
    pub outputs: OwnedFunction,
}

impl OwnedTape {
    /// A copy of a tape.
    pub fn of(tape: &Tape) -> Self {
        Self {
            coordinates: tape.coordinates,
            constraints: tape.constraints,
            is_driven: tape.is_driven,
            parameters: OwnedFunction::of(tape.parameters),
            constants: tape.constants.to_vec(),
            dynamics: OwnedFunction::of(tape.dynamics),
            loop_constraints: OwnedFunction::of(tape.loop_constraints),
            mass_matrix: OwnedFunction::of(tape.mass_matrix),
            energy: OwnedFunction::of(tape.energy),
            power: OwnedFunction::of(tape.power),
            outputs: OwnedFunction::of(tape.outputs),
            linearization: tape.linearization.map(OwnedFunction::of),
            event: tape.event.map(OwnedFunction::of),
            switching_functions: OwnedFunction::of(tape.switching_functions),
            linear_in_time: tape.linear_in_time,
            tanh_arguments: OwnedFunction::of(tape.tanh_arguments),
            start: OwnedFunction::of(tape.start),
            given: tape.given.to_vec(),
            schedule: OwnedFunction::of(tape.schedule),
            kernel: OwnedKernel::of(&tape.kernel),
        }
    }

    /// The tape, ready to be evaluated.
    pub fn tape(&self) -> Tape<'_> {
        Tape {
            coordinates: self.coordinates,
            constraints: self.constraints,
            is_driven: self.is_driven,
            parameters: self.parameters.borrowed(),
            constants: &self.constants,
            dynamics: self.dynamics.borrowed(),
            loop_constraints: self.loop_constraints.borrowed(),
            mass_matrix: self.mass_matrix.borrowed(),
            energy: self.energy.borrowed(),
            power: self.power.borrowed(),
            outputs: self.outputs.borrowed(),
            linearization: self.linearization.as_ref().map(OwnedFunction::borrowed),
            event: self.event.as_ref().map(OwnedFunction::borrowed),
            switching_functions: self.switching_functions.borrowed(),
            linear_in_time: self.linear_in_time,
            tanh_arguments: self.tanh_arguments.borrowed(),
            start: self.start.borrowed(),
            given: &self.given,
            schedule: self.schedule.borrowed(),
            kernel: self.kernel.borrowed(),
        }
    }
}

impl OwnedFunction {
    fn of(function: TapeFunction) -> Self {
        Self { operations: function.operations.to_vec(), results: function.results.to_vec() }
    }

    fn borrowed(&self) -> TapeFunction<'_> {
        TapeFunction { operations: &self.operations, results: &self.results }
    }
}

impl OwnedKernel {
    fn of(kernel: &TapeKernel) -> Self {
        Self {
            operations: kernel.operations,
            has_angle: kernel.has_angle.to_vec(),
            position: OwnedFunction::of(kernel.position),
            velocity_residual: OwnedFunction::of(kernel.velocity_residual),
            correction: OwnedFunction::of(kernel.correction),
            accelerations: OwnedFunction::of(kernel.accelerations),
            multipliers: OwnedFunction::of(kernel.multipliers),
            outputs: OwnedFunction::of(kernel.outputs),
        }
    }

    fn borrowed(&self) -> TapeKernel<'_> {
        TapeKernel {
            operations: self.operations,
            has_angle: &self.has_angle,
            position: self.position.borrowed(),
            velocity_residual: self.velocity_residual.borrowed(),
            correction: self.correction.borrowed(),
            accelerations: self.accelerations.borrowed(),
            multipliers: self.multipliers.borrowed(),
            outputs: self.outputs.borrowed(),
        }
    }
}
