//! A pendulum in Cartesian coordinates, `x^2 + y^2 = l^2`, by a tape written by hand.
//!
//! The motion from rest is `x(t; l, g) = l X(t sqrt(g/l))`, which gives its derivatives by `l` and `g`.

use qrm_core::Operation::{self, Add, Mul, Neg, Number, Sqrt, Sub};
use qrm_core::{
    Description, DynamicsMut, LoopConstraintsMut, Mechanism, ParameterDescription, ParameterOverrides,
    QuantityDescription, Schedule, StartMut, StateRef, Tape, TapeEvaluator, TapeFunction, TapeKernel,
};
use std::borrow::Cow;

use super::{Sensitivity, SensitivityError, SensitivityRequest, derived};
use crate::event::End;
use crate::run::StartError;

const NONE: TapeFunction = TapeFunction::NONE;
const L: f64 = 0.7;
const G: f64 = 9.81;

/// Parameters `l` and `g` have the places 0 and 1, the arguments 2 to 14, the constants 1, 0, `l^2`, 2 and `-g` 15
/// to 19.
static TAPE: Tape = Tape {
    coordinates: 2,
    constraints: 1,
    is_driven: false,
    parameters: TapeFunction::new(&[Number(L), Number(G)], &[20, 21]),
    constants: Cow::Borrowed(&[Number(1.0), Number(0.0), Mul(0, 0), Number(2.0), Neg(1)]),
    dynamics: TapeFunction::new(
        &[Mul(18, 3), Mul(18, 4), Mul(5, 5), Mul(6, 6), Add(22, 23), Mul(18, 24)],
        &[15, 16, 16, 15, 16, 19, 20, 21, 25],
    ),
    loop_constraints: TapeFunction::new(
        &[Mul(3, 3), Mul(4, 4), Add(20, 21), Sub(22, 17), Mul(18, 3), Mul(18, 4)],
        &[23, 24, 25, 16],
    ),
    mass_matrix: TapeFunction::new(&[], &[15, 16, 16, 15]),
    momenta: None,
    energy: NONE,
    power: NONE,
    outputs: TapeFunction::new(&[], &[4]),
    linearization: None,
    event: Some(TapeFunction::new(&[Neg(3)], &[20])),
    switching_functions: TapeFunction::NONE,
    linear_in_time: 0,
    tanh_arguments: TapeFunction::NONE,
    start: TapeFunction::new(&[Number(0.6), Mul(20, 0), Number(-0.8), Mul(22, 0)], &[21, 23, 16, 16]),
    given: Cow::Borrowed(&[true, false, true, false]),
    schedule: TapeFunction::new(&[Number(0.001), Number(2.0)], &[20, 21]),
    kernel: TapeKernel::NONE,
};

const fn quantity(name: &'static str) -> QuantityDescription {
    QuantityDescription { name, unit: "", doc: "" }
}

const fn parameter(name: &'static str) -> ParameterDescription {
    ParameterDescription { name, unit: "", doc: "", formula: "" }
}

static DESCRIPTION: Description = Description {
    name: "pendulum",
    doc: "",
    source: "",
    derivation: "",
    coordinates: &[quantity("x"), quantity("y")],
    constraints: &[quantity("length")],
    outputs: &[quantity("y")],
    parameters: &[parameter("l"), parameter("g")],
    left_out: &[],
    has_corners: false,
    friction: &[],
    until: "x <= 0",
};

struct Pendulum(TapeEvaluator<'static, Vec<f64>>);

impl Pendulum {
    fn new(replace: ParameterOverrides) -> Self {
        let mut evaluator = TapeEvaluator::new(&TAPE);
        evaluator.set_parameters(|i| replace(DESCRIPTION.parameters[i].name));
        Self(evaluator)
    }
}

impl Mechanism for Pendulum {
    fn description(&self) -> &'static Description {
        &DESCRIPTION
    }
    fn parameters(&self) -> &[f64] {
        self.0.parameters()
    }
    fn is_driven(&self) -> bool {
        false
    }
    fn operations(&self) -> usize {
        0
    }
    fn start(&self, start: StartMut) {
        self.0.clone().start(start.q, start.qd);
        start.given.copy_from_slice(&TAPE.given[..2]);
        start.given_rates.copy_from_slice(&TAPE.given[2..]);
    }
    fn schedule(&self) -> Schedule<f64> {
        self.0.clone().schedule()
    }
    fn event(&self, at: &StateRef) -> Option<f64> {
        self.0.clone().event(at.t, at.q, at.qd, at.qdd, at.multipliers)
    }
    fn dynamics(&self, t: f64, q: &[f64], qd: &[f64], dynamics: DynamicsMut) {
        let mut results = [0.0; 9];
        self.0.clone().dynamics(t, q, qd, &mut results);
        let [mass_matrix, forces, jacobian, bias] = TAPE.split_dynamics(&results);
        dynamics.mass_matrix.copy_from_slice(mass_matrix);
        dynamics.generalized_forces.copy_from_slice(forces);
        dynamics.constraint_jacobian.copy_from_slice(jacobian);
        dynamics.constraint_bias.copy_from_slice(bias);
    }
    fn loop_constraints(&self, t: f64, q: &[f64], constraints: LoopConstraintsMut) {
        let mut results = [0.0; 4];
        self.0.clone().loop_constraints(t, q, &mut results);
        let [residuals, jacobian, rate] = TAPE.split_loop_constraints(&results);
        constraints.residuals.copy_from_slice(residuals);
        constraints.constraint_jacobian.copy_from_slice(jacobian);
        constraints.constraint_rate.copy_from_slice(rate);
    }
    fn mass_matrix(&self, q: &[f64], mass_matrix: &mut [f64]) {
        self.0.clone().mass_matrix(q, mass_matrix);
    }
    fn energy(&self, _: &[f64], _: &[f64]) -> [f64; 2] {
        [0.0; 2]
    }
    fn power(&self, _: f64, _: &[f64], _: &[f64], _: &[f64], _: &[f64]) -> f64 {
        0.0
    }
    fn outputs(&self, _: f64, q: &[f64], _: &[f64], _: &[f64], _: &[f64], outputs: &mut [f64]) {
        outputs[0] = q[1];
    }
}

fn derive(replace: ParameterOverrides, by: &[&str], end: Option<End>) -> Result<Sensitivity, SensitivityError> {
    derived(&Pendulum::new(replace), &TAPE, replace, &SensitivityRequest { by, end, ..SensitivityRequest::default() })
}

/// The derivatives where an event occurs, whose operations have places from 20 on.
fn until(operations: &'static [Operation], result: &'static [u32]) -> Result<Sensitivity, SensitivityError> {
    let tape = Tape { event: Some(TapeFunction::new(operations, result)), ..TAPE.clone() };
    derive(&|_| None, &["l", "g"], Some(End::Event(&tape)))
}

#[track_caller]
fn close(got: f64, expected: f64, within: f64) {
    assert!((got - expected).abs() <= within, "{got} instead of {expected}: off by {:.1e}", got - expected);
}

#[test]
fn derivatives_follow_the_law_of_similarity() {
    let t = 1.5;
    let found = derive(&|_| None, &["l", "g"], Some(End::Time(t))).expect("smooth");
    assert_eq!((found.end_time.value, &found.end_time.by[..]), (t, &[0.0, 0.0][..]));
    for (place, rate) in found.q.iter().zip(&found.qd) {
        close(place.by[0], place.value / L - rate.value * t / (2.0 * L), 1e-9);
        close(place.by[1], rate.value * t / (2.0 * G), 1e-9);
    }
    let [lowest, _] = &found.outputs[0].minimum;
    close(lowest.value, -L, 1e-9);
    close(lowest.by[0], -1.0, 1e-7);
    close(lowest.by[1], 0.0, 1e-7);
}

#[test]
fn derivatives_are_those_of_the_numerical_solution() {
    let by_l = |l: f64| derive(&|name| (name == "l").then_some(l), &["l"], Some(End::Time(1.5)));
    let [before, found, after] = [L - 1e-4, L, L + 1e-4].map(|l| by_l(l).expect("smooth"));
    for i in 0..2 {
        close((after.q[i].value - before.q[i].value) / 2e-4, found.q[i].by[0], 1e-6);
        close((after.qd[i].value - before.qd[i].value) / 2e-4, found.qd[i].by[0], 1e-5);
    }
}

#[test]
fn the_time_of_an_event_moves() {
    let found = derive(&|_| None, &["l", "g"], None).expect("smooth");
    let t = &found.end_time;
    close(t.by[0], t.value / (2.0 * L), 1e-10);
    close(t.by[1], -t.value / (2.0 * G), 1e-10);
    // At the event the pendulum hangs down.
    close(found.q[0].by[0], 0.0, 1e-12);
    close(found.q[1].by[0], -1.0, 1e-12);
    let same = until(&[Neg(3)], &[20]).expect("smooth");
    assert_eq!((same.end_time.value, same.end_time.by[0]), (t.value, t.by[0]));
}

#[test]
fn the_time_at_which_a_force_is_reached_moves() {
    // The multiplier is g (2 y0 - 3 y) / (2 l^2), and g/l times a function of t sqrt(g/l).
    let force = 7.5;
    let found = until(&[Number(7.5), Sub(9, 20)], &[21]).expect("smooth");
    let (t, y, rate) = (&found.end_time, found.q[1].value, found.qd[1].value);
    close(G * (2.0 * -0.8 * L - 3.0 * y) / (2.0 * L * L), force, 1e-9);
    let by_time = -3.0 * G * rate / (2.0 * L * L);
    close(t.by[0], force / (L * by_time) + t.value / (2.0 * L), 1e-9);
    close(t.by[1], -force / (G * by_time) - t.value / (2.0 * G), 1e-9);
}

#[test]
fn motions_without_derivatives_are_refused() {
    let unknown = derive(&|_| None, &["k"], None);
    assert_eq!(unknown, Err(SensitivityError::NoParameter { name: "k".to_owned() }));
    assert_eq!(until(&[Number(0.0)], &[20]), Err(SensitivityError::Start(StartError::ConditionHolds)));
    assert_eq!(until(&[Number(-1.0)], &[20]), Err(SensitivityError::EventNotReached { end_time: 2.0 }));
    let touching = until(&[Number(1.0), Sub(2, 20), Neg(21), Mul(22, 21)], &[23]);
    assert_eq!(touching, Err(SensitivityError::GrazingEvent { t: 1.0 }));
    let undefined = until(&[Number(1.0), Sub(20, 2), Sqrt(21), Neg(22), Sub(23, 20)], &[24]);
    assert!(matches!(undefined, Err(SensitivityError::NotSmooth { t }) if (t - 1.0).abs() < 1e-9), "{undefined:?}");
    let at_a_point = derive(&|name| (name == "l").then_some(0.0), &["g"], Some(End::Time(1.0)));
    assert_eq!(at_a_point, Err(SensitivityError::Singular { t: 0.0 }));
    let endless = End::Time(f64::INFINITY);
    assert!(matches!(derive(&|_| None, &["g"], Some(endless)), Err(SensitivityError::Start(_))));
}
