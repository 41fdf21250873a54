//! The equations of motion in the order a step needs them.

use crate::angles::Angles;
use crate::scalar::Scalar;
use crate::{Closure, Dynamics};

/// The equations of motion of a mechanism with `N` coordinates and `M` constraints, cut where a step takes them up again:
/// what follows from the position alone is computed once, and serves accelerations as well as corrections.
///
/// The closures `C_q qdd + bias = 0` are solved for `M` coordinates that depend on the others; the motion of those follows from
/// `T' (Mbar qdd - fbar) = 0` with the tangents `T`, `C_q T = 0`.
pub trait Kernel<R: Scalar, const N: usize, const M: usize>: Copy {
    /// What follows from the position alone.
    type Position: Copy;

    /// Which coordinates need a sine or cosine.
    const IS_ANGLE: [bool; N];

    /// How many operations accelerations and multipliers take. Large kernels are compiled into fewer places.
    const OPERATIONS: usize;

    /// The mechanism with these values of its parameters, in the order of the description.
    fn with_values(value: impl Fn(usize) -> R) -> Self;

    /// What follows from the position `q` at time `t`.
    fn position(&self, t: R, q: &[R; N], angles: &Angles<R, N>) -> Self::Position;

    /// `C(q, t)`.
    fn residuals(&self, position: &Self::Position) -> [R; M];

    /// How much the solution of the closures magnifies rounding errors: where it is large, the choice of dependent
    /// coordinates does not suit the position.
    fn strain(&self, position: &Self::Position) -> R;

    /// `C_q qd + C_t`.
    fn drift(&self, position: &Self::Position, qd: &[R; N]) -> [R; M];

    /// The change of coordinates that is least in the metric of `Mbar` among those with `C_q dq = -residuals`.
    fn correction(&self, position: &Self::Position, residuals: &[R; M]) -> [R; N];

    /// `qdd` and the multipliers.
    fn accelerations(
        &self,
        position: &Self::Position,
        t: R,
        q: &[R; N],
        qd: &[R; N],
        angles: &Angles<R, N>,
    ) -> ([R; N], [R; M]);

    /// Rises through zero when the scene's stop condition becomes true; `None` if it has none.
    fn ending(&self, t: R, q: &[R; N], qd: &[R; N]) -> Option<R>;

    /// The outputs that the scene asks for, as far as `outputs` has room, at a position that is known.
    #[allow(clippy::too_many_arguments, reason = "they are what there is to know of a row")]
    fn outputs_at(
        &self,
        position: &Self::Position,
        t: R,
        q: &[R; N],
        qd: &[R; N],
        angles: &Angles<R, N>,
        qdd: &[R; N],
        multipliers: &[R; M],
        outputs: &mut [R],
    );

    /// The same from the state alone.
    fn outputs(&self, t: R, q: &[R; N], qd: &[R; N], qdd: &[R; N], multipliers: &[R; M], outputs: &mut [R]);

    /// All that the accelerations need by the plain functions, where there are such: for positions that the kernel does not suit.
    fn plain_dynamics(&self, _t: R, _q: &[R; N], _qd: &[R; N]) -> Option<Dynamics<R, N, M>> {
        None
    }

    /// All that a correction needs, likewise.
    fn plain_closure(&self, _t: R, _q: &[R; N]) -> Option<Closure<R, N, M>> {
        None
    }
}

/// Growth of rounding errors beyond which a kernel does not suit a position.
pub const MOST_STRAIN: f64 = 1e3;

/// `qdd` and the multipliers at one state; `None` where the kernel does not suit the position, or a number is not finite.
#[inline(always)]
pub fn accelerations<K: Kernel<f64, N, M>, const N: usize, const M: usize>(
    kernel: &K,
    t: f64,
    q: &[f64; N],
    qd: &[f64; N],
) -> Option<([f64; N], [f64; M])> {
    let angles = Angles::new(q, K::IS_ANGLE);
    let position = kernel.position(t, q, &angles);
    let (qdd, multipliers) = kernel.accelerations(&position, t, q, qd, &angles);
    let is_finite = qdd.iter().chain(&multipliers).all(|value| value.is_finite());
    (is_finite && kernel.strain(&position) <= MOST_STRAIN).then_some((qdd, multipliers))
}

/// The kernel of a mechanism that has none: every step is made by the plain functions.
#[derive(Clone, Copy, Debug)]
pub struct NoKernel;

impl<R: Scalar, const N: usize, const M: usize> Kernel<R, N, M> for NoKernel {
    type Position = ();

    const IS_ANGLE: [bool; N] = [false; N];
    const OPERATIONS: usize = usize::MAX;

    fn with_values(_: impl Fn(usize) -> R) -> Self {
        Self
    }

    fn position(&self, _: R, _: &[R; N], _: &Angles<R, N>) {}

    fn residuals(&self, (): &()) -> [R; M] {
        [R::zero(); M]
    }

    fn strain(&self, (): &()) -> R {
        R::from_f64(f64::INFINITY)
    }

    fn drift(&self, (): &(), _: &[R; N]) -> [R; M] {
        [R::zero(); M]
    }

    fn correction(&self, (): &(), _: &[R; M]) -> [R; N] {
        [R::zero(); N]
    }

    fn accelerations(&self, (): &(), _: R, _: &[R; N], _: &[R; N], _: &Angles<R, N>) -> ([R; N], [R; M]) {
        ([R::zero(); N], [R::zero(); M])
    }

    fn ending(&self, _: R, _: &[R; N], _: &[R; N]) -> Option<R> {
        None
    }

    fn outputs_at(&self, (): &(), _: R, _: &[R; N], _: &[R; N], _: &Angles<R, N>, _: &[R; N], _: &[R; M], _: &mut [R]) {
    }

    fn outputs(&self, _: R, _: &[R; N], _: &[R; N], _: &[R; N], _: &[R; M], _: &mut [R]) {}
}
