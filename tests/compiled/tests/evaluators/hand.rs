//! Both quick-return scenes by formulae written by hand and automatic differentiation, at random states of random
//! geometries.

// The parameters have the names of the scene.
#![allow(non_snake_case)]

use num_dual::{Dual2_64, Dual64, DualNum};
use qrm_core::{Generated, Mechanism};
use qrm_model::quick_return::{self, QuickReturn};
use qrm_model::quick_return_loaded::{self, QuickReturnLoaded};

use super::list::{State, evaluators};
use super::twin::{ByDualNumbers, ByHand, HandWritten, PlainFunctions, Twin};
use crate::model;

const STATES: usize = 1000;
const TOLERANCE: f64 = 1e-12;

trait Number: DualNum<Primitive = f64> + Copy {}
impl<D: DualNum<Primitive = f64> + Copy> Number for D {}

type Loaded = quick_return_loaded::Parameters;

/// Points A, B, C.
fn points<D: Number>(p: &Loaded, [phi2, phi4, phi5]: [D; 3]) -> [[D; 2]; 3] {
    let a = [phi2.cos() * p.O2A, phi2.sin() * p.O2A + p.O4O2];
    let b = [phi4.cos() * p.O4B, phi4.sin() * p.O4B];
    [a, b, [b[0] + phi5.cos() * p.BC, b[1] + phi5.sin() * p.BC]]
}

/// Rows: crank angle, block x y angle, rocker x y angle, rod x y angle, ram x; with their inertias.
fn positions<D: Number>(p: &Loaded, q: [D; 3]) -> [D; 11] {
    let [a, b, c] = points(p, q);
    let rocker = [q[1].cos() * p.O4G4, q[1].sin() * p.O4G4];
    let rod = [b[0] + q[2].cos() * p.BG5, b[1] + q[2].sin() * p.BG5];
    [q[0], a[0], a[1], q[1], rocker[0], rocker[1], q[1], rod[0], rod[1], q[2], c[0]]
}

fn inertias(p: &Loaded) -> [f64; 11] {
    [p.J2, p.m3, p.m3, p.J3, p.m4, p.m4, p.J4, p.m5, p.m5, p.J5, p.m6]
}

/// The slot as a function of the position of A and the angle of the rocker.
fn slot<D: Number>(a: [D; 2], phi4: D) -> D {
    a[0] - (a[0] * a[0] + a[1] * a[1]).sqrt() * phi4.cos()
}

fn closures<D: Number>(p: &Loaded, q: [D; 3]) -> [D; 2] {
    let [a, _, c] = points(p, q);
    [slot(a, q[1]), c[1] - p.yC]
}

/// Weight, torque, cutting force, spring and damper as generalized forces.
fn loads(p: &Loaded, q: [f64; 3], qd: [f64; 3]) -> [f64; 3] {
    let ram_rate = moving(q, qd, [0.0; 3], |q| points(p, q)[2][0]).v1;
    std::array::from_fn(|i| {
        let along = |f: &dyn Fn([Dual64; 3]) -> Dual64| f(direction(q, i)).eps;
        let ram = along(&|q| points(p, q)[2][0]);
        let push = p.F6 - p.k * (points(p, q)[2][0] - p.x6_0) - p.cd * ram_rate;
        let heights = [(p.m3, 2), (p.m4, 5), (p.m5, 8)];
        let weight: f64 = heights.iter().map(|(m, row)| -m * p.g * along(&|q| positions(p, q)[*row])).sum();
        push * ram + weight + if i == 0 { p.T2 } else { 0.0 }
    })
}

/// Coordinates that carry the derivative by one of them.
fn direction(q: [f64; 3], i: usize) -> [Dual64; 3] {
    std::array::from_fn(|j| Dual64::new(q[j], if i == j { 1.0 } else { 0.0 }))
}

/// A function of the coordinates with its first two time derivatives.
fn moving(q: [f64; 3], qd: [f64; 3], qdd: [f64; 3], f: impl Fn([Dual2_64; 3]) -> Dual2_64) -> Dual2_64 {
    f(std::array::from_fn(|i| Dual2_64::new(q[i], qd[i], qdd[i])))
}

struct Sample {
    p: Loaded,
    state: State<3, 2>,
}

fn samples(loaded: bool) -> impl Iterator<Item = Sample> {
    let mut random = fastrand::Rng::with_seed(20);
    std::iter::repeat_with(move || {
        let mut between = |low: f64, high: f64| low + (high - low) * random.f64();
        let mut p = Loaded::default();
        p.O2A *= between(0.5, 1.2);
        p.O4O2 *= between(1.0, 2.0);
        p.x6_0 = between(-1.0, 1.0);
        for value in [&mut p.J3, &mut p.g, &mut p.T2, &mut p.k, &mut p.cd] {
            *value = if loaded { between(0.1, 20.0) } else { 0.0 };
        }
        for value in [&mut p.O4B, &mut p.BC, &mut p.O4G4, &mut p.BG5, &mut p.yC] {
            *value *= between(0.6, 1.6);
        }
        for value in [&mut p.m3, &mut p.m4, &mut p.m5, &mut p.m6, &mut p.J2, &mut p.J4, &mut p.J5, &mut p.F6] {
            *value *= between(0.3, 3.0);
        }
        let state = State {
            t: between(0.0, 5.0),
            q: std::array::from_fn(|_| between(-10.0, 10.0)),
            qd: std::array::from_fn(|_| between(-20.0, 20.0)),
            qdd: std::array::from_fn(|_| between(-200.0, 200.0)),
            multipliers: std::array::from_fn(|_| between(-3e4, 3e4)),
            residuals: [0.01, 0.02],
        };
        Sample { p, state }
    })
    .take(STATES)
}

/// The values that every function must give, by automatic differentiation.
struct Expected {
    positions: [f64; 11],
    jacobian: [[f64; 3]; 11],
    bias: [f64; 11],
    /// The functions of all evaluators, with what each number is compared with beside itself.
    functions: Vec<(&'static str, Vec<f64>, Vec<f64>)>,
}

fn expected(s: &Sample) -> Expected {
    let Sample { p, state: State { q, qd, qdd, multipliers, .. } } = s;
    let (q, qd, qdd) = (*q, *qd, *qdd);
    let rows: [Dual2_64; 11] = std::array::from_fn(|r| moving(q, qd, [0.0; 3], |q| positions(p, q)[r]));
    let closed: [Dual2_64; 2] = std::array::from_fn(|r| moving(q, qd, [0.0; 3], |q| closures(p, q)[r]));
    let jacobian: [[f64; 3]; 11] =
        std::array::from_fn(|r| std::array::from_fn(|i| positions(p, direction(q, i))[r].eps));
    let constraint_jacobian: [[f64; 3]; 2] =
        std::array::from_fn(|r| std::array::from_fn(|i| closures(p, direction(q, i))[r].eps));
    let m = inertias(p);
    let sum = |f: &dyn Fn(usize) -> f64| (0..11).map(f).sum::<f64>();
    let applied = loads(p, q, qd);
    let ram = moving(q, qd, qdd, |q| points(p, q)[2][0]);
    let slide = moving(q, qd, qdd, |q| {
        let a = points(p, q)[0];
        (a[0] * a[0] + a[1] * a[1]).sqrt()
    });
    let a = points(p, q)[0].map(|c| Dual64::new(c, 0.0));
    let across = [-q[1].sin(), q[1].cos()];
    let moved = [a[0] + Dual64::new(0.0, across[0]), a[1] + Dual64::new(0.0, across[1])];
    let height = |row: usize| rows[row].re;
    let spring = ram.re - p.x6_0;
    let mass: [[f64; 3]; 3] =
        std::array::from_fn(|i| std::array::from_fn(|j| sum(&|r| m[r] * jacobian[r][i] * jacobian[r][j])));
    let forces: [f64; 3] = std::array::from_fn(|i| applied[i] - sum(&|r| m[r] * jacobian[r][i] * rows[r].v2));
    let kinetic = sum(&|r| 0.5 * m[r] * rows[r].v1 * rows[r].v1);
    let potential = -p.F6 * ram.re - p.T2 * q[0]
        + p.g * (p.m3 * height(2) + p.m4 * height(5) + p.m5 * height(8))
        + 0.5 * p.k * spring * spring;
    let along_slot = -multipliers[0] * slot(moved, Dual64::new(q[1], 0.0)).eps;
    let outputs = vec![ram.re, ram.v1, ram.v2, slide.v1, along_slot, -multipliers[1]];
    // Single numbers that are differences of large ones are compared with those.
    let speed = p.O4B * qd[1].abs() + p.BC * qd[2].abs();
    let beside = vec![1.0, 10.0, 100.0, 10.0, multipliers[0].abs(), multipliers[1].abs()];
    let whole = |name, values: &[f64]| {
        let largest = values.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
        (name, values.to_vec(), vec![largest; values.len()])
    };
    Expected {
        positions: rows.map(|r| r.re),
        jacobian,
        bias: rows.map(|r| r.v2),
        functions: vec![
            whole("constraints", &closed.map(|c| c.re)),
            whole("jacobian", constraint_jacobian.as_flattened()),
            whole("jacobian of constraints", constraint_jacobian.as_flattened()),
            whole("bias", &closed.map(|c| c.v2)),
            whole("mass matrix", mass.as_flattened()),
            whole("mass matrix of dynamics", mass.as_flattened()),
            whole("forces", &forces),
            ("energy", vec![kinetic, potential], vec![kinetic; 2]),
            ("power", vec![-p.cd * ram.v1 * ram.v1], vec![p.cd * speed * speed]),
            ("outputs", outputs, beside),
        ],
    }
}

/// Compares numbers with what is expected, relative to their sizes and to other sizes beside them.
fn close(what: &str, got: &[f64], expected: &[f64], beside: &[f64]) {
    assert_eq!(got.len(), expected.len(), "{what}");
    for ((got, expected), beside) in got.iter().zip(expected).zip(beside) {
        let allowed = TOLERANCE * expected.abs().max(*beside);
        assert!((got - expected).abs() <= allowed, "{what}: {got:e} instead of {expected:e} (beside {beside:e})");
    }
}

/// The functions of rows that no evaluator has.
fn close_rows(what: &str, got: &[f64], expected: &[f64]) {
    let largest = expected.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
    close(what, got, expected, &vec![largest; expected.len()]);
}

fn drop_row<T: Copy>(rows: &[T], dropped: usize) -> Vec<T> {
    rows.iter().enumerate().filter(|(i, _)| *i != dropped).map(|(_, row)| *row).collect()
}

/// Compares every evaluator of a mechanism, with the kernel of `X`.
fn check<X: Generated<3, 2>>(mechanism: &dyn Mechanism, state: &State<3, 2>, expected: &Expected) {
    for evaluator in evaluators::<X, 3, 2>() {
        for (name, got) in evaluator.values(mechanism, X::TAPE.tape(), state).into_iter().flatten() {
            let Some((_, expected, beside)) = expected.functions.iter().find(|(n, ..)| *n == name) else { continue };
            let got: Vec<f64> = got.iter().map(|number| number.hi()).collect();
            close(&format!("{}, {name}", evaluator.name), &got, expected, beside);
        }
    }
}

/// Pairs every field of the parameters with its name; a field that is left out does not compile.
macro_rules! named {
    ($parameters:expr; $($name:ident)*) => {{
        let Loaded { $($name),* } = $parameters;
        [$((stringify!($name), $name)),*]
    }};
}

/// The value of a parameter by its name.
fn by_name(p: Loaded) -> impl Fn(&str) -> Option<f64> {
    let values = named!(p; O2A O4B BC O4O2 O4G4 BG5 yC m3 m4 m5 m6 J2 J3 J4 J5 F6 T2 g k cd w0 OA0 x6_0);
    move |name| values.iter().find(|(own, _)| *own == name).map(|(_, value)| *value)
}

#[test]
fn the_loaded_scene_agrees_with_formulae_by_hand() {
    for s in samples(true) {
        let (own, e) = (QuickReturnLoaded::new(s.p), expected(&s));
        let mechanism = model("quick-return-loaded").mechanism(&by_name(s.p));
        check::<QuickReturnLoaded>(&*mechanism, &s.state, &e);
        let State { q, qd, .. } = &s.state;
        close_rows("x", &quick_return_loaded::com_positions(&own, q), &e.positions);
        let jacobian = quick_return_loaded::com_jacobian(&own, q);
        close_rows("T", jacobian.as_flattened(), e.jacobian.as_flattened());
        close_rows("(T qd)_q qd", &quick_return_loaded::com_bias(&own, q, qd), &e.bias);
    }
}

#[test]
fn the_plain_scene_and_its_twins_agree_with_formulae_by_hand() {
    for s in samples(false) {
        // Parameters that only the loaded scene has are not asked for.
        let replace = by_name(s.p);
        let parameters = quick_return::Parameters::with(&replace);
        let (own, e) = (QuickReturn::new(parameters), expected(&s));
        let State { q, qd, .. } = &s.state;
        check::<QuickReturn>(&*model("quick-return").mechanism(&replace), &s.state, &e);
        check::<HandWritten>(&Twin::<ByHand>::with_parameters(&replace), &s.state, &e);
        check::<QuickReturn>(&Twin::<ByDualNumbers>::with_parameters(&replace), &s.state, &e);
        // The block's angle carries no inertia there.
        let (jacobian, bias) = (drop_row(&e.jacobian, 3), drop_row(&e.bias, 3));
        close_rows("x", &quick_return::com_positions(&own, q), &drop_row(&e.positions, 3));
        let by_hand = <ByHand as PlainFunctions>::new(parameters);
        for rows in [quick_return::com_jacobian(&own, q), by_hand.com_jacobian(q)] {
            close_rows("T", rows.as_flattened(), jacobian.as_flattened());
        }
        for rows in [quick_return::com_bias(&own, q, qd), by_hand.com_bias(q, qd)] {
            close_rows("(T qd)_q qd", &rows, &bias);
        }
    }
}
