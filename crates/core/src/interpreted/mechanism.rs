//! An interpreted mechanism by plain functions over slices.

extern crate alloc;

use alloc::boxed::Box;
use alloc::vec;
use alloc::vec::Vec;

#[cfg(target_arch = "x86_64")]
use super::LARGEST_IN_LANES;
#[cfg(target_arch = "x86_64")]
use super::kernel::InterpretedKernel;
use super::{Interpreted, lock};
use crate::buffers::{DynamicsMut, LinearizationMut, LoopConstraintsMut, StartMut, StateRef};
use crate::description::Description;
#[cfg(target_arch = "x86_64")]
use crate::gauss::GaussSteps;
#[cfg(target_arch = "x86_64")]
use crate::kernel::Kernel;
use crate::kernel::Schedule;
use crate::mechanism::Mechanism;
use crate::projection::{ProjectionResult, StateMut, complete};
use crate::rows::{RowRequest, RowResult, integrate_rk4};
use crate::scalar::{Fused, Scalar};
use crate::single_step::{StepEstimate, StepMut, StepRequest, fused};
use crate::tape::{Tape, split};
#[cfg(target_arch = "x86_64")]
use crate::width::Width;

/// Copies consecutive parts of results to their places.
fn scatter<const K: usize>(results: &[f64], parts: [&mut [f64]; K]) {
    let lengths = core::array::from_fn(|i| parts[i].len());
    for (part, result) in parts.into_iter().zip(split::<_, K>(results, lengths)) {
        part.copy_from_slice(result);
    }
}

impl<const C: usize> Mechanism for Interpreted<C> {
    fn description(&self) -> &'static Description {
        self.description
    }

    fn parameters(&self) -> &[f64] {
        &self.values
    }

    fn tape(&self) -> Option<&'static Tape> {
        Some(self.tape)
    }

    fn with_parameters(&self, values: Vec<f64>) -> Option<Box<dyn Mechanism>> {
        Some(Box::new(Self::new(self.description, self.tape, values)))
    }

    fn is_driven(&self) -> bool {
        self.tape.is_driven
    }

    fn has_linearization(&self) -> bool {
        self.tape.linearization.is_some()
    }

    fn operations(&self) -> usize {
        self.tape.kernel.operations
    }

    fn start(&self, start: StartMut) {
        self.evaluator().start(start.q, start.qd);
        let (given, given_rates) = self.tape.given.split_at(start.given.len());
        start.given.copy_from_slice(given);
        start.given_rates.copy_from_slice(given_rates);
    }

    fn schedule(&self) -> Schedule<f64> {
        self.evaluator().schedule()
    }

    fn event(&self, at: &StateRef) -> Option<f64> {
        self.evaluator().event(at.t, at.q, at.qd, at.qdd, at.multipliers)
    }

    fn dynamics(&self, t: f64, q: &[f64], qd: &[f64], dynamics: DynamicsMut) {
        let mut results = vec![0.0; self.tape.dynamics_length()];
        self.evaluator().dynamics(t, q, qd, &mut results);
        let DynamicsMut { mass_matrix, generalized_forces, constraint_jacobian, constraint_bias } = dynamics;
        scatter(&results, [mass_matrix, generalized_forces, constraint_jacobian, constraint_bias]);
    }

    fn loop_constraints(&self, t: f64, q: &[f64], constraints: LoopConstraintsMut) {
        let mut results = vec![0.0; self.tape.loop_constraints.results.len()];
        self.evaluator().loop_constraints(t, q, &mut results);
        let LoopConstraintsMut { residuals, constraint_jacobian, constraint_rate } = constraints;
        scatter(&results, [residuals, constraint_jacobian, constraint_rate]);
    }

    fn mass_matrix(&self, q: &[f64], mass_matrix: &mut [f64]) {
        self.evaluator().mass_matrix(q, mass_matrix);
    }

    fn energy(&self, q: &[f64], qd: &[f64]) -> [f64; 2] {
        self.evaluator().energy(q, qd)
    }

    fn power(&self, t: f64, q: &[f64], qd: &[f64], qdd: &[f64], multipliers: &[f64]) -> f64 {
        self.evaluator().power(t, q, qd, qdd, multipliers)
    }

    fn outputs(&self, t: f64, q: &[f64], qd: &[f64], qdd: &[f64], multipliers: &[f64], outputs: &mut [f64]) {
        let mut results = vec![0.0; self.tape.outputs.results.len()];
        self.evaluator().outputs(t, q, qd, qdd, multipliers, &mut results);
        outputs.iter_mut().zip(results).for_each(|(output, result)| *output = result);
    }

    fn linearization(
        &self,
        t: f64,
        q: &[f64],
        qd: &[f64],
        qdd: &[f64],
        multipliers: &[f64],
        linearization: LinearizationMut,
    ) -> bool {
        let Some(function) = &self.tape.linearization else { return false };
        let mut results = vec![0.0; function.results.len()];
        self.evaluator().linearization(t, q, qd, qdd, multipliers, &mut results);
        let LinearizationMut { stiffness, damping, constraint_stiffness, constraint_damping, .. } = linearization;
        let (forcing, constraint_forcing) = (linearization.forcing, linearization.constraint_forcing);
        let parts = [stiffness, damping, constraint_stiffness, constraint_damping, forcing, constraint_forcing];
        scatter(&results, parts);
        true
    }

    fn accelerations(&self, t: f64, q: &[f64], qd: &[f64], qdd: &mut [f64], multipliers: &mut [f64]) -> bool {
        let Some(kernel) = &self.kernel else { return false };
        let (mut q, mut qd) = (q.to_vec(), qd.to_vec());
        let state = StateMut { q: &mut q, qd: &mut qd, qdd, multipliers };
        complete(&*lock(kernel), t, None, state).is_some()
    }

    fn project(&self, t: f64, residual: f64, state: StateMut) -> Option<ProjectionResult> {
        complete(&*lock(self.kernel.as_ref()?), t, Some(residual), state)
    }

    fn dop853_step(&self, request: &StepRequest, from: &StateRef, step: StepMut) -> Option<StepEstimate> {
        let kernel = &*lock(self.fused.as_ref()?);
        Fused::vectorize(
            #[inline(always)]
            || fused::dop853(kernel, request, from, step),
        )?
    }

    #[cfg(target_arch = "x86_64")]
    fn gauss_steps(&self, width: Width) -> Option<Box<dyn GaussSteps>> {
        use crate::gauss::Steps;
        use crate::lanes::Lanes;
        use pulp::x86::{V3, V4};
        if const { C > LARGEST_IN_LANES } {
            return None;
        }
        let (description, tape) = (self.description, self.tape);
        Some(match width {
            Width::Four => {
                let token = V3::try_new()?;
                let mut kernel = InterpretedKernel::<Lanes<V3>, C>::new(tape, description)?;
                kernel.set_values(&|i| Lanes::from_f64(self.values[i]));
                Box::new(Steps::new(token, kernel))
            }
            Width::Eight => {
                let token = V4::try_new()?;
                let mut kernel = InterpretedKernel::<Lanes<V4>, C>::new(tape, description)?;
                kernel.set_values(&|i| Lanes::from_f64(self.values[i]));
                Box::new(Steps::new(token, kernel))
            }
        })
    }

    fn integrate_rk4(&self, request: &RowRequest, rows: &mut [f64]) -> RowResult {
        let (Some(kernel), Some(fused)) = (&self.kernel, &self.fused) else {
            return RowResult { rows_written: 0, reason: None };
        };
        // The same numbers as a compiled kernel has.
        let fused = &*lock(fused);
        if let Some(result) = Fused::vectorize(
            #[inline(always)]
            || integrate_rk4(fused, request, &mut *rows),
        ) {
            return result;
        }
        integrate_rk4(&*lock(kernel), request, rows)
    }
}
