//! Kernels against the plain functions they stand for: at single states, and over whole runs.

use num_dual::Dual64;
use qrm_core::{Angles, Dual, Fused, Kernel, Mechanism, Plain, Scalar, Visitor};
use qrm_model::quick_return::QuickReturn;
use qrm_model::twin::{ByHand, Twin};
use qrm_sim::assembly::assemble;
use qrm_sim::linear::Ldl;
use qrm_sim::simulate::{End, Request, simulate};
use qrm_sim::solve::{Care, Corrector, accelerations};

/// A number with its value.
trait Number: Scalar {
    fn value(self) -> f64;
}

impl Number for f64 {
    fn value(self) -> f64 {
        self
    }
}

impl Number for Fused {
    fn value(self) -> f64 {
        self.0
    }
}

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |most, value| value.abs().max(most))
}

fn assert_near(what: &str, got: &[f64], expected: &[f64], allowed: f64) {
    let scale = largest(expected).max(1.0);
    for (got, expected) in got.iter().zip(expected) {
        assert!((got - expected).abs() <= allowed * scale, "{what}: {got} instead of {expected}");
    }
}

/// Every part of a kernel at one state; whether it suits the position.
fn compare<X: Mechanism<N, M>, R: Number, const N: usize, const M: usize>(
    mechanism: &X,
    t: f64,
    q: &[f64; N],
    qd: &[f64; N],
) -> bool {
    let mut values = Vec::new();
    mechanism.visit_parameters(&mut |value| values.push(value));
    let kernel = X::Kernel::<R>::with_values(|i| R::from_f64(values[i]));
    let (at, rates) = (q.map(R::from_f64), qd.map(R::from_f64));
    let angles = Angles::new(&at, X::Kernel::<R>::IS_ANGLE);
    let position = kernel.position(R::from_f64(t), &at, &angles);
    let strain = kernel.strain(&position).value();
    if !(strain < 20.0) {
        return false;
    }
    let (dynamics, closure) = (mechanism.dynamics(t, q, qd), mechanism.closure(t, q));
    let mut care = Care::default();
    let Ok(solution) = accelerations(&dynamics, &mut care) else { return false };
    let (qdd, multipliers) = kernel.accelerations(&position, R::from_f64(t), &at, &rates, &angles);
    let name = X::DESCRIPTION.name;
    assert_near(name, &kernel.residuals(&position).map(R::value), &closure.constraints, 1e-14);
    assert_near(name, &kernel.drift(&position, &rates).map(R::value), &closure.drift(qd), 1e-14);
    assert_near(name, &qdd.map(R::value), &solution.qdd, 1e-11);
    assert_near(name, &multipliers.map(R::value), &solution.multipliers, 1e-11);
    let mut moved = [0.0; N];
    let open: [f64; M] = std::array::from_fn(|k| 0.01 * (k as f64 + 1.0));
    let mass = Ldl::new(&dynamics.mass_matrix).expect("definite");
    Corrector::new(&closure.constraint_jacobian, Some(&mass)).correct(&mut moved, &open, &mut care);
    let correction = kernel.correction(&position, &open.map(R::from_f64)).map(R::value);
    assert_near(name, &correction, &moved, 1e-12 * strain.max(1.0));
    true
}

struct Compared(usize);

impl Visitor for Compared {
    fn visit<X: Mechanism<N, M> + 'static, const N: usize, const M: usize>(&mut self) {
        let mechanism = X::with_parameters(&|_| None);
        let (q, qd) = assemble(&mechanism, &mechanism.start()).expect("a start");
        let mut random = fastrand::Rng::with_seed(11);
        let mut near = |x: f64| x + 2.0 * (random.f64() - 0.5);
        let mut suited = 0;
        for _ in 0..1000 {
            let (q, qd) = (q.map(&mut near), qd.map(&mut near));
            let fused = compare::<X, Fused, N, M>(&mechanism, 0.1, &q, &qd);
            suited += usize::from(compare::<X, f64, N, M>(&mechanism, 0.1, &q, &qd) && fused);
        }
        assert!(suited > 500, "{}: compared at {suited} of 1000 states", X::DESCRIPTION.name);
        self.0 += 1;
    }
}

#[test]
fn kernels_give_what_the_plain_functions_give() {
    let mut compared = Compared(0);
    qrm_model::visit_all(&mut compared);
    compared.visit::<Twin<ByHand>, 3, 2>();
    assert!(compared.0 >= 3);
}

/// Accelerations and multipliers by the kernel at one state: coordinates, rates, and the values of the parameters.
fn equations<R: Scalar>(state: &[R], parameters: &[R]) -> [R; 5] {
    let kernel = QuickReturn::<R>::with_values(|i| parameters[i]);
    let (q, qd) = (std::array::from_fn(|i| state[i]), std::array::from_fn(|i| state[3 + i]));
    let angles = Angles::new(&q, QuickReturn::<R>::IS_ANGLE);
    let ([a2, a4, a5], [slot, guide]) =
        Kernel::accelerations(&kernel, &kernel.position(R::zero(), &q, &angles), R::zero(), &q, &qd, &angles);
    [a2, a4, a5, slot, guide]
}

#[test]
fn kernels_differentiate_with_dual_numbers() {
    let state = [0.5, 1.15, 2.69, 7.7, 2.8, 1.5];
    let mut values = state.to_vec();
    QuickReturn::default().visit_parameters(&mut |value| values.push(value));
    let at = |values: &[f64]| equations(&values[..6], &values[6..]);
    for i in 0..values.len() {
        let dual: Vec<Dual<Dual64>> =
            (0..values.len()).map(|j| Dual(Dual64::new(values[j], if i == j { 1.0 } else { 0.0 }))).collect();
        let exact = equations(&dual[..6], &dual[6..]);
        // Central differences of fourth order.
        let h = 1e-3 * values[i].abs().max(0.1);
        let moved = |by: f64| {
            let mut moved = values.clone();
            moved[i] += by * h;
            at(&moved)
        };
        let [a, b, c, d] = [moved(-2.0), moved(-1.0), moved(1.0), moved(2.0)];
        for k in 0..5 {
            let difference = (a[k] - 8.0 * b[k] + 8.0 * c[k] - d[k]) / (12.0 * h);
            let (value, slope) = (exact[k].0.re, exact[k].0.eps);
            assert!((value - at(&values)[k]).abs() <= 1e-13 * value.abs().max(1.0), "value {k}: {value:e}");
            assert!((slope - difference).abs() <= 1e-7 * slope.abs().max(1.0), "{k} by {i}: {slope:e}, {difference:e}");
        }
    }
}

/// The end of a run to a time.
fn end<X: Mechanism<3, 2>>(mechanism: &X, step: f64, t: f64) -> [f64; 6] {
    let request =
        Request { method: Default::default(), step: Some(step), end: Some(End::Time(t)), estimate_error: false };
    let outcome = simulate(mechanism, &request, &mut ()).expect("a start");
    std::array::from_fn(|i| if i < 3 { outcome.q[i] } else { outcome.qd[i - 3] })
}

/// The state at t = 0.5, exactly.
const HALF: [f64; 6] = [
    3.602_119_026_059_779_6,
    2.274_506_384_184_564_4,
    2.484_927_832_307_542,
    6.807_880_256_955_884,
    1.184_065_142_088_816_7,
    -1.128_541_919_454_831,
];

#[test]
fn whole_runs_are_no_less_accurate() {
    let error = |state: [f64; 6]| std::array::from_fn::<f64, 6, _>(|i| (state[i] - HALF[i]).abs());
    for step in [1e-3, 5e-4, 1e-4, 2e-5] {
        let kernel = error(end(&QuickReturn::default(), step, 0.5));
        let plain = error(end(&Plain(QuickReturn::default()), step, 0.5));
        for (kernel, plain) in kernel.iter().zip(plain) {
            assert!(*kernel <= plain + 1e-13, "step {step}: {kernel:e} instead of {plain:e}");
        }
    }
}

#[test]
fn steps_of_any_length_are_made() {
    // Corrections are large here, and turns longer than the series are for.
    for step in [5e-3, 2e-2, 5e-2] {
        let kernel = end(&QuickReturn::default(), step, 0.5);
        let plain = end(&Plain(QuickReturn::default()), step, 0.5);
        let error = largest(&std::array::from_fn::<f64, 6, _>(|i| plain[i] - HALF[i]));
        assert_near("run", &kernel, &plain, 1e-3 * error);
    }
}

#[test]
fn a_position_that_does_not_suit_the_kernel_is_stepped_through() {
    // Where the rod stands upright the ram's guide does not tell its rate, but stops rocker and crank, which turn back.
    let upright = QuickReturn::with_parameters(&|name| match name {
        "yC" => Some(1.15),
        "w0" => Some(-1.0),
        "F6" => Some(0.0),
        _ => None,
    });
    let (kernel, plain) = (end(&upright, 1e-4, 0.5), end(&Plain(upright), 1e-4, 0.5));
    assert!(kernel[2] < std::f64::consts::FRAC_PI_2 && kernel[3] > 0.0, "{kernel:?}");
    assert_near("run", &kernel, &plain, 1e-9);
}
