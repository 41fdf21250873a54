//! Every generated function of both quick-return scenes, against automatic differentiation of formulae written here by
//! hand, at 1000 random states of random geometries.

// The parameters have the names of the scene.
#![allow(non_snake_case)]

use num_dual::{Dual2_64, Dual64, DualNum};
use qrm_model::twin::{ByDualNumbers, ByHand, Equations};
use qrm_model::{quick_return, quick_return_loaded};

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
    t: f64,
    q: [f64; 3],
    qd: [f64; 3],
    qdd: [f64; 3],
    multipliers: [f64; 2],
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
        Sample {
            p,
            t: between(0.0, 5.0),
            q: std::array::from_fn(|_| between(-10.0, 10.0)),
            qd: std::array::from_fn(|_| between(-20.0, 20.0)),
            qdd: std::array::from_fn(|_| between(-200.0, 200.0)),
            multipliers: std::array::from_fn(|_| between(-3e4, 3e4)),
        }
    })
    .take(STATES)
}

/// What every function must give, by automatic differentiation.
struct Expected {
    positions: [f64; 11],
    jacobian: [[f64; 3]; 11],
    bias: [f64; 11],
    constraints: [f64; 2],
    constraint_jacobian: [[f64; 3]; 2],
    constraint_bias: [f64; 2],
    mass: [[f64; 3]; 3],
    forces: [f64; 3],
    energy: [f64; 2],
    power: f64,
    outputs: [f64; 6],
}

fn expected(s: &Sample) -> Expected {
    let Sample { p, q, qd, qdd, multipliers, .. } = s;
    let (q, qd, qdd) = (*q, *qd, *qdd);
    let rows: [Dual2_64; 11] = std::array::from_fn(|r| moving(q, qd, [0.0; 3], |q| positions(p, q)[r]));
    let closed: [Dual2_64; 2] = std::array::from_fn(|r| moving(q, qd, [0.0; 3], |q| closures(p, q)[r]));
    let jacobian: [[f64; 3]; 11] =
        std::array::from_fn(|r| std::array::from_fn(|i| positions(p, direction(q, i))[r].eps));
    let constraint_jacobian = std::array::from_fn(|r| std::array::from_fn(|i| closures(p, direction(q, i))[r].eps));
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
    Expected {
        positions: rows.map(|r| r.re),
        jacobian,
        bias: rows.map(|r| r.v2),
        constraints: closed.map(|c| c.re),
        constraint_jacobian,
        constraint_bias: closed.map(|c| c.v2),
        mass: std::array::from_fn(|i| std::array::from_fn(|j| sum(&|r| m[r] * jacobian[r][i] * jacobian[r][j]))),
        forces: std::array::from_fn(|i| applied[i] - sum(&|r| m[r] * jacobian[r][i] * rows[r].v2)),
        energy: [
            sum(&|r| 0.5 * m[r] * rows[r].v1 * rows[r].v1),
            -p.F6 * ram.re - p.T2 * q[0]
                + p.g * (p.m3 * height(2) + p.m4 * height(5) + p.m5 * height(8))
                + 0.5 * p.k * spring * spring,
        ],
        power: -p.cd * ram.v1 * ram.v1,
        outputs: [
            ram.re,
            ram.v1,
            ram.v2,
            slide.v1,
            -multipliers[0] * slot(moved, Dual64::new(q[1], 0.0)).eps,
            -multipliers[1],
        ],
    }
}

/// Compares numbers of one function, relative to the largest of them.
fn close(what: &str, got: &[f64], expected: &[f64]) {
    assert_eq!(got.len(), expected.len(), "{what}");
    let scale = expected.iter().fold(0.0_f64, |most, e| most.max(e.abs()));
    for (got, expected) in got.iter().zip(expected) {
        assert!(
            (got - expected).abs() <= TOLERANCE * scale,
            "{what}: {got:e} instead of {expected:e} (largest {scale:e})"
        );
    }
}

/// Single numbers that are differences of large ones are compared with those.
fn close_beside(what: &str, got: f64, expected: f64, scale: f64) {
    assert!((got - expected).abs() <= TOLERANCE * scale.max(expected.abs()), "{what}: {got:e} instead of {expected:e}");
}

fn drop_row<T: Copy>(rows: &[T], dropped: usize) -> Vec<T> {
    rows.iter().enumerate().filter(|(i, _)| *i != dropped).map(|(_, row)| *row).collect()
}

macro_rules! check_functions {
    ($module:ident, $model:expr, $s:expr, $e:expr, $rows:expr) => {
        let (model, s, e) = ($model, $s, $e);
        let rows = |values: &[f64]| -> Vec<f64> { $rows(values) };
        let jacobian: Vec<f64> = (0..3).flat_map(|i| rows(&e.jacobian.map(|row| row[i]))).collect();
        let got = $module::com_jacobian(&model, &s.q);
        let got: Vec<f64> = (0..3).flat_map(|i| got.iter().map(move |row| row[i]).collect::<Vec<_>>()).collect();
        close("com_positions", &$module::com_positions(&model, &s.q), &rows(&e.positions));
        close("com_jacobian", &got, &jacobian);
        close("com_bias", &$module::com_bias(&model, &s.q, &s.qd), &rows(&e.bias));
        close("constraints", &$module::constraints(&model, &s.q), &e.constraints);
        close("constraint_jacobian", $module::constraint_jacobian(&model, &s.q).as_flattened(), e.constraint_jacobian.as_flattened());
        close("constraint_bias", &$module::constraint_bias(&model, &s.q, &s.qd), &e.constraint_bias);
        close("mass_matrix", $module::mass_matrix(&model, &s.q).as_flattened(), e.mass.as_flattened());
        close("generalized_forces", &$module::generalized_forces(&model, s.t, &s.q, &s.qd), &e.forces);
        let energy = $module::energy(&model, &s.q, &s.qd);
        close("energy", &energy[..1], &e.energy[..1]);
        close_beside("energy", energy[1], e.energy[1], e.energy[0]);
        let speed = s.p.O4B * s.qd[1].abs() + s.p.BC * s.qd[2].abs();
        close_beside("power", $module::power(&model, s.t, &s.q, &s.qd), e.power, s.p.cd * speed * speed);
        let outputs = $module::outputs(&model, s.t, &s.q, &s.qd, &s.qdd, &s.multipliers);
        let scales = [1.0, 10.0, 100.0, 10.0, s.multipliers[0].abs(), s.multipliers[1].abs()];
        for (i, scale) in scales.into_iter().enumerate() {
            close_beside("outputs", outputs[i], e.outputs[i], scale);
        }
        let dynamics = $module::dynamics(&model, s.t, &s.q, &s.qd);
        let closure = $module::closure(&model, &s.q);
        close("dynamics", dynamics.mass_matrix.as_flattened(), e.mass.as_flattened());
        close("dynamics", &dynamics.generalized_forces, &e.forces);
        close("dynamics", dynamics.constraint_jacobian.as_flattened(), e.constraint_jacobian.as_flattened());
        close("dynamics", &dynamics.constraint_bias, &e.constraint_bias);
        close("closure", &closure.constraints, &e.constraints);
        close("closure", closure.constraint_jacobian.as_flattened(), e.constraint_jacobian.as_flattened());
    };
}

/// The parameters that both scenes have.
fn plain(p: &Loaded) -> quick_return::Parameters {
    let Loaded { O2A, O4B, BC, O4O2, O4G4, BG5, yC, m3, m4, m5, m6, J2, J4, J5, F6, w0, .. } = *p;
    quick_return::Parameters { O2A, O4B, BC, O4O2, O4G4, BG5, yC, m3, m4, m5, m6, J2, J4, J5, F6, w0 }
}

#[test]
fn every_function_of_the_loaded_scene() {
    for s in samples(true) {
        check_functions!(
            quick_return_loaded,
            quick_return_loaded::QuickReturnLoaded::new(s.p),
            &s,
            expected(&s),
            |v: &[f64]| v.to_vec()
        );
    }
}

#[test]
fn every_function_of_the_plain_scene() {
    for s in samples(false) {
        // The block's angle carries no inertia there.
        check_functions!(quick_return, quick_return::QuickReturn::new(plain(&s.p)), &s, expected(&s), |v: &[f64]| {
            drop_row(v, 3)
        });
    }
}

fn check_twin(twin: &impl Equations, s: &Sample, e: &Expected) {
    let (dynamics, closure) = (twin.dynamics(&s.q, &s.qd), twin.closure(&s.q));
    close("mass matrix", dynamics.mass_matrix.as_flattened(), e.mass.as_flattened());
    close("forces", &dynamics.generalized_forces, &e.forces);
    close("jacobian", dynamics.constraint_jacobian.as_flattened(), e.constraint_jacobian.as_flattened());
    close("bias", &dynamics.constraint_bias, &e.constraint_bias);
    close("constraints", &closure.constraints, &e.constraints);
    close("jacobian", closure.constraint_jacobian.as_flattened(), e.constraint_jacobian.as_flattened());
}

#[test]
fn the_twins() {
    for s in samples(false) {
        let (hand, e) = (ByHand::new(plain(&s.p)), expected(&s));
        check_twin(&hand, &s, &e);
        check_twin(&ByDualNumbers::new(plain(&s.p)), &s, &e);
        let jacobian = drop_row(&e.jacobian, 3);
        close("T", hand.com_jacobian(&s.q).as_flattened(), jacobian.as_flattened());
        close("(T qd)_q qd", &hand.com_bias(&s.q, &s.qd), &drop_row(&e.bias, 3));
        close("C_q", hand.constraint_jacobian(&s.q).as_flattened(), e.constraint_jacobian.as_flattened());
        close("(C_q qd)_q qd", &hand.constraint_bias(&s.q, &s.qd), &e.constraint_bias);
    }
}

#[test]
fn functions_take_other_numbers() {
    // The generated source is generic: with single-precision numbers it gives single-precision results.
    #[derive(Clone, Copy, Debug)]
    struct Single(f32);
    macro_rules! operator {
        ($($name:ident $method:ident $symbol:tt),*) => {$(
            impl std::ops::$name for Single {
                type Output = Self;
                fn $method(self, other: Self) -> Self { Self(self.0 $symbol other.0) }
            }
        )*};
    }
    operator!(Add add +, Sub sub -, Mul mul *, Div div /);
    impl std::ops::Neg for Single {
        type Output = Self;
        fn neg(self) -> Self {
            Self(-self.0)
        }
    }
    macro_rules! real {
        ($($name:ident),*) => {
            impl qrm_core::Scalar for Single {
                fn from_f64(value: f64) -> Self { Self(value as f32) }
                fn sin_cos(self) -> (Self, Self) { (Self(self.0.sin()), Self(self.0.cos())) }
                fn powf(self, exponent: f64) -> Self { Self(self.0.powf(exponent as f32)) }
                fn sign(self) -> Self { Self(if self.0 == 0.0 { 0.0 } else { self.0.signum() }) }
                $(fn $name(self) -> Self { Self(self.0.$name()) })*
            }
        };
    }
    real!(sqrt, asin, acos, atan, exp, ln, sinh, cosh, tanh);
    let p = quick_return::Parameters::default();
    let s = |x: f64| Single(x as f32);
    let single = quick_return::Parameters {
        O2A: s(p.O2A),
        O4B: s(p.O4B),
        BC: s(p.BC),
        O4O2: s(p.O4O2),
        O4G4: s(p.O4G4),
        BG5: s(p.BG5),
        yC: s(p.yC),
        m3: s(p.m3),
        m4: s(p.m4),
        m5: s(p.m5),
        m6: s(p.m6),
        J2: s(p.J2),
        J4: s(p.J4),
        J5: s(p.J5),
        F6: s(p.F6),
        w0: s(p.w0),
    };
    let q = [0.3, 1.1, 2.6];
    let double = quick_return::com_positions(&quick_return::QuickReturn::new(p), &q);
    let single = quick_return::com_positions(&quick_return::QuickReturn::new(single), &q.map(s));
    for (double, single) in double.iter().zip(single) {
        assert!((double - f64::from(single.0)).abs() < 1e-6);
    }
}
