//! Whole runs by kernels against whole runs by the plain functions they stand for.

use std::fs;

use qrm_core::{Mechanism, ParameterOverrides, StateMut};
use qrm_sim::integrate::{DOP853, MethodSettings};
use qrm_sim::position::{Start, assemble_from_guesses};
use qrm_sim::run::{End, Request, Status, simulate};
use qrm_sim::solve::{Projection, ProjectionTolerance, Solver};

use crate::common::plain::Plain;
use crate::common::{qrm, run};

/// The quick-return mechanism with some parameters replaced.
fn quick_return(replace: ParameterOverrides) -> Box<dyn Mechanism> {
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
    let request = Request { step: Some(step), end: Some(End::Time(t)), ..Request::default() };
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

/// The coordinates and rates after a run of `t` seconds by the pair of order 8.
fn end_of_pair(mechanism: &dyn Mechanism, t: f64) -> Vec<f64> {
    let settings = MethodSettings::new(DOP853, 1e-10);
    let request = Request { settings, step: Some(0.1 * t), end: Some(End::Time(t)), ..Request::default() };
    let outcome = simulate(mechanism, &request, &mut ()).expect("a start");
    assert!(matches!(outcome.status, Status::Completed), "{:?}", outcome.status);
    [outcome.q, outcome.qd].concat()
}

#[test]
fn steps_of_order_8_by_kernels_are_those_by_the_plain_functions() {
    for model in qrm_model::MODELS {
        let mechanism = || model.mechanism(&|_| None);
        let t = 10.0 * mechanism().schedule().step;
        let by_kernel = end_of_pair(&*mechanism(), t);
        assert_near(model.description.name, &by_kernel, &end_of_pair(&Plain(mechanism()), t), 1e-10);
    }
}

#[test]
fn projections_by_kernels_are_those_by_the_plain_functions() {
    for model in qrm_model::MODELS {
        let mechanism = model.mechanism(&|_| None);
        let (q, qd) = assemble_from_guesses(&*mechanism, &Start::new(&*mechanism)).expect("a start");
        let move_by = |x: &[f64]| x.iter().enumerate().map(|(i, x)| x + 1e-6 * (i as f64).cos()).collect::<Vec<_>>();
        let (mut own_q, mut own_qd) = (move_by(&q), move_by(&qd));
        let mut solver = Solver::new(&*mechanism);
        solver.factor_mass(&*mechanism, &own_q);
        let projection = (Projection::Mass, ProjectionTolerance::default());
        solver.project(&*mechanism, projection, 0.0, &mut own_q, &mut own_qd).expect("near the constraints");
        let (mut q, mut qd) = (move_by(&q), move_by(&qd));
        let (mut qdd, mut multipliers) = (vec![0.0; q.len()], vec![0.0; model.description.constraints.len()]);
        let state = StateMut { q: &mut q, qd: &mut qd, qdd: &mut qdd, multipliers: &mut multipliers };
        let projected = mechanism.project(0.0, 1e-12, state).expect("the kernel suits the start");
        // The metrics are those of positions 1e-6 apart.
        assert_near(model.description.name, &q, &own_q, 1e-11);
        assert_near(model.description.name, &qd, &own_qd, 1e-10);
        let own = [projected.residual, solver.stats.residual_before_correction];
        assert!((own[0] - own[1]).abs() <= 1e-12 * own[1].max(1e-3), "{own:?}");
        let (mut expected, mut forces) = (qdd.clone(), multipliers.clone());
        solver.robust_accelerations(&*mechanism, 0.0, (&q, &qd), (&mut expected, &mut forces)).expect("determined");
        assert_near(model.description.name, &qdd, &expected, 1e-11);
        assert_near(model.description.name, &multipliers, &forces, 1e-11);
    }
}

/// Scenes give one motion, whatever the form of their kernel.
#[test]
#[ignore = "full tier: engine"]
fn kernels_of_all_forms_give_one_motion() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for scene in ["quick-return-loaded", "quick-return-driven", "slider-crank", "four-bar", "shaper", "andrews"] {
        let source = fs::read_to_string(format!("scenes/{scene}.toml")).expect("a scene");
        let ends = ["null-space", "range-space", "sparse"].map(|form| {
            let path = folder.path().join(format!("{scene}-{form}.toml")).display().to_string();
            let asks = format!("[run]\nelimination = \"{form}\"");
            fs::write(&path, source.replacen("[run]", &asks, 1)).expect("written");
            let explained = qrm(&["explain", &path]).output().expect("it starts");
            let explained = String::from_utf8_lossy(&explained.stdout).into_owned();
            let counts: Vec<&str> = explained.lines().filter(|line| line.contains("  by ")).collect();
            assert!(counts.iter().any(|line| line.contains(&format!(" {form} "))), "{explained}");
            let tolerance = ["--method", "dop853", "--tolerance", "1e-11", "--end-time", "0.03"];
            let run = run(&[&[path.as_str(), "--no-error-estimate", "--no-figures"][..], &tolerance[..]].concat());
            assert_eq!(run.status(), 0, "{scene} {form}: {}", run.stderr());
            run.summary()["end_state"].clone()
        });
        for (name, value) in ends[0].as_object().expect("numbers") {
            let [exact, range, sparse] =
                [value, &ends[1][name], &ends[2][name]].map(|value| value.as_f64().expect("a number"));
            let off = (range - exact).abs().max((sparse - exact).abs());
            assert!(off < 1e-8 * exact.abs().max(1.0), "{scene} {name}: {exact} {range} {sparse}");
        }
    }
}

/// The mass matrix of two coordinates whose sum alone is a position: its second pivot cancels.
const SUM: &str = r#"
name = "sum"
coordinates = [{ name = "x", unit = "m" }, { name = "y", unit = "m" }, { name = "z", unit = "m" }]
[points]
P = ['x + y', '0']
S = ['0', 'z']
[bodies]
p = { mass = 1, com = "P" }
s = { mass = 1, com = "S" }
[loads]
pull = { force = ['1', '1'], on = "p" }
[constraints]
bend = { residual = 'y - 0.3*z^2', unit = "m" }
[initial]
given = { x = 0, z = 1, x_dot = 0, z_dot = 0.5 }
solve = { y = 0.3 }
[run]
step = 1e-3
end_time = 0.1
"#;

#[test]
#[ignore = "full tier: engine"]
fn forms_that_are_not_possible_are_refused() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let source = fs::read_to_string("scenes/double-pendulum.toml").expect("a scene");
    // No motion changes the length of a rod.
    let fixed = "[constraints]\nrod = { residual = 'hypot(B.x - A.x, B.y - A.y) - l', unit = \"m\" }\n\n[loads]";
    let with_fixed = source.replacen("[loads]", fixed, 1);
    let path = folder.path().join("refused.toml").display().to_string();
    let without_pivot = "a coordinate has no inertia, or no motion changes a constraint";
    for (source, form, reason) in [
        (&with_fixed, "sparse", without_pivot),
        (&with_fixed, "range-space", without_pivot),
        (&SUM.to_owned(), "sparse", without_pivot),
        (&SUM.to_owned(), "range-space", without_pivot),
        (&source, "range-space", "the scene has no constraints"),
    ] {
        let asks = format!("[run]\nelimination = \"{form}\"");
        fs::write(&path, source.replacen("[run]", &asks, 1)).expect("written");
        let refused = run(&[&path]);
        assert_eq!(refused.status(), 2, "{}", refused.stderr());
        for part in [&format!("`elimination = \"{form}\"` is not possible here"), reason] {
            assert!(refused.stderr().contains(part), "{}", refused.stderr());
        }
    }
}
