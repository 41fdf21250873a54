//! The consistent start on dual numbers.

use crate::position::{DependentCoordinates, Start, assemble};
use std::convert::Infallible;

use qrm_core::Scalar;

use super::equations::{DualEquations, DualState};
use super::error::SensitivityError;
use super::number::{Inner, Number, complete, constants, values};
use super::saddle::less_product;
use crate::run::StartError;
use crate::solve::LoopConstraints;

/// The consistent state at the start. Given coordinates and rates may depend on parameters; the others follow by the
/// constraints, `C_q dx = -dC` in derivatives.
///
/// # Errors
/// The mechanism cannot be assembled, or the start has no derivatives.
pub(super) fn start<T: Inner>(equations: &mut DualEquations<T>) -> Result<DualState<T>, SensitivityError> {
    let given = Start::new(equations.mechanism);
    let assembled = assemble(equations.mechanism, Start::new(equations.mechanism));
    let (real_q, real_qd) = assembled.map_err(|e| SensitivityError::Start(StartError::NotAssembled(e)))?;
    let (mut q, mut qd) = (constants(&real_q), constants(&real_qd));
    equations.evaluator.start(&mut q, &mut qd);
    take_assembled(&mut q, &real_q, &given.given);
    take_assembled(&mut qd, &real_qd, &given.given_rates);
    consistent(equations, q, qd, &given)
}

/// The state with these coordinates and rates, of which the given ones have derivatives. Those of the others follow.
///
/// # Errors
/// The state has no derivatives.
pub(super) fn consistent<T: Inner>(
    equations: &mut DualEquations<T>,
    mut q: Vec<Number<T>>,
    mut qd: Vec<Number<T>>,
    given: &Start,
) -> Result<DualState<T>, SensitivityError> {
    let jacobian = LoopConstraints::at(equations.mechanism, 0.0, &values(&q)).constraint_jacobian;
    let tape = equations.evaluator.tape();
    let mut results = vec![Number::zero(); tape.loop_constraints.results.len()];
    let (evaluator, parts) = (&mut equations.evaluator, equations.parts);
    follow(&mut q, parts, &DependentCoordinates::new(&jacobian, &given.given), |q| {
        evaluator.loop_constraints(Number::zero(), q, &mut results);
        tape.split_loop_constraints(&results)[0].iter().map(|residual| -*residual).collect()
    });
    evaluator.loop_constraints(Number::zero(), &q, &mut results);
    let [_, rows, rates] = tape.split_loop_constraints(&results);
    follow(&mut qd, parts, &DependentCoordinates::new(&jacobian, &given.given_rates), |qd| {
        let rows = rows.chunks_exact(qd.len()).zip(rates);
        rows.map(|(row, rate)| less_product(-*rate, row, qd)).collect()
    });
    let made = equations.completed(Number::zero(), q, qd);
    equations.checked(Number::zero(), made)
}

/// Lets the derivatives of dependent coordinates or rates follow; `open` is the negative residual of the constraints.
fn follow<T: Inner>(
    x: &mut [Number<T>],
    parts: usize,
    dependents: &DependentCoordinates,
    mut open: impl FnMut(&[Number<T>]) -> Vec<Number<T>>,
) {
    let n = x.len();
    let solve = |right: Vec<f64>| {
        let mut change = vec![0.0; n];
        dependents.follow(&mut change, &right.iter().map(|right| -right).collect::<Vec<f64>>());
        Ok::<_, Infallible>(change)
    };
    let Ok(()) = complete(x, parts, |x| Ok(open(x)), solve);
}

/// Takes over assembled values; only given ones keep their derivatives.
fn take_assembled<T: Inner>(numbers: &mut [Number<T>], values: &[f64], given: &[bool]) {
    for ((taken, value), given) in numbers.iter_mut().zip(values).zip(given) {
        let derivatives = if *given { *taken - Number::from_f64(taken.to_f64()) } else { Number::zero() };
        *taken = derivatives + Number::from_f64(*value);
    }
}
