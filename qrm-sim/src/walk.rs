//! Many steps by a mechanism's kernel, with the instructions of the processor at hand.

use qrm_core::{Angles, Fused, Kernel, LARGE, Mechanism, Scalar, State, stride};

use crate::linear::Vector;
use crate::motion::{self, Breakdown, Method, Moment, Scheme};
use crate::projection::Projection;
use crate::solve::Care;

/// Whether a method is made by kernels.
pub(crate) fn is_walked(method: &Method) -> bool {
    method.scheme == Scheme::Rk4 && method.projection == Projection::Mass
}

/// The values of a mechanism's parameters.
pub(crate) fn parameters<X: Mechanism<N, M>, const N: usize, const M: usize>(mechanism: &X) -> Vec<f64> {
    let mut values = Vec::new();
    mechanism.visit_parameters(&mut |value| values.push(value));
    values
}

/// Who asks for steps and takes them.
pub(crate) trait Walker<const N: usize, const M: usize> {
    /// The end of the next step.
    fn next_time(&self) -> f64;

    /// Takes a moment, and says whether to go on.
    fn arrive(&mut self, moment: Moment<N, M>, care: &mut Care) -> bool;
}

/// Makes steps from `now` until the walker has enough.
///
/// # Errors
/// A step could not be made.
pub(crate) fn walk<X: Mechanism<N, M>, const N: usize, const M: usize>(
    mechanism: &X,
    parameters: &[f64],
    method: &Method,
    now: Moment<N, M>,
    care: &mut Care,
    walker: &mut impl Walker<N, M>,
) -> Result<(), Breakdown> {
    let walk = Walk { mechanism, parameters, method, now, care, walker };
    // Each set of instructions is compiled by itself.
    if X::Kernel::<f64>::OPERATIONS > LARGE { walk.go::<f64>() } else { pulp::Arch::new().dispatch(walk) }
}

/// One step by the kernel on plain doubles, for places where the processor's own instructions cannot be used.
///
/// # Errors
/// The step could not be made.
pub(crate) fn single<X: Mechanism<N, M>, const N: usize, const M: usize>(
    mechanism: &X,
    kernel: &X::Kernel<f64>,
    method: &Method,
    from: &Moment<N, M>,
    t_next: f64,
    care: &mut Care,
) -> Result<Moment<N, M>, Breakdown> {
    let made = stride(kernel, from.t, t_next - from.t, &begin::<X, f64, N, M>(from));
    if made.is_good(method.tolerance.residual) {
        return Ok(moment(t_next, &made.end, made.corrections));
    }
    careful(mechanism, method, from, t_next, care)
}

struct Walk<'a, X, W, const N: usize, const M: usize> {
    mechanism: &'a X,
    parameters: &'a [f64],
    method: &'a Method,
    now: Moment<N, M>,
    care: &'a mut Care,
    walker: &'a mut W,
}

impl<X: Mechanism<N, M>, W: Walker<N, M>, const N: usize, const M: usize> pulp::WithSimd for Walk<'_, X, W, N, M> {
    type Output = Result<(), Breakdown>;

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) -> Self::Output {
        if S::IS_SCALAR { self.go::<f64>() } else { self.go::<Fused>() }
    }
}

impl<X: Mechanism<N, M>, W: Walker<N, M>, const N: usize, const M: usize> Walk<'_, X, W, N, M> {
    #[inline(always)]
    fn go<R: Single>(self) -> Result<(), Breakdown> {
        let kernel = X::Kernel::<R>::with_values(|i| R::from_f64(self.parameters[i]));
        let mut state = begin::<X, R, N, M>(&self.now);
        let mut t = self.now.t;
        loop {
            let t_next = self.walker.next_time();
            let made = stride(&kernel, R::from_f64(t), R::from_f64(t_next - t), &state);
            let next = if made.is_good(self.method.tolerance.residual) {
                state = made.end;
                moment(t_next, &state, made.corrections)
            } else {
                // What is passed on by its address lives in memory: not the state itself, which lives in registers.
                let from = moment(t, &state, 0);
                let careful = careful(self.mechanism, self.method, &from, t_next, self.care)?;
                state = begin::<X, R, N, M>(&careful);
                careful
            };
            t = t_next;
            if !self.walker.arrive(next, self.care) {
                return Ok(());
            }
        }
    }
}

/// The step by the plain functions, which notice what stands in their way.
#[cold]
#[inline(never)]
fn careful<X: Mechanism<N, M>, const N: usize, const M: usize>(
    mechanism: &X,
    method: &Method,
    from: &Moment<N, M>,
    t_next: f64,
    care: &mut Care,
) -> Result<Moment<N, M>, Breakdown> {
    motion::advance(mechanism, method, from, t_next, care)
}

/// One number.
pub(crate) trait Single: Scalar {
    /// Its value.
    fn value(self) -> f64;
}

impl Single for f64 {
    #[inline(always)]
    fn value(self) -> f64 {
        self
    }
}

impl Single for Fused {
    #[inline(always)]
    fn value(self) -> f64 {
        self.0
    }
}

#[inline(always)]
fn begin<X: Mechanism<N, M>, R: Single, const N: usize, const M: usize>(from: &Moment<N, M>) -> State<R, N, M> {
    let q = from.q.map(R::from_f64);
    State {
        q,
        qd: from.qd.map(R::from_f64),
        qdd: from.qdd.map(R::from_f64),
        multipliers: from.multipliers.map(R::from_f64),
        angles: Angles::new(&q, X::Kernel::<R>::IS_ANGLE),
    }
}

#[inline(always)]
fn moment<R: Single, const N: usize, const M: usize>(t: f64, at: &State<R, N, M>, corrections: u32) -> Moment<N, M> {
    Moment {
        t,
        q: plain(&at.q),
        qd: plain(&at.qd),
        qdd: plain(&at.qdd),
        multipliers: plain(&at.multipliers),
        corrections,
    }
}

#[inline(always)]
fn plain<R: Single, const K: usize>(x: &[R; K]) -> Vector<K> {
    x.map(R::value)
}
