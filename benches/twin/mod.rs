//! The quick-return mechanism without the generator, for comparison in numbers and in speed: by hand, and by dual
//! numbers.

mod by_dual_numbers;
mod by_hand;
mod kernel_by_hand;

use qrm_core::{
    Description, Dynamics, DynamicsMut, Equations, LoopConstraints, LoopConstraintsMut, Mechanism, Model,
    ParameterOverrides, Schedule, StartMut, StateRef,
};

pub(crate) use by_dual_numbers::ByDualNumbers;
pub(crate) use by_hand::ByHand;
pub(crate) use kernel_by_hand::{HandWritten, KernelByHand};

use qrm_model::quick_return::{Parameters, QuickReturn};

/// The parts of the equations of motion, from any source.
pub(crate) trait PlainFunctions: Copy + Send + Sync {
    /// The equations with these parameters.
    fn new(parameters: Parameters) -> Self;

    /// Mass matrix, forces, constraint Jacobian and bias.
    fn dynamics(&self, q: &[f64; 3], qd: &[f64; 3]) -> Dynamics<f64, 3, 2>;

    /// The loop constraints and their Jacobian.
    fn loop_constraints(&self, q: &[f64; 3]) -> LoopConstraints<f64, 3, 2>;
}

/// The generated functions, without their kernel.
impl PlainFunctions for QuickReturn {
    fn new(parameters: Parameters) -> Self {
        Self::new(parameters)
    }

    #[inline(always)]
    fn dynamics(&self, q: &[f64; 3], qd: &[f64; 3]) -> Dynamics<f64, 3, 2> {
        Equations::dynamics(self, 0.0, q, qd)
    }

    #[inline(always)]
    fn loop_constraints(&self, q: &[f64; 3]) -> LoopConstraints<f64, 3, 2> {
        Equations::loop_constraints(self, 0.0, q)
    }
}

/// The quick-return mechanism with equations from elsewhere and no kernel; start, outputs and energy are generated.
pub(crate) struct Twin<E> {
    generated: Box<dyn Mechanism>,
    equations: E,
}

impl<E: PlainFunctions> Twin<E> {
    /// The mechanism with the scene's parameters.
    pub(crate) fn new() -> Self {
        Self::with_parameters(&|_| None)
    }

    /// The mechanism with some parameters replaced.
    pub(crate) fn with_parameters(replace: ParameterOverrides) -> Self {
        let generated = Model::from_generated::<QuickReturn, 3, 2>().mechanism(replace);
        Self { generated, equations: E::new(Parameters::with(replace)) }
    }
}

impl<E: PlainFunctions> Mechanism for Twin<E> {
    fn description(&self) -> &'static Description {
        self.generated.description()
    }

    fn parameters(&self) -> &[f64] {
        self.generated.parameters()
    }

    fn is_driven(&self) -> bool {
        false
    }

    fn operations(&self) -> usize {
        self.generated.operations()
    }

    fn start(&self, start: StartMut) {
        self.generated.start(start);
    }

    fn schedule(&self) -> Schedule<f64> {
        self.generated.schedule()
    }

    fn event(&self, at: &StateRef) -> Option<f64> {
        self.generated.event(at)
    }

    fn dynamics(&self, _t: f64, q: &[f64], qd: &[f64], dynamics: DynamicsMut) {
        let own = self.equations.dynamics(array(q), array(qd));
        dynamics.mass_matrix.copy_from_slice(own.mass_matrix.as_flattened());
        dynamics.generalized_forces.copy_from_slice(&own.generalized_forces);
        dynamics.constraint_jacobian.copy_from_slice(own.constraint_jacobian.as_flattened());
        dynamics.constraint_bias.copy_from_slice(&own.constraint_bias);
    }

    fn loop_constraints(&self, _t: f64, q: &[f64], constraints: LoopConstraintsMut) {
        let own = self.equations.loop_constraints(array(q));
        constraints.residuals.copy_from_slice(&own.residuals);
        constraints.constraint_jacobian.copy_from_slice(own.constraint_jacobian.as_flattened());
        constraints.constraint_rate.copy_from_slice(&own.constraint_rate);
    }

    fn mass_matrix(&self, q: &[f64], mass_matrix: &mut [f64]) {
        mass_matrix.copy_from_slice(self.equations.dynamics(array(q), &[0.0; 3]).mass_matrix.as_flattened());
    }

    fn energy(&self, q: &[f64], qd: &[f64]) -> [f64; 2] {
        self.generated.energy(q, qd)
    }

    fn power(&self, t: f64, q: &[f64], qd: &[f64], qdd: &[f64], multipliers: &[f64]) -> f64 {
        self.generated.power(t, q, qd, qdd, multipliers)
    }

    fn outputs(&self, t: f64, q: &[f64], qd: &[f64], qdd: &[f64], multipliers: &[f64], outputs: &mut [f64]) {
        self.generated.outputs(t, q, qd, qdd, multipliers, outputs);
    }
}

/// A slice of coordinates as an array.
#[inline(always)]
fn array(x: &[f64]) -> &[f64; 3] {
    x.as_array().expect("the mechanism has three coordinates")
}
