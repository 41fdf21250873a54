//! Steps of one mechanism in the lanes of vectors: the part of a batch that is compiled for each scene.

mod ranges;
mod step_control;

extern crate alloc;

use alloc::boxed::Box;
use alloc::vec;
use alloc::vec::Vec;

use crate::angles::Angles;
use crate::description::Description;
use crate::kernel::Kernel;
use crate::kernel_state::KernelState;
use crate::lane_layout::{BatchLayout, BatchRequest};
use crate::lanes::{Lanes, Token};
#[cfg(target_arch = "x86_64")]
use crate::scalar::Fused;
use crate::scalar::Scalar;
#[cfg(target_arch = "x86_64")]
use crate::width::Width;

/// Steps in lanes, independent of the mechanism and the number of lanes. [`Batch`](crate::Batch), which knows
/// the places of the numbers, uses them.
pub trait LaneSteps {
    /// The number of lanes.
    fn lanes(&self) -> usize;

    /// Whether each lane makes steps until it needs its caller itself, whatever the others do.
    fn are_independent(&self) -> bool {
        false
    }

    /// Reads consecutive numbers of a lane, beginning at a place of the batch.
    fn read(&self, place: usize, lane: usize, numbers: &mut [f64]);

    /// Replaces consecutive numbers of a lane, beginning at a place of the batch.
    fn write(&mut self, place: usize, lane: usize, numbers: &[f64]);

    /// Makes steps in all lanes until one needs its caller; independent lanes make steps until they need it themselves,
    /// or have made very many. Returns whether the steps could be made.
    ///
    /// A lane needs its caller when it has reached its end time or its event, when its steps are too short, too many or
    /// unreliable, or when the caller inspects each step.
    fn advance(&mut self) -> bool;
}

/// Whether a kernel with this number of operations is compiled for vectors of this width: large kernels for the widest
/// alone, kernels that exceed the processor's cache for none.
#[cfg(target_arch = "x86_64")]
pub(crate) const fn suits(width: Width, operations: usize) -> bool {
    match width {
        Width::Four => operations <= Fused::INLINE_LIMIT,
        Width::Eight => operations <= 2000,
    }
}

/// A boxed [`LaneSteps`].
pub type BoxedLaneSteps = Box<dyn LaneSteps>;

/// Steps with one kind of vector.
pub(crate) struct StepsBy<K, S: Token, const N: usize, const M: usize> {
    token: S,
    layout: BatchLayout,
    request: BatchRequest,
    residual: f64,
    kernel: K,
    /// All numbers, at the places of the layout.
    numbers: Vec<Lanes<S>>,
}

/// A motion in each lane.
#[derive(Clone, Copy)]
struct LaneMotion<S: Token, const N: usize, const M: usize> {
    t: Lanes<S>,
    state: KernelState<Lanes<S>, N, M>,
}

impl<K: Kernel<Lanes<S>, N, M>, S: Token, const N: usize, const M: usize> StepsBy<K, S, N, M> {
    /// Creates the steps of a kernel; its parameters are set later.
    #[inline]
    pub(crate) fn new(token: S, kernel: K, mechanism: &Description, request: BatchRequest, residual: f64) -> Self {
        let layout = BatchLayout::new(mechanism, &request);
        Self { token, layout, request, residual, kernel, numbers: vec![Lanes::zero(); layout.places()] }
    }

    #[inline(always)]
    fn motion(&self) -> LaneMotion<S, N, M> {
        LaneMotion::read(&self.kernel, &self.numbers[self.layout().row()..])
    }

    #[inline(always)]
    fn set_row(&mut self, place: usize, motion: &LaneMotion<S, N, M>) {
        motion.write(self.kernel.sizes(), &mut self.numbers[place..]);
    }

    #[inline(always)]
    fn layout(&self) -> BatchLayout {
        // If the sizes are known to the compiler, so are most places.
        let [n, m] = self.kernel.sizes();
        BatchLayout { n, m, ..self.layout }
    }

    /// Sets the parameters of each lane in the kernel.
    #[inline(always)]
    fn set_kernel(&mut self) {
        let parameters = &self.numbers[self.layout.parameters()..];
        self.kernel.set_values(&|i| parameters[i]);
    }

    #[inline(always)]
    fn number(&self, place: usize) -> Lanes<S> {
        self.numbers[place]
    }

    #[inline(always)]
    fn set_number(&mut self, place: usize, number: Lanes<S>) {
        self.numbers[place] = number;
    }
}

impl<S: Token, const N: usize, const M: usize> LaneMotion<S, N, M> {
    /// Reads a motion from the places of a row.
    #[inline(always)]
    fn read<K: Kernel<Lanes<S>, N, M>>(kernel: &K, row: &[Lanes<S>]) -> Self {
        let ([n, m], zero) = (kernel.sizes(), Lanes::zero());
        let (mut q, mut qd, mut qdd, mut multipliers) = ([zero; N], [zero; N], [zero; N], [zero; M]);
        for i in 0..n {
            q[i] = row[1 + i];
            qd[i] = row[1 + n + i];
            qdd[i] = row[1 + 2 * n + i];
        }
        for k in 0..m {
            multipliers[k] = row[1 + 3 * n + k];
        }
        let angles = Angles::new_out_of_line(&q, kernel.has_angle());
        Self { t: row[0], state: KernelState { q, qd, qdd, multipliers, angles } }
    }

    /// Writes the motion to the places of a row.
    #[inline(always)]
    fn write(&self, [n, m]: [usize; 2], row: &mut [Lanes<S>]) {
        let Self { t, state } = self;
        row[0] = *t;
        for i in 0..n {
            row[1 + i] = state.q[i];
            row[1 + n + i] = state.qd[i];
            row[1 + 2 * n + i] = state.qdd[i];
        }
        for k in 0..m {
            row[1 + 3 * n + k] = state.multipliers[k];
        }
    }
}

/// Runs `make_steps` with the target features of the token.
struct MakeSteps<'a, K, S: Token, const N: usize, const M: usize>(&'a mut StepsBy<K, S, N, M>);

impl<K, S, const N: usize, const M: usize> pulp::NullaryFnOnce for MakeSteps<'_, K, S, N, M>
where
    K: Kernel<Lanes<S>, N, M>,
    S: Token,
{
    type Output = ();

    #[inline(always)]
    fn call(self) {
        self.0.make_steps();
    }
}

impl<K: Kernel<Lanes<S>, N, M>, S: Token, const N: usize, const M: usize> LaneSteps for StepsBy<K, S, N, M> {
    #[inline]
    fn lanes(&self) -> usize {
        Lanes::<S>::COUNT
    }

    #[inline]
    fn read(&self, place: usize, lane: usize, numbers: &mut [f64]) {
        numbers.iter_mut().zip(&self.numbers[place..]).for_each(|(number, lanes)| *number = lanes.get(lane));
    }

    #[inline]
    fn write(&mut self, place: usize, lane: usize, numbers: &[f64]) {
        self.numbers[place..].iter_mut().zip(numbers).for_each(|(lanes, number)| lanes.set(lane, *number));
    }

    #[inline]
    fn advance(&mut self) -> bool {
        let token = self.token;
        token.vectorize(MakeSteps(self));
        true
    }
}
