//! The evaluation of a tape on any number.

use core::ops::DerefMut;
#[cfg(feature = "std")]
use std::vec::Vec;

use super::{Operation, Tape, TapeFunction};
use crate::{Scalar, Schedule};

/// A mechanism with parameters, evaluated by its [`Tape`] on numbers `R` in a buffer `B`; no call allocates.
///
/// Slices of results have the lengths of the tape's `results`; matrices are stored row by row.
#[derive(Clone, Debug)]
pub struct TapeEvaluator<'t, B> {
    tape: &'t Tape<'t>,
    values: B,
}

#[cfg(feature = "std")]
impl<'t, R: Scalar> TapeEvaluator<'t, Vec<R>> {
    /// The mechanism with the scene's parameters.
    pub fn new(tape: &'t Tape<'t>) -> Self {
        Self::with_buffer(tape, std::vec![R::zero(); tape.places()])
    }
}

impl<'t, R: Scalar, B: DerefMut<Target = [R]>> TapeEvaluator<'t, B> {
    /// The mechanism with the scene's parameters, in a buffer of [`Tape::places`] numbers.
    ///
    /// # Panics
    /// If the buffer is shorter.
    pub fn with_buffer(tape: &'t Tape<'t>, values: B) -> Self {
        assert!(values.len() >= tape.places(), "a tape of {} places needs a larger buffer", tape.places());
        let mut evaluator = Self { tape, values };
        evaluator.set_parameters(|_| None);
        evaluator
    }

    /// The tape.
    pub fn tape(&self) -> &'t Tape<'t> {
        self.tape
    }

    /// Sets the parameters to the scene's values, some of them replaced by their index.
    ///
    /// Parameters that the scene computes from others follow.
    pub fn set_parameters(&mut self, replace: impl Fn(usize) -> Option<R>) {
        let TapeFunction { operations, results } = self.tape.parameters;
        let mut run = Run { values: &mut self.values, next: self.tape.first_free() };
        let mut operations = operations.iter();
        for (i, &result) in results.iter().enumerate() {
            while run.next <= result as usize
                && let Some(operation) = operations.next()
            {
                run.step(operation);
            }
            run.values[i] = replace(i).unwrap_or(run.values[result as usize]);
        }
        let mut run = Run { values: &mut self.values, next: self.tape.first_constant() };
        self.tape.constants.iter().for_each(|operation| run.step(operation));
    }

    /// The values of the parameters.
    pub fn parameters(&self) -> &[R] {
        &self.values[..self.tape.first_argument()]
    }

    /// Mass matrix, generalized forces, constraint Jacobian and constraint bias at a state.
    pub fn dynamics(&mut self, t: R, q: &[R], qd: &[R], results: &mut [R]) {
        self.evaluate(&self.tape.dynamics, t, [q, qd], results);
    }

    /// `C`, `C_q` and `C_t` at a position.
    pub fn loop_constraints(&mut self, t: R, q: &[R], results: &mut [R]) {
        self.evaluate(&self.tape.loop_constraints, t, [q], results);
    }

    /// The mass matrix at a position.
    pub fn mass_matrix(&mut self, q: &[R], results: &mut [R]) {
        self.evaluate(&self.tape.mass_matrix, R::zero(), [q], results);
    }

    /// Kinetic energy and potential, in J.
    pub fn energy(&mut self, q: &[R], qd: &[R]) -> [R; 2] {
        let mut energy = [R::zero(); 2];
        self.evaluate(&self.tape.energy, R::zero(), [q, qd], &mut energy);
        energy
    }

    /// Power of the loads that have no potential, and of what drives the constraints, in W.
    pub fn power(&mut self, t: R, q: &[R], qd: &[R], multipliers: &[R]) -> R {
        let mut power = [R::zero()];
        // Accelerations do not matter to it; those of an earlier call stay where they are.
        self.set_multipliers(multipliers);
        self.evaluate(&self.tape.power, t, [q, qd], &mut power);
        power[0]
    }

    /// The outputs that the scene asks for.
    pub fn outputs(&mut self, t: R, q: &[R], qd: &[R], qdd: &[R], multipliers: &[R], results: &mut [R]) {
        self.set_multipliers(multipliers);
        self.evaluate(&self.tape.outputs, t, [q, qd, qdd], results);
    }

    /// The parts of [`Linearization`](crate::Linearization) in their order; whether the scene asks for them.
    pub fn linearization(&mut self, t: R, q: &[R], qd: &[R], qdd: &[R], multipliers: &[R], results: &mut [R]) -> bool {
        let Some(linearization) = &self.tape.linearization else { return false };
        self.set_multipliers(multipliers);
        self.evaluate(linearization, t, [q, qd, qdd], results);
        true
    }

    /// Rises through zero when the stop condition becomes true; `None` if the scene has none.
    pub fn event(&mut self, t: R, q: &[R], qd: &[R]) -> Option<R> {
        let event = self.tape.event.as_ref()?;
        let mut value = [R::zero()];
        self.evaluate(event, t, [q, qd], &mut value);
        Some(value[0])
    }

    /// Coordinates and rates at the start; [`Tape::given`] says which of them are given.
    pub fn start(&mut self, q: &mut [R], qd: &mut [R]) {
        let (of_q, of_qd) = self.tape.start.results.split_at(q.len());
        self.run(self.tape.start.operations);
        self.read(of_q, q);
        self.read(of_qd, qd);
    }

    /// Step and end of a run, in s.
    pub fn schedule(&mut self) -> Schedule<R> {
        let mut schedule = [R::zero(); 2];
        self.evaluate(&self.tape.schedule, R::zero(), [], &mut schedule);
        Schedule { step: schedule[0], end_time: schedule[1] }
    }

    fn set_multipliers(&mut self, multipliers: &[R]) {
        let first = self.tape.first_constant() - self.tape.constraints as usize;
        self.values[first..][..multipliers.len()].copy_from_slice(multipliers);
    }

    /// The results of a function of time and as many of `q`, `qd`, `qdd` as it has.
    fn evaluate<const K: usize>(&mut self, function: &TapeFunction, t: R, arguments: [&[R]; K], results: &mut [R]) {
        let (first, n) = (self.tape.first_argument(), self.tape.coordinates as usize);
        self.values[first] = t;
        for (k, argument) in arguments.into_iter().enumerate() {
            self.values[first + 1 + k * n..][..n].copy_from_slice(argument);
        }
        self.run(function.operations);
        self.read(function.results, results);
    }

    fn run(&mut self, operations: &[Operation]) {
        let mut run = Run { values: &mut self.values, next: self.tape.first_free() };
        operations.iter().for_each(|operation| run.step(operation));
    }

    fn read(&self, places: &[u32], results: &mut [R]) {
        assert_eq!(places.len(), results.len(), "room for all results");
        for (result, &place) in results.iter_mut().zip(places) {
            *result = self.values[place as usize];
        }
    }
}

/// Operations being executed, and the place of the next result.
struct Run<'v, R> {
    values: &'v mut [R],
    next: usize,
}

impl<R: Scalar> Run<'_, R> {
    #[inline(always)]
    fn step(&mut self, operation: &Operation) {
        use Operation as Op;
        let at = |place: u32| self.values[place as usize];
        let value = match *operation {
            Op::Number(number) => R::from_f64(number),
            Op::Pi => R::pi(),
            Op::Neg(a) => -at(a),
            Op::Add(a, b) => at(a) + at(b),
            Op::Sub(a, b) => at(a) - at(b),
            Op::Mul(a, b) => at(a) * at(b),
            Op::Div(a, b) => at(a) / at(b),
            Op::Recip(a) => at(a).recip(),
            Op::Sqrt(a) => at(a).sqrt(),
            Op::Sin(a) => at(a).sin(),
            Op::Cos(a) => at(a).cos(),
            Op::SinCos(a) => {
                let (sine, cosine) = at(a).sin_cos();
                self.values[self.next] = sine;
                self.next += 1;
                cosine
            }
            Op::Tan(a) => at(a).tan(),
            Op::Asin(a) => at(a).asin(),
            Op::Acos(a) => at(a).acos(),
            Op::Atan(a) => at(a).atan(),
            Op::Exp(a) => at(a).exp(),
            Op::Ln(a) => at(a).ln(),
            Op::Sinh(a) => at(a).sinh(),
            Op::Cosh(a) => at(a).cosh(),
            Op::Tanh(a) => at(a).tanh(),
            Op::Abs(a) => at(a).abs(),
            Op::Sign(a) => at(a).sign(),
            Op::Min(a, b) => at(a).min(at(b)),
            Op::Max(a, b) => at(a).max(at(b)),
            Op::Hypot(a, b) => at(a).hypot(at(b)),
            Op::Atan2(a, b) => at(a).atan2(at(b)),
            Op::PowI(a, exponent) => at(a).powi(exponent),
            Op::PowF(a, exponent) => at(a).powf(exponent),
            Op::Pow(a, b) => at(a).pow(at(b)),
        };
        self.values[self.next] = value;
        self.next += 1;
    }
}
