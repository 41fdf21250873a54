//! Extremes and integrals of outputs that change fast between rows, against closed forms.

use std::fs;
use std::path::Path;

use serde_json::Value;

use crate::common::{Table, qrm, run};
use crate::random_conditions::expression;

fn scene(name: &str) -> String {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/extremes").join(name).with_extension("toml").display().to_string()
}

/// Compares an extreme with the exact one, within three stated errors.
fn compare(found: &Value, end: &str, exact: f64, what: &str) {
    let value = found[end].as_f64().expect("a number");
    let stated = found[format!("{end}_error")].as_f64().expect("an error");
    let error = (value - exact).abs();
    assert!(error <= 3.0 * stated + 4.0 * f64::EPSILON * exact.abs(), "{what}: {value} for {exact}, stated {stated:e}");
    assert!(stated <= 1e-9 * exact.abs(), "{what}: {value} with an error of {stated:e}");
}

/// A peak of width 0.01, a hat of a table, a bell curve and fast sines of `x = t`, by steps up to the whole motion.
#[test]
#[ignore = "full tier: engine"]
fn narrow_peaks_between_rows_are_found() {
    let steps = ["0.001", "0.0137", "0.1", "1"];
    for (method, steps) in
        [("rk4", &steps[..3]), ("dop853", &steps[..]), ("dopri5", &steps[1..]), ("gauss", &steps[..3])]
    {
        for step in steps {
            let run = run(&[&scene("narrow"), "--no-figures", "--method", method, "--step", step]);
            assert_eq!(run.status(), 0, "{}", run.stderr());
            let what = |column: &str| format!("{column} by {method}, step {step}");
            let extremes = &run.summary()["extremes"];
            compare(&extremes["p"], "max", 10_000.0, &what("p"));
            compare(&extremes["h"], "max", 1.0, &what("h"));
            compare(&extremes["g"], "max", 1.0, &what("g"));
            compare(&extremes["b"], "min", -0.934_377_749_556_444_1, &what("b"));
            for (column, exact) in [("a", 1.0), ("q", 40.0)] {
                compare(&extremes[column], "min", -exact, &what(column));
                compare(&extremes[column], "max", exact, &what(column));
            }
        }
    }
}

/// Long steps: two peaks that differ by less than errors, an extreme in the first step, and runs of one to three steps.
#[test]
#[ignore = "full tier: engine"]
fn errors_of_extremes_hold_in_few_steps() {
    let cases = [
        ("two-peaks", "1", &["0.02", "0.01", "0.005"]),
        ("first-step", "0.6", &["0.004", "0.002", "0.001"]),
        ("pendulum", "0.3", &["0.15", "0.1", "0.25"]),
    ];
    for (name, end_time, steps) in cases {
        let path = scene(name);
        let extremes = |by: &[&str]| {
            let run = run(&[&[&path, "--end-time", end_time, "--no-figures"], by].concat());
            // A run that is rejected has errors too.
            assert!(run.status() <= 1, "{}", run.stderr());
            run.summary()["extremes"].clone()
        };
        let exact = extremes(&["--method", "dop853", "--tolerance", "1e-13"]);
        for step in steps {
            for (column, found) in extremes(&["--method", "rk4", "--step", step]).as_object().expect("extremes") {
                for end in ["min", "max"] {
                    let value = |of: &Value| of[end].as_f64().expect("a number");
                    let stated = |of: &Value| of[format!("{end}_error")].as_f64().expect("an error");
                    let (own, exact) = (found, &exact[column]);
                    let error = (value(own) - value(exact)).abs();
                    let known = 3.0 * stated(own) + stated(exact) + 1e-12 * (1.0 + value(exact).abs());
                    assert!(
                        error <= known,
                        "{end} of {column}, {name} --step {step}: {error:e}, known within {known:e}"
                    );
                }
            }
        }
    }
}

/// The rocker stands still twice: the ratio of the rates grows without bound on both sides.
#[test]
#[ignore = "full tier: engine"]
fn poles_between_rows_are_unbounded() {
    for arguments in [&[][..], &["--step", "3e-4"], &["--method", "dop853", "--step", "0.05"]] {
        let run = run(&[&[scene("mechanical-advantage").as_str(), "--no-figures"], arguments].concat());
        assert_eq!(run.status(), 0, "{}", run.stderr());
        let summary = run.summary();
        let found = &summary["extremes"]["advantage"];
        for end in ["min", "max"] {
            assert!(found[end].is_null(), "{arguments:?}: {found}");
            let t = found[format!("{end}_time")].as_f64().expect("a time");
            assert!([0.028_569, 0.348_509].iter().any(|pole| (t - pole).abs() < 1e-6), "{arguments:?}: {t}");
        }
        assert!(run.stdout().contains("unbounded"), "{}", run.stdout());
    }
}

/// `1/(x - 1)^2` and `1/(x - 1)` for `x = t`: no number of a row at the pole is known.
#[test]
#[ignore = "full tier: engine"]
fn a_pole_on_a_row_ends_the_run() {
    for method in ["rk4", "dop853", "dopri5", "gauss"] {
        for (step, end) in [("0.1", "3"), ("0.25", "3"), ("0.3", "1"), ("0.07", "1")] {
            let scene = scene("pole-on-a-row");
            let run = run(&[&scene, "--no-figures", "--method", method, "--step", step, "--end-time", end]);
            assert!(run.stderr().contains("output `a` is not finite at t = 1 s"), "{method}, {step}: {}", run.stderr());
        }
        let run = run(&[&scene("pole-on-a-row"), "--no-figures", "--method", method, "--step", "0.3"]);
        assert_eq!(run.status(), 0, "{method}: {}", run.stderr());
        let extremes = &run.summary()["extremes"];
        compare(&extremes["a"], "min", 0.25, method);
        let unbounded = [("a", "max"), ("b", "min"), ("b", "max")];
        assert!(unbounded.iter().all(|(output, end)| extremes[output][end].is_null()), "{method}: {extremes}");
    }
}

#[test]
#[ignore = "full tier: engine"]
fn an_output_that_is_undefined_between_rows_ends_the_run() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("undefined.toml");
    let text = fs::read_to_string(scene("narrow")).expect("the scene");
    fs::write(&file, text.replace("a = { value = 'sin(40*x)' }", "a = { value = 'asin(1.0001*sin(3*x))' }"))
        .expect("a file");
    for step in ["0.02", "0.1"] {
        let run = run(&[&file.display().to_string(), "--no-figures", "--step", step]);
        assert_ne!(run.status(), 0);
        assert!(run.stderr().contains("output `a` is not finite at t = 0.5"), "{}", run.stderr());
    }
}

/// The integral of a bell curve, sqrt(pi)/100 over v, and that of a peak with long tails, 100 (atan(40) + atan(60)) for
/// v = 1. A change of v moves the peaks, and the end of the second.
#[test]
#[ignore = "full tier: engine"]
fn integrals_of_narrow_outputs_have_their_digits() {
    let bell = std::f64::consts::PI.sqrt() / 100.0;
    let tails = 100.0 * (40_f64.atan() + 60_f64.atan());
    for arguments in [&["--step", "0.1"][..], &["--step", "0.01"], &["--method", "dop853", "--step", "0.5"]] {
        for (output, exact, by_v) in [("g", bell, -bell), ("p", tails, 1.0 / 0.1601 - tails)] {
            let folder = tempfile::tempdir().expect("a temporary folder");
            let run = qrm(&["sensitivity", &scene("narrow"), "--by", "v", "--of", output])
                .args(arguments)
                .arg("--out")
                .arg(folder.path())
                .output()
                .expect("it starts");
            assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
            let text = fs::read_to_string(folder.path().join("sensitivity.csv")).expect("a table");
            let line = text.lines().find(|line| line.contains("integral")).expect("a row of the integral");
            let numbers: Vec<f64> = line.split(',').filter_map(|field| field.parse().ok()).collect();
            assert!((numbers[0] - exact).abs() < 1e-8 * exact, "{arguments:?}: {line}");
            assert!((numbers[1] - by_v).abs() < 1e-7 * exact, "{arguments:?}: {line}");
        }
    }
}

/// 600 turns in 721 rows, and 720 turns in rows at equal angles, which show a constant torque.
#[test]
#[ignore = "full tier: engine"]
fn inverse_dynamics_look_between_rows() {
    let results = |arguments: &[&str]| -> Value {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let output = qrm(&["inverse"]).args(arguments).arg("--out").arg(folder.path()).output().expect("it starts");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let text = fs::read_to_string(folder.path().join("inverse.json")).expect("a summary");
        serde_json::from_str::<Value>(&text).expect("JSON")["results"].clone()
    };
    let number = |value: &Value| value.as_f64().expect("a number");
    let torque = &results(&[&scene("crank-at-3000-rpm")])["torque_O_drive"];
    let error = number(&torque["extreme_error"]);
    assert!((number(&torque["maximum"][0]) - 170.762_860_720_811).abs() <= 3.0 * error && error < 1e-8, "{torque}");
    let (mean, error) = (number(&torque["root_mean_square"]), number(&torque["mean_error"]));
    assert!((mean - 99.751_765_288_03).abs() <= 3.0 * error && error < 1e-8, "{torque}");
    let [turn, turns] = [&["quick-return"][..], &["quick-return", "--distance", "1440*pi"]].map(results);
    for (end, place) in [("minimum", 0), ("maximum", 0)] {
        let [one, many] = [&turn, &turns].map(|results| number(&results["torque_phi2"][end][place]));
        assert!((one - many).abs() < 1e-8 * one.abs(), "{end}: {one} {many}");
    }
    assert!(number(&turns["torque_phi2"]["mean"]).abs() < 1e-8);
}

/// The text of a scene with random outputs of `x = t`, `psi = 3 t + 1` and `t`.
fn random_scene(random: &mut fastrand::Rng) -> String {
    let terms = [("x", 1.0, 1.0), ("psi", 4.0, 3.0), ("t", 1.0, 1.0)]
        .map(|(name, middle, half)| (name.to_owned(), middle, half));
    let mut output = |i: usize| {
        let depth = random.u32(1..4);
        let formula = expression(random, &terms, depth);
        // The sign of zero is zero: a formula with it may jump to another value at a single time.
        let formula = match random.u32(..if formula.contains("sign") { 1 } else { 6 }) {
            _ if formula.contains("sign") => formula,
            0 => format!("1/({formula} + 0.37)"),
            1 => format!("log(abs({formula}))"),
            2 => format!("exp(-(({formula} - 0.2)/0.02)^2)"),
            3 => format!("1/(1e-4 + ({formula})^2)"),
            _ => formula,
        };
        format!("o{i} = '{formula}'\n")
    };
    let outputs: String = (0..6).map(&mut output).collect();
    format!(
        "name = \"random-outputs\"\ncoordinates = [{{ name = \"x\", unit = \"m\" }}, \"psi\"]\n\
         [points]\nP = ['x', '0']\n[bodies]\nb = {{ mass = 1, com = \"P\" }}\nr = {{ angle = 'psi', inertia = 1 }}\n\
         [initial]\ngiven = {{ x = 0, x_dot = 1, psi = 1, psi_dot = 3 }}\n[run]\nstep = 1e-3\nend_time = 2\n\
         [outputs]\n{outputs}"
    )
}

/// The smallest and the largest value of a column in rows. Values of single rows do not count: where a sign is zero, a
/// formula may have a value of its own.
fn range_of_rows(table: &Table, column: &str) -> [f64; 2] {
    let values: Vec<f64> = (0..table.rows.len()).map(|row| table.number(row, column)).collect();
    let pairs = values.windows(2).map(|pair| [pair[0].max(pair[1]), pair[0].min(pair[1])]);
    pairs.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], [a, b]| [low.min(a), high.max(b)])
}

/// No row of a finer run lies beyond the extremes that coarse runs state.
#[test]
#[ignore = "full tier: engine"]
fn no_row_exceeds_the_extremes_of_random_outputs() {
    let mut random = fastrand::Rng::with_seed(5);
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("random.toml");
    let mut compared = 0;
    for _ in 0..40 {
        let text = random_scene(&mut random);
        fs::write(&file, &text).expect("a file");
        let file = file.display().to_string();
        let fine = run(&[&file, "--no-figures", "--step", "1e-4"]);
        // Some formulae have no value at a row, or too many parts.
        if fine.status() != 0 {
            continue;
        }
        let table = fine.trajectory();
        for arguments in [["rk4", "0.0137"], ["dop853", "2"], ["gauss", "0.05"], ["dopri5", "0.3"]] {
            let [method, step] = arguments;
            let coarse = run(&[&file, "--no-figures", "--method", method, "--step", step]);
            if coarse.status() != 0 || coarse.stdout().contains("are those of rows") {
                continue;
            }
            let summary = coarse.summary();
            for i in 0..6 {
                let name = format!("o{i}");
                let found = &summary["extremes"][&name];
                let range = range_of_rows(&table, &name);
                for (end, of_rows, sign) in [("min", range[0], -1.0), ("max", range[1], 1.0)] {
                    let Some(value) = found[end].as_f64() else { continue };
                    compared += 1;
                    let error = found[format!("{end}_error")].as_f64().unwrap_or(0.0);
                    let rounding = 1e-11 * (range[1] - range[0]).max(of_rows.abs());
                    assert!(
                        sign * (of_rows - value) <= 3.0 * error + rounding,
                        "{name} by {method}, step {step}: {end} {value}, error {error:e}, {of_rows} in a row\n{text}"
                    );
                }
            }
        }
    }
    assert!(compared > 300, "{compared} compared");
}
