//! A mass 1 on a rod in the plane: `(x^2 + y^2 - r^2) / 2 = 0` with `r = l + a t`, under gravity `g` against y.

use std::borrow::Cow;

use qrm_core::Operation::{Add, Mul, Neg, Number as Constant, Sub};
use qrm_core::{Scalar, Tape, TapeFunction, TapeKernel};

use super::{At, Motion, Number, PreciseEquations, ReferenceState};
use crate::analysis::StateAt;
use crate::integrate::StepError;

/// The places are: parameters `l`, `a`, `g` 0 to 2; time 3; coordinates, rates and accelerations 4 to 9; the multiplier
/// 10; then those of a kernel.
static ROD: Tape = Tape {
    coordinates: 2,
    constraints: 1,
    is_driven: true,
    parameters: TapeFunction::new(&[Constant(1.0), Constant(0.0), Constant(9.81)], &[16, 17, 18]),
    constants: Cow::Borrowed(&[]),
    dynamics: TapeFunction::new(
        &[Constant(1.0), Constant(0.0), Neg(2), Mul(6, 6), Mul(7, 7), Add(19, 20), Mul(1, 1), Sub(21, 22)],
        &[16, 17, 17, 16, 17, 18, 4, 5, 23],
    ),
    loop_constraints: TapeFunction::new(
        &[
            Mul(4, 4),
            Mul(5, 5),
            Add(16, 17),
            Mul(1, 3),
            Add(0, 19),
            Mul(20, 20),
            Sub(18, 21),
            Constant(0.5),
            Mul(22, 23),
            Mul(1, 20),
            Neg(25),
        ],
        &[24, 4, 5, 26],
    ),
    mass_matrix: TapeFunction::new(&[Constant(1.0), Constant(0.0)], &[16, 17, 17, 16]),
    momenta: None,
    energy: TapeFunction::new(&[Mul(6, 6), Mul(7, 7), Add(16, 17), Constant(0.5), Mul(18, 19), Mul(2, 5)], &[20, 21]),
    power: TapeFunction::new(&[Constant(0.0)], &[16]),
    outputs: TapeFunction::new(&[], &[10]),
    linearization: None,
    event: None,
    switching_functions: TapeFunction::NONE,
    linear_in_time: 0,
    tanh_arguments: TapeFunction::NONE,
    start: TapeFunction::new(&[Constant(1.0), Constant(0.0)], &[16, 17, 17, 16]),
    given: Cow::Borrowed(&[true, true, true, true]),
    schedule: TapeFunction::new(&[Constant(0.001), Constant(1.0)], &[16, 17]),
    kernel: TapeKernel::NONE,
};

/// The motion from `(l, 0)` with the rates `(a, v)`.
fn motion(parameters: [f64; 3], v: f64) -> Result<Motion<'static>, StepError> {
    let [l, a, _] = parameters;
    let y = [l, 0.0, a, v].map(Number::from).to_vec();
    let at = At { t: Number::zero(), slope: y.clone(), y, h: 0.001 };
    Motion::new(PreciseEquations::new(&ROD, &parameters, vec![0]), at, 1e-22)
}

fn run_to_times(motion: &mut Motion, times: &[f64]) -> Result<Vec<StateAt>, StepError> {
    let mut states: Vec<ReferenceState> = Vec::new();
    motion.run_to_times(times, &mut states)?;
    Ok(states.into_iter().map(|state| state.rounded).collect())
}

fn far(a: Number, b: Number) -> f64 {
    (a - b).to_f64().abs()
}

/// Without gravity the angular momentum `l v` is constant: the angle is `l v (1/l - 1/r) / a`.
#[test]
fn a_rod_that_grows_turns_as_it_must() {
    let [l, a, v] = [1.0, 0.25, 3.0];
    let mut motion = motion([l, a, 0.0], v).expect("regular");
    let states = run_to_times(&mut motion, &[0.5, 2.0]).expect("smooth");
    let r = Number::from(l + 2.0 * a);
    let angle = Number::from(v / a) * (Number::from(1.0) - r.recip());
    let (sin, cos) = angle.sin_cos();
    let (radial, across) = (Number::from(a), Number::from(v) / r);
    let exact = [r * cos, r * sin, radial * cos - across * sin, radial * sin + across * cos];
    for (y, exact) in motion.at.y.iter().zip(exact) {
        assert!(far(*y, exact) < 1e-19, "{y:?} instead of {exact:?}");
    }
    assert!(states[1].residual < 1e-30, "{states:?}");
    assert_eq!(states.iter().map(|state| state.t).collect::<Vec<f64>>(), [0.5, 2.0]);
    // x'' + lambda x = 0 at the radius r: lambda = across^2 / r^2
    let multiplier = across * across / (r * r);
    assert!((states[1].outputs[0] - multiplier.to_f64()).abs() < 1e-15, "{states:?}");
}

#[test]
fn energy_and_length_of_a_pendulum_stay() {
    let mut motion = motion([1.0, 0.0, 9.81], 2.0).expect("regular");
    let energy = |motion: &mut Motion| {
        let [kinetic, potential] = motion.equations.evaluator.energy(&motion.at.y[..2], &motion.at.y[2..]);
        kinetic + potential
    };
    let first = energy(&mut motion);
    run_to_times(&mut motion, &[1.0, 3.0]).expect("smooth");
    assert!(far(energy(&mut motion), first) < 1e-19);
    for rates in [false, true] {
        let residual = motion.equations.residuals(motion.at.t, &motion.at.y, rates)[0];
        assert!(residual.to_f64().abs() < 1e-28, "{residual:?}");
    }
}

#[test]
fn what_cannot_be_followed_is_told() {
    // A rod without length has no direction.
    assert_eq!(motion([0.0, 0.0, 9.81], 2.0).err(), Some(StepError::NotFinite));
    // A rod that shrinks to nothing makes its mass turn ever faster.
    let mut motion = motion([1.0, -1.0, 0.0], 1.0).expect("regular");
    motion.equations.operations = 99_900_000;
    let error = run_to_times(&mut motion, &[1.5]).err();
    assert!(matches!(error, Some(StepError::TooManySteps { .. })), "{error:?}");
}
