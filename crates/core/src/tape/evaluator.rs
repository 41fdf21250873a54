//! The evaluation of a tape on any number.

use core::ops::DerefMut;
use std::vec::Vec;

use super::{Arguments, Operation, Tape, TapeFunction, execute};
use crate::{Scalar, Schedule};

/// A mechanism with parameters, evaluated by its [`Tape`] on numbers `R` in a buffer `B`; no call allocates.
///
/// Slices of results have the lengths of the tape's `results`, for `dynamics` [`Tape::dynamics_length`]; matrices are
/// stored row by row.
#[derive(Clone, Debug)]
pub struct TapeEvaluator<'t, B> {
    pub(super) tape: &'t Tape,
    places: Arguments,
    pub(super) values: B,
}

impl<'t, R: Scalar> TapeEvaluator<'t, Vec<R>> {
    /// The mechanism with the scene's parameters.
    pub fn new(tape: &'t Tape) -> Self {
        Self::with_buffer(tape, std::vec![R::zero(); tape.places()])
    }

    /// The mechanism with these values of all parameters.
    pub fn with_parameters(tape: &'t Tape, parameters: &[f64]) -> Self {
        let mut evaluator = Self::new(tape);
        evaluator.set_parameters(|i| Some(R::from_f64(parameters[i])));
        evaluator
    }
}

impl<'t, R: Scalar, B: DerefMut<Target = [R]>> TapeEvaluator<'t, B> {
    /// The mechanism with the scene's parameters, in a buffer of [`Tape::places`] numbers.
    ///
    /// # Panics
    /// If the buffer is shorter.
    pub fn with_buffer(tape: &'t Tape, values: B) -> Self {
        assert!(values.len() >= tape.places(), "a tape of {} places needs a larger buffer", tape.places());
        let mut evaluator = Self { tape, places: tape.arguments(), values };
        evaluator.set_parameters(|_| None);
        evaluator
    }

    /// The tape.
    pub fn tape(&self) -> &'t Tape {
        self.tape
    }

    /// Sets the parameters to the scene's values, some of them replaced by their index.
    ///
    /// Parameters that the scene computes from others follow.
    pub fn set_parameters(&mut self, replace: impl Fn(usize) -> Option<R>) {
        let TapeFunction { operations, results } = &self.tape.parameters;
        let (mut next, mut rest) = (self.places.end, &operations[..]);
        for (i, &result) in results.iter().enumerate() {
            while next <= result as usize
                && let Some((operation, others)) = rest.split_first()
            {
                next = execute(&mut self.values, next, core::slice::from_ref(operation));
                rest = others;
            }
            self.values[i] = replace(i).unwrap_or(self.values[result as usize]);
        }
        execute(&mut self.values, self.places.constants, &self.tape.constants);
    }

    /// The values of the parameters.
    pub fn parameters(&self) -> &[R] {
        &self.values[..self.places.t]
    }

    /// Mass matrix, generalized forces, constraint Jacobian and constraint bias at a state.
    pub fn dynamics(&mut self, t: R, q: &[R], qd: &[R], results: &mut [R]) {
        let of_momenta = if self.tape.momenta.is_some() { q.len() * q.len() } else { 0 };
        let (mass_matrix, others) = results.split_at_mut(of_momenta);
        if of_momenta > 0 {
            self.mass_matrix(q, mass_matrix);
        }
        self.evaluate(&self.tape.dynamics, t, [q, qd], others);
    }

    /// `C`, `C_q` and `C_t` at a position.
    pub fn loop_constraints(&mut self, t: R, q: &[R], results: &mut [R]) {
        self.evaluate(&self.tape.loop_constraints, t, [q], results);
    }

    /// The mass matrix at a position.
    pub fn mass_matrix(&mut self, q: &[R], results: &mut [R]) {
        let Some(momenta) = &self.tape.momenta else {
            return self.evaluate(&self.tape.mass_matrix, R::zero(), [q], results);
        };
        let (n, first) = (q.len(), self.places.qd);
        self.values[first..][..n].fill(R::zero());
        for j in 0..n {
            self.values[first + j] = R::from_f64(1.0);
            self.evaluate_at(R::zero(), [q], &momenta.operations);
            // The momentum of a unit mass is the rate itself.
            for (i, &place) in momenta.results.iter().enumerate().skip(j) {
                let entry = self.values[place as usize];
                (results[i * n + j], results[j * n + i]) = (entry, entry);
            }
            self.values[first + j] = R::zero();
        }
    }

    /// The generalized momenta `Mbar qd` of a large tree; `false` for other mechanisms.
    pub fn momenta(&mut self, q: &[R], qd: &[R], results: &mut [R]) -> bool {
        let Some(momenta) = &self.tape.momenta else { return false };
        self.evaluate(momenta, R::zero(), [q, qd], results);
        true
    }

    /// The generalized forces of a large tree; `false` for other mechanisms.
    pub fn generalized_forces(&mut self, t: R, q: &[R], qd: &[R], results: &mut [R]) -> bool {
        if self.tape.momenta.is_none() {
            return false;
        }
        self.evaluate(&self.tape.dynamics, t, [q, qd], results);
        true
    }

    /// Kinetic energy and potential, in J.
    pub fn energy(&mut self, q: &[R], qd: &[R]) -> [R; 2] {
        let mut energy = [R::zero(); 2];
        self.evaluate(&self.tape.energy, R::zero(), [q, qd], &mut energy);
        energy
    }

    /// Power of the loads that have no potential, and of what drives the constraints, in W.
    pub fn power(&mut self, t: R, q: &[R], qd: &[R], qdd: &[R], multipliers: &[R]) -> R {
        let mut power = [R::zero()];
        self.set_multipliers(multipliers);
        self.evaluate(&self.tape.power, t, [q, qd, qdd], &mut power);
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
    pub fn event(&mut self, t: R, q: &[R], qd: &[R], qdd: &[R], multipliers: &[R]) -> Option<R> {
        let event = self.tape.event.as_ref()?;
        let mut value = [R::zero()];
        self.set_multipliers(multipliers);
        self.evaluate(event, t, [q, qd, qdd], &mut value);
        Some(value[0])
    }

    /// The switching functions.
    pub fn switching_functions(&mut self, t: R, q: &[R], qd: &[R], results: &mut [R]) {
        self.evaluate(&self.tape.switching_functions, t, [q, qd], results);
    }

    /// The arguments of hyperbolic tangents.
    pub fn tanh_arguments(&mut self, t: R, q: &[R], qd: &[R], results: &mut [R]) {
        self.evaluate(&self.tape.tanh_arguments, t, [q, qd], results);
    }

    /// Coordinates and rates at the start; [`Tape::given`] says which of them are given.
    pub fn start(&mut self, q: &mut [R], qd: &mut [R]) {
        let (of_q, of_qd) = self.tape.start.results.split_at(q.len());
        self.run(&self.tape.start.operations);
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
        self.values[self.places.multipliers..][..multipliers.len()].copy_from_slice(multipliers);
    }

    /// The results of a function of time and as many of `q`, `qd`, `qdd` as it has.
    fn evaluate<const K: usize>(&mut self, function: &TapeFunction, t: R, arguments: [&[R]; K], results: &mut [R]) {
        self.evaluate_at(t, arguments, &function.operations);
        self.read(&function.results, results);
    }

    /// Executes operations at a time and at as many of `q`, `qd`, `qdd` as are given.
    pub(super) fn evaluate_at<const K: usize>(&mut self, t: R, arguments: [&[R]; K], operations: &[Operation]) {
        let (first, n) = (self.places.t, self.tape.coordinates as usize);
        self.values[first] = t;
        for (k, argument) in arguments.into_iter().enumerate() {
            self.values[first + 1 + k * n..][..n].copy_from_slice(argument);
        }
        self.run(operations);
    }

    fn run(&mut self, operations: &[Operation]) {
        execute(&mut self.values, self.places.end, operations);
    }

    fn read(&self, places: &[u32], results: &mut [R]) {
        assert_eq!(places.len(), results.len(), "room for all results");
        for (result, &place) in results.iter_mut().zip(places) {
            *result = self.values[place as usize];
        }
    }
}
