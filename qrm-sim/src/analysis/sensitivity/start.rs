//! The consistent start on dual numbers.

use std::convert::Infallible;

use qrm_core::Scalar;

use super::SensitivityError;
use super::equations::{DualEquations, DualState};
use super::number::{Inner, Number, complete, constants};
use super::saddle::less_product;
use crate::run::{Dependents, StartError, assembled};
use crate::solve::LoopConstraints;
use crate::start::Start;

/// The consistent state at the start. Given coordinates and rates may depend on parameters; the others follow by the
/// constraints, `C_q dx = -dC` in derivatives.
///
/// # Errors
/// The mechanism cannot be assembled, or the start has no derivatives.
pub(super) fn start<T: Inner>(equations: &mut DualEquations<T>) -> Result<DualState<T>, SensitivityError> {
    let given = Start::of(equations.mechanism);
    let assembled = assembled(equations.mechanism);
    let (real_q, real_qd) = assembled.map_err(|e| SensitivityError::Start(StartError::NotAssembled(e)))?;
    let jacobian = LoopConstraints::of(equations.mechanism, 0.0, &real_q).constraint_jacobian;
    let (mut q, mut qd) = (constants(&real_q), constants(&real_qd));
    equations.evaluator.start(&mut q, &mut qd);
    take_assembled(&mut q, &real_q, &given.given);
    take_assembled(&mut qd, &real_qd, &given.given_rates);

    let tape = equations.evaluator.tape();
    let mut results = vec![Number::zero(); tape.loop_constraints.results.len()];
    let follow = |x: &mut [Number<T>], given: &[bool], open: &mut dyn FnMut(&[Number<T>]) -> Vec<Number<T>>| {
        let dependents = Dependents::new(&jacobian, given);
        let solve = |right: Vec<f64>| {
            let mut change = vec![0.0; given.len()];
            let residuals: Vec<f64> = right.iter().map(|right| -right).collect();
            dependents.follow(&mut change, &residuals);
            Ok::<_, Infallible>(change)
        };
        let Ok(()) = complete(x, equations.parts, |x| Ok(open(x)), solve);
    };
    let evaluator = &mut equations.evaluator;
    follow(&mut q, &given.given, &mut |q| {
        evaluator.loop_constraints(Number::zero(), q, &mut results);
        tape.split_loop_constraints(&results)[0].iter().map(|residual| -*residual).collect()
    });
    evaluator.loop_constraints(Number::zero(), &q, &mut results);
    let [_, rows, rates] = tape.split_loop_constraints(&results);
    follow(&mut qd, &given.given_rates, &mut |qd| {
        let rows = rows.chunks_exact(qd.len()).zip(rates);
        rows.map(|(row, rate)| less_product(-*rate, row, qd)).collect()
    });
    let made = equations.completed(Number::zero(), q, qd);
    equations.checked(Number::zero(), made)
}

/// Takes over assembled values; only given ones keep their derivatives.
fn take_assembled<T: Inner>(numbers: &mut [Number<T>], values: &[f64], given: &[bool]) {
    for ((taken, value), given) in numbers.iter_mut().zip(values).zip(given) {
        let derivatives = if *given { *taken - Number::from_f64(taken.to_f64()) } else { Number::zero() };
        *taken = derivatives + Number::from_f64(*value);
    }
}
