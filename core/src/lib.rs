//! What the equations of motion of a mechanism look like to a simulator.
//!
//! Generated code implements [`Mechanism`]; a simulator is written against it. Both depend on this crate and not on
//! each other, so that a changed length recompiles the generated code alone.
//!
//! With `q` the generalized coordinates (`N` of them) and `C(q) = 0` the loop closures (`M` of them):
//!
//! ```text
//! | Mbar  C_q' | | qdd    |   | fbar           |
//! | C_q   0    | | lambda | = | -(C_q qd)_q qd |
//! ```
//!
//! Closures may depend on time, `C(q, t) = 0`: then `C_q qd + C_t = 0`, and `(C_q qd)_q qd + 2 C_qt qd + C_tt` takes the place
//! of `(C_q qd)_q qd`.

#![no_std]

#[cfg(feature = "std")]
extern crate std;

#[cfg(not(any(feature = "std", feature = "libm")))]
compile_error!("qrm-core needs one of its features: `std`, or `libm` where there is no standard library");

mod angles;
mod description;
#[cfg(feature = "dual")]
mod dual;
mod kernel;
mod math;
mod plain;
mod scalar;
mod sine;
mod stride;

pub use angles::Angles;
pub use description::{Description, ParameterDescription, QuantityDescription};
#[cfg(feature = "dual")]
pub use dual::{Dual, Kind};
pub use kernel::{Kernel, MOST_STRAIN, NoKernel, accelerations};
pub use plain::Plain;
pub use scalar::{Fused, Scalar};
pub use sine::sin_cos;
pub use stride::{LARGE, State, Stride, stride};

/// The equations of motion of one mechanism with `N` coordinates and `M` constraints, its parameters inside.
///
/// All numbers are in SI units, angles in radians.
pub trait Mechanism<const N: usize, const M: usize>: Sized {
    /// The same equations in the order a step needs them, for any kind of number.
    type Kernel<R: Scalar>: Kernel<R, N, M>;

    /// Names, units and meanings.
    const DESCRIPTION: Description;

    /// The mechanism with the scene's parameters, some of them replaced; parameters that the scene computes from
    /// others follow.
    fn with_parameters(replace: &dyn Fn(&str) -> Option<f64>) -> Self;

    /// The values of the parameters, in the order of [`Description::parameters`].
    fn visit_parameters(&self, visit: &mut dyn FnMut(f64));

    /// The start that the scene asks for.
    fn start(&self) -> Start<f64, N>;

    /// The motion on another kind of number, some parameters replaced: dual numbers give derivatives by parameters.
    /// `None` for a mechanism that is not described by formulae of its parameters.
    fn with_numbers<R: Scalar>(_replace: &dyn Fn(&str) -> Option<R>) -> Option<Problem<Self::Kernel<R>, R, N>> {
        None
    }

    /// Step and end that the scene asks for, in seconds.
    fn schedule(&self) -> Schedule<f64>;

    /// Rises through zero when the scene's stop condition becomes true; `None` if it has none.
    fn stop(&self, t: f64, q: &[f64; N], qd: &[f64; N]) -> Option<f64>;

    /// All that the accelerations need.
    fn dynamics(&self, t: f64, q: &[f64; N], qd: &[f64; N]) -> Dynamics<f64, N, M>;

    /// `qdd` and the multipliers by the kernel; `None` where that is not to be relied on.
    fn accelerations(&self, _t: f64, _q: &[f64; N], _qd: &[f64; N]) -> Option<([f64; N], [f64; M])> {
        None
    }

    /// Whether there is a [`linearization`](Self::linearization).
    const HAS_LINEARIZATION: bool = false;

    /// How the equations of motion change with the state; `None` if the scene does not ask for it.
    fn linearization(
        &self,
        _t: f64,
        _q: &[f64; N],
        _qd: &[f64; N],
        _qdd: &[f64; N],
        _multipliers: &[f64; M],
    ) -> Option<Linearization<f64, N, M>> {
        None
    }

    /// Whether closures depend on time.
    const IS_DRIVEN: bool = false;

    /// All that a correction of positions and rates needs.
    fn closure(&self, t: f64, q: &[f64; N]) -> Closure<f64, N, M>;

    /// Mbar.
    fn mass_matrix(&self, q: &[f64; N]) -> [[f64; N]; N];

    /// Kinetic energy, and the potential of the conservative loads, in joule.
    fn energy(&self, q: &[f64; N], qd: &[f64; N]) -> [f64; 2];

    /// Power of the loads that have no potential, and of what drives the closures, in watt.
    fn power(&self, t: f64, q: &[f64; N], qd: &[f64; N], multipliers: &[f64; M]) -> f64;

    /// The outputs that the scene asks for, in the order of [`Description::outputs`], as far as `outputs` has room.
    fn outputs(&self, t: f64, q: &[f64; N], qd: &[f64; N], qdd: &[f64; N], multipliers: &[f64; M], outputs: &mut [f64]);
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
    /// (C_q qd)_q qd, with what time adds to it.
    pub constraint_bias: [R; M],
}

/// Derivatives of what accelerations and multipliers fulfil, with both of them held:
/// `Mbar qdd + C_q' lambda - fbar = 0` and `C_q qdd + (C_q qd)_q qd = 0`.
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

/// The loop closures at one position and time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Closure<R, const N: usize, const M: usize> {
    /// C.
    pub constraints: [R; M],
    /// C_q, a row for each constraint.
    pub constraint_jacobian: [[R; N]; M],
    /// C_t, zeros unless they depend on time.
    pub constraint_rate: [R; M],
}

impl<const N: usize, const M: usize> Closure<f64, N, M> {
    /// How fast the residuals change: `C_q qd + C_t`.
    #[inline(always)]
    pub fn drift(&self, qd: &[f64; N]) -> [f64; M] {
        let along = |row: &[f64; N]| row.iter().zip(qd).map(|(entry, v)| entry * v).sum::<f64>();
        core::array::from_fn(|k| along(&self.constraint_jacobian[k]) + self.constraint_rate[k])
    }
}

/// Where a motion starts: some values are given, the others are first guesses (rates: unused) until they are solved for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Start<R, const N: usize> {
    /// Coordinates.
    pub q: [R; N],
    /// Which of them are given.
    pub given: [bool; N],
    /// Rates.
    pub qd: [R; N],
    /// Which of them are given.
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

/// A motion that is to be found: by which equations, from where, how far.
#[derive(Clone, Copy, Debug)]
pub struct Problem<K, R, const N: usize> {
    /// The equations.
    pub kernel: K,
    /// Where it starts.
    pub start: Start<R, N>,
    /// How far it goes.
    pub schedule: Schedule<R>,
}

/// Something that is done with each of several mechanisms, whatever their sizes.
pub trait Visitor {
    /// Does it with `X`.
    fn visit<X: Mechanism<N, M> + Clone + Send + 'static, const N: usize, const M: usize>(&mut self);
}
