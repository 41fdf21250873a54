//! The quick-return mechanism without the generator, for comparison in numbers and in speed: by hand, and by dual numbers.

mod by_dual_numbers;
mod by_hand;
mod kernel_by_hand;

use qrm_core::{Closure, Description, Dynamics, Kernel, Mechanism, Scalar, Schedule, Start};

pub use by_dual_numbers::ByDualNumbers;
pub use by_hand::ByHand;
pub use kernel_by_hand::KernelByHand;

use crate::quick_return::{Parameters, QuickReturn};

/// What a step needs, however it is come by.
pub trait Equations: Copy {
    /// The same in the order a step needs it.
    type Kernel<R: Scalar>: Kernel<R, 3, 2>;

    /// Those of the mechanism with these parameters.
    fn new(parameters: Parameters) -> Self;

    /// Mass matrix, forces, constraint Jacobian and bias.
    fn dynamics(&self, q: &[f64; 3], qd: &[f64; 3]) -> Dynamics<f64, 3, 2>;

    /// Constraints and their Jacobian.
    fn closure(&self, q: &[f64; 3]) -> Closure<f64, 3, 2>;
}

/// The quick-return mechanism with equations from elsewhere; start, outputs and energy are those of the generated code.
#[derive(Clone, Copy, Debug)]
pub struct Twin<E> {
    generated: QuickReturn,
    /// Where they are from.
    pub equations: E,
}

impl<E: Equations> Twin<E> {
    /// The mechanism with these parameters.
    pub fn new(parameters: Parameters) -> Self {
        Self { generated: QuickReturn::new(parameters), equations: E::new(parameters) }
    }
}

impl<E: Equations> Mechanism<3, 2> for Twin<E> {
    type Kernel<R: Scalar> = E::Kernel<R>;

    const DESCRIPTION: Description = QuickReturn::<f64>::DESCRIPTION;

    fn with_parameters(replace: &dyn Fn(&str) -> Option<f64>) -> Self {
        Self::new(Parameters::with(replace))
    }

    #[inline(always)]
    fn dynamics(&self, _t: f64, q: &[f64; 3], qd: &[f64; 3]) -> Dynamics<f64, 3, 2> {
        self.equations.dynamics(q, qd)
    }

    #[inline(always)]
    fn closure(&self, _t: f64, q: &[f64; 3]) -> Closure<f64, 3, 2> {
        self.equations.closure(q)
    }

    fn visit_parameters(&self, visit: &mut dyn FnMut(f64)) {
        self.generated.visit_parameters(visit);
    }

    fn start(&self) -> Start<f64, 3> {
        self.generated.start()
    }

    fn schedule(&self) -> Schedule<f64> {
        self.generated.schedule()
    }

    fn stop(&self, t: f64, q: &[f64; 3], qd: &[f64; 3]) -> Option<f64> {
        self.generated.stop(t, q, qd)
    }

    fn mass_matrix(&self, q: &[f64; 3]) -> [[f64; 3]; 3] {
        self.equations.dynamics(q, &[0.0; 3]).mass_matrix
    }

    fn energy(&self, q: &[f64; 3], qd: &[f64; 3]) -> [f64; 2] {
        self.generated.energy(q, qd)
    }

    fn power(&self, t: f64, q: &[f64; 3], qd: &[f64; 3], multipliers: &[f64; 2]) -> f64 {
        self.generated.power(t, q, qd, multipliers)
    }

    fn outputs(
        &self,
        t: f64,
        q: &[f64; 3],
        qd: &[f64; 3],
        qdd: &[f64; 3],
        multipliers: &[f64; 2],
        outputs: &mut [f64],
    ) {
        Mechanism::outputs(&self.generated, t, q, qd, qdd, multipliers, outputs);
    }
}
