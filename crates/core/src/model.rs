//! A mechanism as an entry in a program's list of models.

extern crate alloc;

use alloc::boxed::Box;
use alloc::vec::Vec;

use crate::batch::Batch;
use crate::compiled::{Generated, LaneStepsTable};
use crate::description::Description;
use crate::interpreted;
use crate::lane_layout::BatchRequest;
use crate::mechanism::Mechanism;
use crate::named_tape::NamedTape;
use crate::stored_tape::StoredTape;
use crate::tape::{Tape, TapeEvaluator};
use crate::width::Width;

/// New values of parameters by name.
pub type ParameterOverrides<'a> = &'a dyn Fn(&str) -> Option<f64>;

/// A mechanism of any size: its functions as data, and compiled if available.
#[derive(Clone, Copy, Debug)]
pub struct Model {
    /// Names, units and meanings.
    pub description: &'static Description,
    stored: &'static StoredTape,
    compiled: Option<CompiledFunctions>,
}

/// Plain functions, compiled once for each scene.
#[derive(Clone, Copy, Debug)]
struct CompiledFunctions {
    mechanism: fn(Vec<f64>) -> Box<dyn Mechanism>,
    lane_steps: LaneStepsTable,
}

impl Model {
    /// Creates the entry of a generated mechanism.
    pub const fn from_generated<X: Generated<N, M>, const N: usize, const M: usize>() -> Self {
        Self {
            description: X::DESCRIPTION,
            stored: X::TAPE,
            compiled: Some(CompiledFunctions { mechanism: X::mechanism, lane_steps: X::LANE_STEPS }),
        }
    }

    /// Creates the entry of a mechanism whose tape is interpreted.
    pub const fn interpreted(description: &'static Description, stored: &'static StoredTape) -> Self {
        Self { description, stored, compiled: None }
    }

    /// Removes the compiled functions of the entry: its tape is interpreted.
    #[must_use]
    pub const fn without_compiled_functions(self) -> Self {
        Self { compiled: None, ..self }
    }

    /// Whether the tape is interpreted.
    pub const fn is_interpreted(&self) -> bool {
        self.compiled.is_none()
    }

    /// The functions as data, for any kind of number.
    pub fn tape(&self) -> &'static Tape {
        self.stored.tape()
    }

    /// The functions with their names, for printers.
    pub fn named_tape(&self) -> &'static NamedTape {
        self.stored.named()
    }

    /// The number of operations of the kernel for accelerations and multipliers.
    pub fn operations(&self) -> usize {
        self.tape().kernel.operations
    }

    /// The values of the parameters in the order of the description, with these replacements, followed by the values
    /// that the scene computes from them.
    pub fn parameter_values(&self, replace: ParameterOverrides) -> Vec<f64> {
        self.parameter_values_by(&mut TapeEvaluator::new(self.tape()), replace)
    }

    /// Evaluates the values by the tape, so that a changed number needs no recompilation.
    fn parameter_values_by(&self, evaluator: &mut TapeEvaluator<Vec<f64>>, replace: ParameterOverrides) -> Vec<f64> {
        evaluator.set_parameters(|i| replace(self.description.parameters[i].name));
        evaluator.parameters().to_vec()
    }

    /// Creates one mechanism for each of these replacements.
    pub fn mechanisms(&self, replacements: &[ParameterOverrides]) -> Vec<Box<dyn Mechanism>> {
        let mut evaluator = TapeEvaluator::new(self.tape());
        let values = replacements.iter().map(|replace| self.parameter_values_by(&mut evaluator, *replace));
        values.map(|values| self.mechanism_with(values)).collect()
    }

    /// Creates the mechanism with some parameters replaced.
    pub fn mechanism(&self, replace: ParameterOverrides) -> Box<dyn Mechanism> {
        self.mechanism_with(self.parameter_values(replace))
    }

    /// Creates the mechanism with these values of all parameters, in the order of the description.
    pub fn mechanism_with(&self, values: Vec<f64>) -> Box<dyn Mechanism> {
        match self.compiled {
            Some(compiled) => (compiled.mechanism)(values),
            None => interpreted::mechanism(self.description, self.tape(), values),
        }
    }

    /// A batch of motions in lanes of this width; `None` where the processor has no such vectors, or the kernel is too
    /// large for them.
    ///
    /// A step counts as reliable up to this `residual` of the constraints.
    pub fn batch(&self, width: Width, request: BatchRequest, residual: f64) -> Option<Batch> {
        let steps = match self.compiled {
            Some(CompiledFunctions { lane_steps: [four, eight], .. }) => match width {
                Width::Four => four(request, residual),
                Width::Eight => eight(request, residual),
            },
            None => interpreted::lane_steps((self.description, self.tape()), width, request, residual),
        }?;
        Some(Batch::new(steps, self.description, request, residual))
    }
}
