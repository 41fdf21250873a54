//! Smooth transitions of forces that steps must resolve: hyperbolic tangents, for example of friction.

use std::f64::consts::FRAC_PI_2;

use qrm_core::{Mechanism, StateRef, TapeEvaluator};

/// The arguments of the hyperbolic tangents of a mechanism.
#[derive(Clone, Debug)]
pub(super) struct Transitions {
    evaluator: TapeEvaluator<'static, Vec<f64>>,
    /// The values of the arguments at both ends of a step.
    values: [Vec<f64>; 2],
}

impl Transitions {
    /// Creates the transitions of a mechanism; `None` if there are none.
    pub(super) fn new(mechanism: &dyn Mechanism) -> Option<Box<Self>> {
        let tape = mechanism.tape()?;
        let count = tape.tanh_arguments.results.len();
        if count == 0 {
            return None;
        }
        let evaluator = TapeEvaluator::with_parameters(tape, mechanism.parameters());
        Some(Box::new(Self { evaluator, values: [vec![0.0; count], vec![0.0; count]] }))
    }

    /// The largest change of an argument in a step, relative to its distance from the nearest pole of the hyperbolic
    /// tangent, `i pi/2`. Above 1 a polynomial of any degree misses a part of the transition, and so do error
    /// estimates.
    pub(super) fn change(&mut self, from: &StateRef, to: &StateRef) -> f64 {
        let [begin, end] = &mut self.values;
        for (values, at) in [(&mut *begin, from), (&mut *end, to)] {
            self.evaluator.tanh_arguments(at.t, at.q, at.qd, values);
        }
        let changes = begin.iter().zip(end).map(|(a, b)| {
            let nearest = if *a * *b > 0.0 { a.abs().min(b.abs()) } else { 0.0 };
            (*b - *a).abs() / nearest.hypot(FRAC_PI_2)
        });
        changes.fold(0.0, f64::max)
    }
}
