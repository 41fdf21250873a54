//! The generated equations of motion, with sizes known when they are compiled.

use crate::angles::Angles;
use crate::scalar::Scalar;

/// The equations of motion of a mechanism with `N` coordinates and `M` constraints, as far as steps need them, on
/// numbers `R`, its parameters inside.
///
/// What follows from the position alone is computed once, and serves accelerations as well as corrections. The
/// constraints `C_q qdd + bias = 0` are solved for `M` coordinates that depend on the others; the motion of those
/// follows from `T' (Mbar qdd - fbar) = 0` with the tangents `T`, `C_q T = 0`.
///
/// All numbers are in SI units, angles in radians.
pub trait Kernel<R: Scalar, const N: usize, const M: usize> {
    /// The quantities that follow from the position alone. They may be used until the second call of
    /// [`position`](Self::position) after the one that gave them.
    type Position: Copy;

    /// The number of operations of accelerations and multipliers. Large kernels are compiled into fewer places.
    const OPERATIONS: usize;

    /// The numbers of coordinates and of constraints; where they are smaller than `N` and `M`, what lies beyond is
    /// zero.
    #[inline(always)]
    fn sizes(&self) -> [usize; 2] {
        [N, M]
    }

    /// For each coordinate, whether its sine or cosine is needed.
    fn has_angle(&self) -> [bool; N];

    /// For each coordinate, whether it is a length, not an angle.
    fn is_length(&self) -> [bool; N];

    /// Gives the parameters these values, in the order of the description.
    fn set_values(&mut self, value: &dyn Fn(usize) -> R);

    /// Calls a function from a place that is never inlined, with the instructions that belong to `R`.
    ///
    /// This is a method of the mechanism, so that rustc compiles it in the codegen unit of the mechanism's module. A
    /// function would be compiled with those of all mechanisms, whenever one of them changes.
    #[inline(never)]
    fn call_out_of_line<T>(f: impl FnOnce() -> T) -> T {
        R::vectorized(f)
    }

    /// The quantities that follow from the position `q` at time `t`.
    fn position(&self, t: R, q: &[R; N], angles: &Angles<R, N>) -> Self::Position;

    /// The residuals of the constraints, `C(q, t)`.
    fn residuals(&self, position: &Self::Position) -> [R; M];

    /// The growth of rounding errors in the solution of the constraints for the dependent coordinates: where it is
    /// large, the choice of dependent coordinates does not suit the position.
    fn growth_factor(&self, position: &Self::Position) -> R;

    /// The rates of the residuals, `C_q qd + C_t`.
    fn velocity_residual(&self, position: &Self::Position, qd: &[R; N]) -> [R; M];

    /// The change of coordinates that is least in the metric of `Mbar` among those with `C_q dq = -residuals`.
    fn correction(&self, position: &Self::Position, residuals: &[R; M]) -> [R; N];

    /// The accelerations `qdd` and the multipliers; time, coordinates and angles are those of the position.
    fn accelerations(
        &self,
        position: &Self::Position,
        t: R,
        q: &[R; N],
        qd: &[R; N],
        angles: &Angles<R, N>,
    ) -> ([R; N], [R; M]);

    /// The accelerations alone.
    #[inline(always)]
    fn stage_accelerations(
        &self,
        position: &Self::Position,
        t: R,
        q: &[R; N],
        qd: &[R; N],
        angles: &Angles<R, N>,
    ) -> [R; N] {
        self.accelerations(position, t, q, qd, angles).0
    }

    /// The outputs at a position that is known; as far as `outputs` has room.
    #[allow(clippy::too_many_arguments, reason = "a row has these parts")]
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

    /// The power of the loads that have no potential, and of what drives the constraints, in W.
    fn power(&self, t: R, q: &[R; N], qd: &[R; N], qdd: &[R; N], multipliers: &[R; M]) -> R;

    /// A value that rises through zero when the scene's stop condition becomes true; `None` if it has no such
    /// condition.
    fn event(&self, t: R, q: &[R; N], qd: &[R; N], qdd: &[R; N], multipliers: &[R; M]) -> Option<R>;
}

/// The equations of motion of a mechanism with `N` coordinates and `M` constraints, at any position, on numbers `R`.
///
/// All numbers are in SI units, angles in radians.
pub trait Equations<R: Scalar, const N: usize, const M: usize>: Kernel<R, N, M> {
    /// The mechanism with these values of its parameters, in the order of the description.
    fn with_values(value: &dyn Fn(usize) -> R) -> Self;

    /// The start of the motion.
    fn start(&self) -> Start<R, N>;

    /// Step and end of the motion.
    fn schedule(&self) -> Schedule<R>;

    /// The parts of the equations of motion.
    fn dynamics(&self, t: R, q: &[R; N], qd: &[R; N]) -> Dynamics<R, N, M>;

    /// The constraints, their Jacobian and their derivative by time.
    fn loop_constraints(&self, t: R, q: &[R; N]) -> LoopConstraints<R, N, M>;

    /// The reduced mass matrix `Mbar`.
    fn mass_matrix(&self, q: &[R; N]) -> [[R; N]; N];

    /// The kinetic energy, and the potential of the conservative loads, in J.
    fn energy(&self, q: &[R; N], qd: &[R; N]) -> [R; 2];

    /// The outputs, in the order of the description; as far as `outputs` has room.
    fn outputs(&self, t: R, q: &[R; N], qd: &[R; N], qdd: &[R; N], multipliers: &[R; M], outputs: &mut [R]);

    /// The derivatives of the equations of motion by the state; `None` if the scene does not ask for them.
    fn linearization(
        &self,
        _t: R,
        _q: &[R; N],
        _qd: &[R; N],
        _qdd: &[R; N],
        _multipliers: &[R; M],
    ) -> Option<Linearization<R, N, M>> {
        None
    }
}

/// Copies the outputs of a row, as many as there is room for.
// Here and not in generated code: a panic there would hold the path of its file.
#[inline(always)]
pub fn copy_outputs<R: Copy, const K: usize>(values: &[R; K], outputs: &mut [R]) {
    for i in 0..K {
        if let Some(output) = outputs.get_mut(i) {
            *output = values[i];
        }
    }
}

/// The parts of the equations of motion at one state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dynamics<R, const N: usize, const M: usize> {
    /// Mbar, symmetric.
    pub mass_matrix: [[R; N]; N],
    /// fbar.
    pub generalized_forces: [R; N],
    /// C_q, a row for each constraint.
    pub constraint_jacobian: [[R; N]; M],
    /// (C_q qd)_q qd, with `2 C_qt qd + C_tt` where constraints depend on time.
    pub constraint_bias: [R; M],
}

/// The loop constraints at one position and time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LoopConstraints<R, const N: usize, const M: usize> {
    /// C.
    pub residuals: [R; M],
    /// C_q, a row for each constraint.
    pub constraint_jacobian: [[R; N]; M],
    /// C_t, zero unless constraints depend on time.
    pub constraint_rate: [R; M],
}

/// The derivatives of `Mbar qdd + C_q' lambda - fbar = 0` and `C_q qdd + bias = 0`, accelerations and multipliers held.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Linearization<R, const N: usize, const M: usize> {
    /// The first by the coordinates.
    pub stiffness: [[R; N]; N],
    /// The first by the rates.
    pub damping: [[R; N]; N],
    /// The second by the coordinates.
    pub constraint_stiffness: [[R; N]; M],
    /// The second by the rates.
    pub constraint_damping: [[R; N]; M],
    /// `fbar - C_q' lambda` by time.
    pub forcing: [R; N],
    /// `-(C_q qdd + bias)` by time.
    pub constraint_forcing: [R; M],
}

/// The start of a motion: some values are given, the others are first guesses (rates: unused) until they are solved
/// for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Start<R, const N: usize> {
    /// Coordinates.
    pub q: [R; N],
    /// For each coordinate, whether it is given.
    pub given: [bool; N],
    /// Rates.
    pub qd: [R; N],
    /// For each rate, whether it is given.
    pub given_rates: [bool; N],
}

/// Step and end of a run, in seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Schedule<R> {
    /// Step of the integration.
    pub step: R,
    /// The end, or the latest end if there is a stop condition.
    pub end_time: R,
}

/// The growth of rounding errors beyond which a kernel does not suit a position.
pub const MAX_GROWTH: f64 = 1e3;
