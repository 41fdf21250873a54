//! The generated equations of motion, with sizes known at compile time.

use crate::angles::Angles;
use crate::scalar::Scalar;

/// The equations of motion of a mechanism with `N` coordinates and `M` constraints, as far as steps need them, on
/// numbers `R`. The kernel holds the parameters.
///
/// Quantities that follow from the position are computed once and serve both accelerations and corrections. The
/// constraints `C_q qdd + bias = 0` are solved for `M` dependent coordinates; the motion of the others follows from
/// `T' (Mbar qdd - fbar) = 0` with the tangents `T`, `C_q T = 0`.
///
/// All numbers are in SI units, angles in radians.
pub trait Kernel<R: Scalar, const N: usize, const M: usize> {
    /// The quantities that follow from the position. A value stays usable until the second call of
    /// [`position`](Self::position) after the one that returned it.
    type Position: Copy;

    /// The number of operations for accelerations and multipliers. Large kernels are compiled into fewer places.
    const OPERATIONS: usize;

    /// The numbers of coordinates and of constraints. If they are smaller than `N` and `M`, the remaining entries are
    /// zero.
    #[inline(always)]
    fn sizes(&self) -> [usize; 2] {
        [N, M]
    }

    /// Whether the sine or cosine of each coordinate is needed.
    fn has_angle(&self) -> [bool; N];

    /// Whether each coordinate is a length instead of an angle.
    fn is_length(&self) -> [bool; N];

    /// Sets the values of the parameters, in the order of the description.
    fn set_values(&mut self, value: &dyn Fn(usize) -> R);

    /// Calls a function that is never inlined, with the target features of `R`.
    ///
    /// This is a method of the mechanism, so that rustc compiles it in the codegen unit of the mechanism's module. A
    /// free function would be recompiled for all mechanisms whenever one of them changes.
    #[inline(never)]
    fn call_out_of_line<T>(f: impl FnOnce() -> T) -> T {
        R::vectorized(f)
    }

    /// Computes the quantities that follow from the position `q` at time `t`.
    fn position(&self, t: R, q: &[R; N], angles: &Angles<R, N>) -> Self::Position;

    /// The residuals of the constraints, `C(q, t)`.
    fn residuals(&self, position: &Self::Position) -> [R; M];

    /// The growth of rounding errors when the constraints are solved for the dependent coordinates. Where it is large,
    /// the choice of dependent coordinates is not valid at the position.
    fn growth_factor(&self, position: &Self::Position) -> R;

    /// The rates of the residuals, `C_q qd + C_t`.
    fn velocity_residual(&self, position: &Self::Position, qd: &[R; N]) -> [R; M];

    /// The smallest change of coordinates, in the metric of `Mbar`, with `C_q dq = -residuals`.
    fn correction(&self, position: &Self::Position, residuals: &[R; M]) -> [R; N];

    /// Computes the accelerations `qdd` and the multipliers; time, coordinates and angles are those of the position.
    fn accelerations(
        &self,
        position: &Self::Position,
        t: R,
        q: &[R; N],
        qd: &[R; N],
        angles: &Angles<R, N>,
    ) -> ([R; N], [R; M]);

    /// Computes the accelerations alone.
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

    /// Computes the outputs at a known position, as many as fit into `outputs`.
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

    /// The power, in W, of the loads without a potential and of the driven constraints.
    fn power(&self, t: R, q: &[R; N], qd: &[R; N], qdd: &[R; N], multipliers: &[R; M]) -> R;

    /// A value that rises through zero when the scene's stop condition becomes true; `None` if there is no such
    /// condition.
    fn event(&self, t: R, q: &[R; N], qd: &[R; N], qdd: &[R; N], multipliers: &[R; M]) -> Option<R>;
}

/// The complete equations of motion of a mechanism with `N` coordinates and `M` constraints, on numbers `R`; valid at
/// any position.
///
/// All numbers are in SI units, angles in radians.
pub trait Equations<R: Scalar, const N: usize, const M: usize>: Kernel<R, N, M> {
    /// Creates the mechanism with these values of its parameters, in the order of the description.
    fn with_values(value: &dyn Fn(usize) -> R) -> Self;

    /// The start of the motion.
    fn start(&self) -> Start<R, N>;

    /// The step length and the end of the motion.
    fn schedule(&self) -> Schedule<R>;

    /// The parts of the equations of motion.
    fn dynamics(&self, t: R, q: &[R; N], qd: &[R; N]) -> Dynamics<R, N, M>;

    /// The constraints, their Jacobian and their derivative with respect to time.
    fn loop_constraints(&self, t: R, q: &[R; N]) -> LoopConstraints<R, N, M>;

    /// The reduced mass matrix `Mbar`.
    fn mass_matrix(&self, q: &[R; N]) -> [[R; N]; N];

    /// The kinetic energy and the potential of the conservative loads, in J.
    fn energy(&self, q: &[R; N], qd: &[R; N]) -> [R; 2];

    /// Computes the outputs in the order of the description, as many as fit into `outputs`.
    fn outputs(&self, t: R, q: &[R; N], qd: &[R; N], qdd: &[R; N], multipliers: &[R; M], outputs: &mut [R]);

    /// The derivatives of the equations of motion with respect to the state; `None` if the scene does not ask for them.
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

/// The symmetric matrix `Mbar` whose products with rates are the momenta. Only entries on and below the diagonal are
/// computed.
pub fn mass_matrix_from_momenta<R: Scalar, const N: usize>(momenta: impl Fn(&[R; N]) -> [R; N]) -> [[R; N]; N] {
    let mut mass_matrix = [[R::zero(); N]; N];
    let mut rates = [R::zero(); N];
    for j in 0..N {
        rates[j] = R::from_f64(1.0);
        let column = momenta(&rates);
        rates[j] = R::zero();
        for i in j..N {
            (mass_matrix[i][j], mass_matrix[j][i]) = (column[i], column[i]);
        }
    }
    mass_matrix
}

/// Copies the outputs of a row, as many as fit.
// Here and not in generated code: a panic there would contain the path of its file.
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
    /// `(C_q qd)_q qd`, plus `2 C_qt qd + C_tt` where constraints depend on time.
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

/// The derivatives of `Mbar qdd + C_q' lambda - fbar = 0` and `C_q qdd + bias = 0`, with accelerations and multipliers
/// held constant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Linearization<R, const N: usize, const M: usize> {
    /// The first equation differentiated with respect to the coordinates.
    pub stiffness: [[R; N]; N],
    /// The first equation differentiated with respect to the rates.
    pub damping: [[R; N]; N],
    /// The second equation differentiated with respect to the coordinates.
    pub constraint_stiffness: [[R; N]; M],
    /// The second equation differentiated with respect to the rates.
    pub constraint_damping: [[R; N]; M],
    /// `fbar - C_q' lambda` differentiated with respect to time.
    pub forcing: [R; N],
    /// `-(C_q qdd + bias)` differentiated with respect to time.
    pub constraint_forcing: [R; M],
}

/// The start of a motion. Some values are given; the others are first guesses (unused for rates) until they are solved
/// for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Start<R, const N: usize> {
    /// Coordinates.
    pub q: [R; N],
    /// Whether each coordinate is given.
    pub given: [bool; N],
    /// Rates.
    pub qd: [R; N],
    /// Whether each rate is given.
    pub given_rates: [bool; N],
}

/// Step length and end of a run, in seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Schedule<R> {
    /// Step of the integration.
    pub step: R,
    /// The end, or the latest end if there is a stop condition.
    pub end_time: R,
}

/// The growth of rounding errors above which a kernel is not valid at a position.
pub const MAX_GROWTH: f64 = 1e3;
