//! The build script has verified every generated function; here the compiled ones are compared with differences of
//! what they are derivatives of, and with closed forms.
use qrm_core::{Equations, Generated};
use qrm_functions::functions::{Functions, constraint_jacobian, constraints, outputs};

const Q: [f64; 3] = [0.7, -1.1, 0.4];
const QD: [f64; 3] = [0.3, 0.5, -0.8];
const QDD: [f64; 3] = [1.5, -0.4, 0.9];

/// The values of the parameters, one of them replaced.
fn values(replaced: &str, value: f64) -> Vec<f64> {
    let mut models = qrm_functions::MODELS.iter();
    let model = models.find(|model| model.description.name == "functions").expect("a generated scene");
    model.parameter_values(&|name| (name == replaced).then_some(value))
}

fn place(name: &str) -> usize {
    let outputs = Functions::<f64>::DESCRIPTION.outputs;
    outputs.iter().position(|o| o.name == name).unwrap_or_else(|| panic!("no output {name}"))
}

fn at(t: f64) -> [f64; 3] {
    std::array::from_fn(|i| Q[i] + t * QD[i] + 0.5 * t * t * QDD[i])
}

/// Second difference of order 4 of a function of the moving coordinates.
fn second_difference(f: impl Fn([f64; 3]) -> f64) -> f64 {
    let h = 2e-3;
    let v = |n: f64| f(at(n * h));
    (-v(-2.0) + 16.0 * v(-1.0) - 30.0 * v(0.0) + 16.0 * v(1.0) - v(2.0)) / (12.0 * h * h)
}

#[test]
fn second_rates() {
    let got = outputs(&Functions::default(), 0.3, &Q, &QD, &QDD, &[2.0]);
    let check = |name: &str, f: &dyn Fn([f64; 3]) -> f64| {
        let (got, expected) = (got[place(name)], second_difference(f));
        assert!((got - expected).abs() <= 1e-8 * expected.abs().max(1.0), "{name}: {got} instead of {expected}");
    };
    check("tan_second", &|[_, _, a]| (a / 3.0).tan());
    check("asin", &|[p, _, _]| (p / 4.0).asin());
    check("acos", &|[p, _, _]| (p / 4.0).acos());
    check("atan", &|[p, q, _]| (p * q).atan());
    check("exp", &|[p, _, _]| (-p * p / 9.0).exp());
    check("log", &|[_, q, _]| (q * q + 1.0).ln());
    check("sinh", &|[p, _, _]| p.sinh());
    check("cosh", &|[_, q, _]| q.cosh());
    check("tanh", &|[p, q, _]| (p - q).tanh());
    check("power", &|[p, q, _]| (p * p + 1.0).cbrt() + (q * q + 2.0).powf(-1.25) + (p * p + 1.0).powf(2.5));
    let decimals = |[p, q, a]: [f64; 3]| 0.2 * p * p + 1e-3 * q.powi(3) / 0.7 + 123_456_789.123_456_79 * a.sin();
    let (got, expected) = (got[place("decimals")], second_difference(decimals));
    assert!((got - expected).abs() <= 1e-7 * expected.abs(), "{got} instead of {expected}");
}

#[test]
fn values_and_rates() {
    let got = outputs(&Functions::default(), 0.3, &Q, &QD, &QDD, &[2.0]);
    let [p, q, a] = Q;
    let near = |name: &str, expected: f64| {
        let got = got[place(name)];
        assert!((got - expected).abs() <= 1e-14 * expected.abs().max(1.0), "{name}: {got} instead of {expected}");
    };
    near("tan_value", (a / 3.0).tan());
    near("tan_rate", QD[2] / 3.0 / (a / 3.0).cos().powi(2));
    near("pi_value", (std::f64::consts::PI / 6.0 + p).sin() * (a + p * q).cos().powi(3));
    let w = 1.0 + q * q;
    near("extreme", QD[0] + QD[0] / w.powi(3) - 6.0 * p * q * QD[1] / w.powi(4));
}

#[test]
fn jacobian_against_differences() {
    let (model, h) = (Functions::default(), 1e-4);
    let jacobian = constraint_jacobian(&model, &Q);
    for i in 0..3 {
        let moved = |n: f64| {
            let mut q = Q;
            q[i] += n * h;
            constraints(&model, &q)[0]
        };
        let expected = (moved(-2.0) - 8.0 * moved(-1.0) + 8.0 * moved(1.0) - moved(2.0)) / (12.0 * h);
        assert!((jacobian[0][i] - expected).abs() < 1e-10, "{i}: {} instead of {expected}", jacobian[0][i]);
    }
}

#[test]
fn a_parameter_that_is_zero_only_for_now_is_kept() {
    let at = |zero: f64| {
        let values = values("zero", zero);
        Functions::with_values(&|i| values[i]).dynamics(0.3, &Q, &QD).generalized_forces
    };
    let (without, with) = (at(0.0), at(4.0));
    // load = -m zero = -10 N, along p.
    assert!((with[0] - without[0] + 10.0).abs() < 1e-12, "{without:?} {with:?}");
}

#[test]
fn start_schedule_and_dependent_parameters() {
    let values = values("m", 4.0);
    let model = Functions::<f64>::with_values(&|i| values[i]);
    assert_eq!(model.schedule().step, 4e-3);
    assert!((model.schedule().end_time - std::f64::consts::PI / 5.0).abs() < 1e-15);
    assert_eq!(model.start().given, [true, true, false]);
    assert_eq!(model.start().given_rates, [true, true, false]);
    assert_eq!(values, [3.0, 4.0, 8.0 + 2.0_f64.sqrt(), 1e250, 1e-250, 64.0, 0.0, -0.0]);
    assert_eq!(Functions::<f64>::DESCRIPTION.left_out, ["off"]);
}
