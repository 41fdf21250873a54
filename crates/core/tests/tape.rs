//! A tape written by hand: a pendulum under gravity, whose moment of inertia follows from mass and length.

use qrm_core::Operation::{Add, Cos, Mul, Neg, Number, Sin, Sub};
use qrm_core::{Fused, Scalar, Tape, TapeEvaluator, TapeFunction, TapeKernel};
use std::borrow::Cow;

const NONE: TapeFunction = TapeFunction::NONE;

/// Parameters `m`, `l`, `J = m*l*l` and `g` have the places 0 to 3, the arguments 4 to 9, the constants 10 and 11.
static PENDULUM: Tape = Tape {
    coordinates: 1,
    constraints: 0,
    is_driven: false,
    parameters: TapeFunction::new(&[Number(2.0), Number(0.5), Mul(0, 1), Mul(14, 1), Number(9.81)], &[12, 13, 15, 16]),
    constants: Cow::Borrowed(&[Mul(0, 1), Mul(10, 3)]),
    dynamics: TapeFunction::new(&[Sin(5), Mul(11, 12), Neg(13)], &[2, 14]),
    loop_constraints: NONE,
    mass_matrix: TapeFunction::new(&[], &[2]),
    momenta: None,
    energy: TapeFunction::new(
        &[Mul(6, 6), Mul(12, 2), Number(0.5), Mul(13, 14), Cos(5), Mul(11, 16), Neg(17)],
        &[15, 18],
    ),
    power: NONE,
    outputs: TapeFunction::new(&[Add(5, 6), Add(12, 7)], &[13]),
    linearization: None,
    event: Some(TapeFunction::new(&[Sub(5, 4)], &[12])),
    switching_functions: TapeFunction::NONE,
    linear_in_time: 0,
    tanh_arguments: TapeFunction::NONE,
    start: TapeFunction::new(&[Number(1.0), Number(0.0)], &[12, 13]),
    given: Cow::Borrowed(&[true, true]),
    schedule: TapeFunction::new(&[Number(0.001), Number(10.0)], &[12, 13]),
    kernel: TapeKernel::NONE,
};

fn pendulum() -> TapeEvaluator<'static, Vec<f64>> {
    TapeEvaluator::with_buffer(&PENDULUM, vec![0.0; PENDULUM.places()])
}

fn dynamics<R: Scalar>(buffer: &mut [R], replace: impl Fn(usize) -> Option<R>) -> [R; 2] {
    let mut evaluator = TapeEvaluator::with_buffer(&PENDULUM, buffer);
    evaluator.set_parameters(replace);
    let mut results = [R::zero(); 2];
    evaluator.dynamics(R::zero(), &[R::from_f64(0.3)], &[R::zero()], &mut results);
    results
}

#[test]
fn functions_are_evaluated_on_any_number() {
    let expected = [0.5, -(2.0 * 0.5 * 9.81 * Scalar::sin(0.3))];
    assert_eq!(dynamics(&mut [0.0; 19], |_| None), expected);
    assert_eq!(dynamics(&mut [Fused(0.0); 19], |_| None).map(|x| x.0), expected);
    let mut evaluator = pendulum();
    assert_eq!(evaluator.energy(&[0.0], &[2.0]), [1.0, -9.81]);
    let mut output = [0.0];
    evaluator.outputs(0.0, &[1.0], &[2.0], &[4.0], &[], &mut output);
    assert_eq!(output, [7.0]);
    assert_eq!(evaluator.event(3.0, &[1.0], &[0.0], &[0.0], &[]), Some(-2.0));
    let (mut q, mut qd) = ([0.0], [1.0]);
    evaluator.start(&mut q, &mut qd);
    assert_eq!((q, qd), ([1.0], [0.0]));
    assert_eq!((evaluator.schedule().step, evaluator.schedule().end_time), (0.001, 10.0));
    assert!(!evaluator.linearization(0.0, &q, &qd, &q, &[], &mut []));
}

#[test]
fn dependent_parameters_and_constants_follow() {
    let mut evaluator = pendulum();
    assert_eq!(evaluator.parameters(), [2.0, 0.5, 0.5, 9.81]);
    evaluator.set_parameters(|i| (i == 1).then_some(2.0));
    assert_eq!(evaluator.parameters(), [2.0, 2.0, 8.0, 9.81]);
    assert_eq!(evaluator.energy(&[0.0], &[1.0]), [4.0, -39.24]);
    evaluator.set_parameters(|i| (i == 2).then_some(7.0));
    assert_eq!(evaluator.parameters(), [2.0, 0.5, 7.0, 9.81]);
}

#[test]
#[should_panic(expected = "a tape of 19 places needs a larger buffer")]
fn a_short_buffer_is_refused() {
    TapeEvaluator::with_buffer(&PENDULUM, &mut [0.0; 16][..]);
}
