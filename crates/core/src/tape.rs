//! The functions of a mechanism as data: operations on numbered places.

mod evaluator;
mod event;
mod execute;
mod full_dynamics;
mod node;
mod nodes;
mod operation;
mod series;
mod smooth;

use std::borrow::Cow;

use operation::places;

pub use evaluator::TapeEvaluator;
pub use execute::execute;
pub use operation::Operation;
pub use series::{Obstacle, TapeSeries};

/// The functions of a mechanism with `n` coordinates and `m` constraints, as operations on any number.
///
/// Values have places: parameters come first, then the arguments: `t`, `q`, `qd`, `qdd` (`n` each) and the multipliers
/// (`m`), then sines and cosines of `q` (`n` each) and residuals (`m`) for the kernel. The constants come next. The
/// values of each function follow, in the same places for all functions; those of the kernel stand one after another.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Tape {
    /// The number of coordinates, `n`.
    pub coordinates: u32,
    /// The number of constraints, `m`.
    pub constraints: u32,
    /// Whether constraints depend on time.
    pub is_driven: bool,
    /// The values of the parameters, in the order of the description. A parameter follows from those before it, by the
    /// operations up to its result.
    pub parameters: TapeFunction,
    /// Values that depend on parameters alone, and numbers.
    pub constants: Cow<'static, [Operation]>,
    /// Mass matrix (`n` by `n`), generalized forces (`n`), constraint Jacobian (`m` by `n`) and constraint bias (`m`);
    /// without the mass matrix if there are `momenta`.
    pub dynamics: TapeFunction,
    /// `C` (`m`), `C_q` (`m` by `n`) and `C_t` (`m`).
    pub loop_constraints: TapeFunction,
    /// The mass matrix (`n` by `n`); empty if there are `momenta`.
    pub mass_matrix: TapeFunction,
    /// The generalized momenta `Mbar qd` (`n`) of a large tree: unit rates give the columns of its mass matrix.
    pub momenta: Option<TapeFunction>,
    /// Kinetic energy and potential, in J.
    pub energy: TapeFunction,
    /// Power of the loads that have no potential, and of what drives the constraints, in W.
    pub power: TapeFunction,
    /// The outputs that the scene asks for.
    pub outputs: TapeFunction,
    /// The parts of [`Linearization`](crate::Linearization) in their order; `None` if the scene does not ask for them.
    pub linearization: Option<TapeFunction>,
    /// One value that rises through zero when the stop condition becomes true; `None` if the scene has none.
    pub event: Option<TapeFunction>,
    /// The switching functions: where one of them is zero, the equations of motion have a corner or a jump.
    pub switching_functions: TapeFunction,
    /// The number of switching functions of the form `a + b t` with constants `a` and `b`, which come first.
    pub linear_in_time: u32,
    /// The arguments of hyperbolic tangents in the equations of motion: these change within a few units around zero.
    pub tanh_arguments: TapeFunction,
    /// Coordinates and rates at the start (`n` each); those that are not given are first guesses.
    pub start: TapeFunction,
    /// For each coordinate, then for each rate, whether it is given (`n` each).
    pub given: Cow<'static, [bool]>,
    /// Step and end time, in s.
    pub schedule: TapeFunction,
    /// The functions that steps need: see [`Kernel`](crate::Kernel).
    pub kernel: TapeKernel,
}

/// The functions of a kernel. Those that take a position need its values in their places.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct TapeKernel {
    /// The number of operations of accelerations and multipliers.
    pub operations: usize,
    /// For each coordinate, whether its sine or cosine is needed (`n`).
    pub has_angle: Cow<'static, [bool]>,
    /// The values that follow from the position: the growth factor, and the residuals (`m`).
    pub position: TapeFunction,
    /// `C_q qd + C_t` (`m`).
    pub velocity_residual: TapeFunction,
    /// The correction (`n`) for given residuals.
    pub correction: TapeFunction,
    /// Accelerations (`n`).
    pub accelerations: TapeFunction,
    /// Multipliers (`m`), directly after accelerations.
    pub multipliers: TapeFunction,
    /// Outputs.
    pub outputs: TapeFunction,
}

/// Operations, and the places of their results; matrices row by row.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct TapeFunction {
    /// The operations in their order.
    pub operations: Cow<'static, [Operation]>,
    /// The places of the results.
    pub results: Cow<'static, [u32]>,
}

impl Tape {
    /// The number of values that an evaluator holds.
    pub fn places(&self) -> usize {
        let longest = self.functions().map(|function| places(&function.operations)).max();
        let kernel: usize = self.kernel.functions().iter().map(|function| places(&function.operations)).sum();
        self.arguments().end + longest.unwrap_or(0).max(kernel)
    }

    /// Every function but those of the kernel.
    pub fn functions(&self) -> impl Iterator<Item = &TapeFunction> {
        let dynamics = [&self.dynamics, &self.loop_constraints, &self.mass_matrix];
        let rows = [&self.energy, &self.power, &self.outputs];
        let run = [&self.parameters, &self.start, &self.schedule, &self.switching_functions, &self.tanh_arguments];
        let optional = [&self.momenta, &self.linearization, &self.event];
        dynamics.into_iter().chain(rows).chain(run).chain(optional.into_iter().flatten())
    }

    /// The number of results of [`TapeEvaluator::dynamics`].
    pub fn dynamics_length(&self) -> usize {
        let [n, m] = self.sizes();
        n * n + n + m * n + m
    }

    /// Mass matrix, generalized forces, constraint Jacobian and constraint bias in the results of
    /// [`TapeEvaluator::dynamics`].
    pub fn split_dynamics<'r, R>(&self, results: &'r [R]) -> [&'r [R]; 4] {
        let [n, m] = self.sizes();
        split(results, [n * n, n, m * n, m])
    }

    /// `C`, `C_q` and `C_t` in the results of `loop_constraints`.
    pub fn split_loop_constraints<'r, R>(&self, results: &'r [R]) -> [&'r [R]; 3] {
        let [n, m] = self.sizes();
        split(results, [m, m * n, m])
    }

    /// The parts of [`Linearization`](crate::Linearization) in the results of `linearization`.
    pub fn split_linearization<'r, R>(&self, results: &'r [R]) -> [&'r [R]; 6] {
        let [n, m] = self.sizes();
        split(results, [n * n, n * n, m * n, m * n, n, m])
    }

    /// The numbers of coordinates and of constraints.
    pub(crate) fn sizes(&self) -> [usize; 2] {
        [self.coordinates as usize, self.constraints as usize]
    }

    /// The place of the first value of each function of the kernel.
    #[cfg(feature = "simd")]
    pub(crate) fn kernel_places(&self) -> [usize; TapeKernel::FUNCTIONS] {
        let mut next = self.arguments().end;
        self.kernel.functions().map(|function| {
            let first = next;
            next += places(&function.operations);
            first
        })
    }

    /// The places of the arguments.
    pub(crate) fn arguments(&self) -> Arguments {
        let [n, m] = self.sizes();
        let t = self.parameters.results.len();
        let [q, qd, qdd, multipliers] = [0, 1, 2, 3].map(|k| t + 1 + k * n);
        let sin = multipliers + m;
        let (cos, residuals) = (sin + n, sin + 2 * n);
        let constants = residuals + m;
        let end = constants + places(&self.constants);
        Arguments { t, q, qd, qdd, multipliers, sin, cos, residuals, constants, end }
    }
}

/// The places of arguments, and of what follows them.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(not(feature = "simd"), allow(dead_code))]
pub(crate) struct Arguments {
    pub(crate) t: usize,
    pub(crate) q: usize,
    pub(crate) qd: usize,
    pub(crate) qdd: usize,
    pub(crate) multipliers: usize,
    pub(crate) sin: usize,
    pub(crate) cos: usize,
    pub(crate) residuals: usize,
    pub(crate) constants: usize,
    /// The first value of a function.
    pub(crate) end: usize,
}

impl TapeFunction {
    /// A function without operations and results.
    pub const NONE: Self = Self::new(&[], &[]);

    /// A function of constant operations and results.
    pub const fn new(operations: &'static [Operation], results: &'static [u32]) -> Self {
        Self { operations: Cow::Borrowed(operations), results: Cow::Borrowed(results) }
    }
}

impl TapeKernel {
    /// A kernel without functions: for tapes that steps do not use.
    pub const NONE: Self = Self {
        operations: 0,
        has_angle: Cow::Borrowed(&[]),
        position: TapeFunction::NONE,
        velocity_residual: TapeFunction::NONE,
        correction: TapeFunction::NONE,
        accelerations: TapeFunction::NONE,
        multipliers: TapeFunction::NONE,
        outputs: TapeFunction::NONE,
    };

    pub(crate) const FUNCTIONS: usize = 6;

    /// Every function, in the order of the places of their values.
    pub fn functions(&self) -> [&TapeFunction; Self::FUNCTIONS] {
        let Self { position, velocity_residual, correction, accelerations, multipliers, outputs, .. } = self;
        [position, velocity_residual, correction, accelerations, multipliers, outputs]
    }
}

/// Consecutive parts of these lengths.
pub(crate) fn split<R, const N: usize>(mut values: &[R], lengths: [usize; N]) -> [&[R]; N] {
    lengths.map(|length| {
        let (part, rest) = values.split_at(length);
        values = rest;
        part
    })
}
