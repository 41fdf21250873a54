//! The functions of a mechanism as data: operations on numbered places.

mod evaluator;

pub use evaluator::TapeEvaluator;

/// One operation on values; operands are places that hold a value already.
///
/// The result has the next free place. [`SinCos`](Self::SinCos) has two results: the sine, then the cosine.
#[derive(Clone, Copy, Debug, PartialEq)]
#[allow(missing_docs, reason = "the names say what they compute")]
pub enum Operation {
    Number(f64),
    Pi,
    Neg(u32),
    Add(u32, u32),
    Sub(u32, u32),
    Mul(u32, u32),
    Div(u32, u32),
    Recip(u32),
    Sqrt(u32),
    Sin(u32),
    Cos(u32),
    SinCos(u32),
    Tan(u32),
    Asin(u32),
    Acos(u32),
    Atan(u32),
    Exp(u32),
    Ln(u32),
    Sinh(u32),
    Cosh(u32),
    Tanh(u32),
    Abs(u32),
    Sign(u32),
    Min(u32, u32),
    Max(u32, u32),
    Hypot(u32, u32),
    Atan2(u32, u32),
    /// A whole power.
    PowI(u32, i32),
    /// A power with a fixed exponent.
    PowF(u32, f64),
    /// A power with any exponent.
    Pow(u32, u32),
}

/// The functions of a mechanism with `n` coordinates and `m` constraints, as operations on any number.
///
/// Values have places: parameters come first, then the arguments `t`, `q`, `qd`, `qdd` (`n` each) and the multipliers
/// (`m`), then the constants. The values of each function follow, in the same places for all functions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tape<'a> {
    /// The number of coordinates, `n`.
    pub coordinates: u32,
    /// The number of constraints, `m`.
    pub constraints: u32,
    /// The values of the parameters, in the order of the description. A parameter follows from those before it, by the
    /// operations up to its result.
    pub parameters: TapeFunction<'a>,
    /// Values that depend on parameters alone.
    pub constants: &'a [Operation],
    /// Mass matrix (`n` by `n`), generalized forces (`n`), constraint Jacobian (`m` by `n`) and constraint bias (`m`).
    pub dynamics: TapeFunction<'a>,
    /// `C` (`m`), `C_q` (`m` by `n`) and `C_t` (`m`).
    pub loop_constraints: TapeFunction<'a>,
    /// The mass matrix (`n` by `n`).
    pub mass_matrix: TapeFunction<'a>,
    /// Kinetic energy and potential, in J.
    pub energy: TapeFunction<'a>,
    /// Power of the loads that have no potential, and of what drives the constraints, in W.
    pub power: TapeFunction<'a>,
    /// The outputs that the scene asks for.
    pub outputs: TapeFunction<'a>,
    /// The parts of [`Linearization`](crate::Linearization) in their order; `None` if the scene does not ask for them.
    pub linearization: Option<TapeFunction<'a>>,
    /// One value that rises through zero when the stop condition becomes true; `None` if the scene has none.
    pub event: Option<TapeFunction<'a>>,
    /// Coordinates and rates at the start (`n` each); those that are not given are first guesses.
    pub start: TapeFunction<'a>,
    /// Which coordinates and rates are given (`n` each).
    pub given: &'a [bool],
    /// Step and end time, in s.
    pub schedule: TapeFunction<'a>,
}

/// Operations, and the places of their results; matrices row by row.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TapeFunction<'a> {
    /// The operations in their order.
    pub operations: &'a [Operation],
    /// The places of the results.
    pub results: &'a [u32],
}

impl<'a> Tape<'a> {
    /// The number of values that an evaluator holds.
    pub fn places(&self) -> usize {
        let longest = self.functions().map(|function| places(function.operations)).max();
        self.first_free() + longest.unwrap_or(0)
    }

    /// Every function.
    pub fn functions(&self) -> impl Iterator<Item = TapeFunction<'a>> {
        let dynamics = [self.dynamics, self.loop_constraints, self.mass_matrix];
        let rows = [self.energy, self.power, self.outputs];
        let run = [self.parameters, self.start, self.schedule];
        [dynamics, rows, run].into_iter().flatten().chain(self.linearization).chain(self.event)
    }

    /// Mass matrix, generalized forces, constraint Jacobian and constraint bias in the results of `dynamics`.
    pub fn split_dynamics<'r, R>(&self, results: &'r [R]) -> [&'r [R]; 4] {
        let (n, m) = self.sizes();
        split(results, [n * n, n, m * n, m])
    }

    /// `C`, `C_q` and `C_t` in the results of `loop_constraints`.
    pub fn split_loop_constraints<'r, R>(&self, results: &'r [R]) -> [&'r [R]; 3] {
        let (n, m) = self.sizes();
        split(results, [m, m * n, m])
    }

    /// The parts of [`Linearization`](crate::Linearization) in the results of `linearization`.
    pub fn split_linearization<'r, R>(&self, results: &'r [R]) -> [&'r [R]; 6] {
        let (n, m) = self.sizes();
        split(results, [n * n, n * n, m * n, m * n, n, m])
    }

    fn sizes(&self) -> (usize, usize) {
        (self.coordinates as usize, self.constraints as usize)
    }

    /// The place of time, after the parameters.
    fn first_argument(&self) -> usize {
        self.parameters.results.len()
    }

    /// The place of the first constant.
    fn first_constant(&self) -> usize {
        let (n, m) = self.sizes();
        self.first_argument() + 1 + 3 * n + m
    }

    /// The place of the first value of a function.
    fn first_free(&self) -> usize {
        self.first_constant() + places(self.constants)
    }
}

/// How many places the results of operations take.
fn places(operations: &[Operation]) -> usize {
    let pairs = operations.iter().filter(|operation| matches!(operation, Operation::SinCos(_)));
    operations.len() + pairs.count()
}

/// Consecutive parts of these lengths.
fn split<R, const N: usize>(mut values: &[R], lengths: [usize; N]) -> [&[R]; N] {
    lengths.map(|length| {
        let (part, rest) = values.split_at(length);
        values = rest;
        part
    })
}
