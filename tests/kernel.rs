//! Whole runs by kernels against whole runs by the plain functions they stand for.

#[path = "common/plain.rs"]
mod plain;

use plain::Plain;
use qrm_core::{Mechanism, Replace};
use qrm_sim::integrate::MethodSettings;
use qrm_sim::run::{End, Request, simulate};

/// The quick-return mechanism with some parameters replaced.
fn quick_return(replace: Replace) -> Box<dyn Mechanism> {
    let mut models = qrm_model::MODELS.iter();
    models.find(|model| model.description.name == "quick-return").expect("the scene is built").mechanism(replace)
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

/// The end of a run to a time.
fn end(mechanism: &dyn Mechanism, step: f64, t: f64) -> [f64; 6] {
    let request = Request {
        settings: MethodSettings::default(),
        step: Some(step),
        end: Some(End::Time(t)),
        estimate_error: false,
    };
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
        let kernel = error(end(&*quick_return(&|_| None), step, 0.5));
        let plain = error(end(&Plain(quick_return(&|_| None)), step, 0.5));
        for (kernel, plain) in kernel.iter().zip(plain) {
            assert!(*kernel <= plain + 1e-13, "step {step}: {kernel:e} instead of {plain:e}");
        }
    }
}

#[test]
fn steps_of_any_length_are_made() {
    // Corrections are large here, and turns longer than the series are for.
    for step in [5e-3, 2e-2, 5e-2] {
        let kernel = end(&*quick_return(&|_| None), step, 0.5);
        let plain = end(&Plain(quick_return(&|_| None)), step, 0.5);
        let error = largest(&std::array::from_fn::<f64, 6, _>(|i| plain[i] - HALF[i]));
        assert_near("run", &kernel, &plain, 1e-3 * error);
    }
}

#[test]
fn a_position_that_does_not_suit_the_kernel_is_stepped_through() {
    // Where the rod stands upright the ram's guide does not tell its rate, but stops rocker and crank, which turn back.
    let replace = |name: &str| match name {
        "yC" => Some(1.15),
        "w0" => Some(-1.0),
        "F6" => Some(0.0),
        _ => None,
    };
    let (kernel, plain) = (end(&*quick_return(&replace), 1e-4, 0.5), end(&Plain(quick_return(&replace)), 1e-4, 0.5));
    assert!(kernel[2] < std::f64::consts::FRAC_PI_2 && kernel[3] > 0.0, "{kernel:?}");
    assert_near("run", &kernel, &plain, 1e-9);
}
