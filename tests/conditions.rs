//! Conditions on every name that a state gives: where they end motions, by all methods.

use std::f64::consts::PI;
use std::fs;

use qrm_sim::analysis::{SensitivityRequest, sensitivity};
use qrm_sim::integrate::{DOP853, MethodSettings, RK4};
use qrm_sim::run::{End, Request, simulate};

use crate::common::{Table, event, mechanism, model, near, qrm, run};

/// A condition, and the column that it names.
const CONDITIONS: [(&str, &str, f64); 11] = [
    ("phi4_dot <= -1", "phi4_dot", -1.0),
    ("phi4_ddot >= 40", "phi4_ddot", 40.0),
    ("lambda_guide <= -200", "lambda_guide", -200.0),
    ("x6 <= -0.5", "x6", -0.5),
    ("x6_dot >= 1", "x6_dot", 1.0),
    ("x6_ddot <= -20", "x6_ddot", -20.0),
    ("v_slide <= 0.5", "v_slide", 0.5),
    ("N6 >= 200", "N6", 200.0),
    ("C.x_dot >= 1", "x6_dot", 1.0),
    // A jump, and a value that stays where it is.
    ("sign(N6 - 200) >= 0.5", "N6", 200.0),
    ("min(N6, 200) >= 200", "N6", 200.0),
];

#[test]
fn the_last_row_is_where_the_condition_becomes_true() {
    for (condition, column, value) in CONDITIONS {
        let mut times = Vec::new();
        for method in ["rk4", "dop853", "gauss", "auto"] {
            let run = run(&["quick-return-loaded", "--until", condition, "--method", method]);
            assert_eq!(run.status(), 0, "{condition} by {method}: {}", run.stderr());
            let table = run.trajectory();
            let reached = table.number(table.last(), column);
            near(&format!("{condition} by {method}"), reached, value, 1e-9 * value.abs());
            times.push(table.number(table.last(), "t"));
        }
        for (method, time) in times.iter().enumerate() {
            near(&format!("the time of {condition} by method {method}"), *time, times[1], 1e-6);
        }
    }
}

/// The crank turns by 3 rad in 0.411621572336896 s, by Gauss steps at a tolerance of 1e-14.
#[test]
fn conditions_that_jump_or_stay_true_end_where_they_become_true() {
    for condition in ["phi2 >= 3", "min(phi2, 3) >= 3", "sign(phi2 - 3) >= 1", "max(3 - phi2, 0) <= 0"] {
        for (method, step) in [("rk4", "1e-3"), ("rk4", "0.01"), ("dop853", "0.1"), ("gauss", "0.1")] {
            let run = run(&["quick-return", "--until", condition, "--method", method, "--step", step]);
            assert_eq!(run.status(), 0, "{condition} by {method}: {}", run.stderr());
            let summary = run.summary();
            let number = |name: &str| summary[name].as_f64().unwrap_or_else(|| panic!("{condition}: {name}"));
            let error = number("end_time_error");
            near(&format!("{condition} by {method}"), number("end_time"), 0.411_621_572_336_896, 3.0 * error);
            assert!(error < 1e-6, "{condition} by {method}: {error}");
        }
    }
}

/// The crank is upright at 0.20799806553571 s and level at 0.43235720533686 s, by Gauss steps at a tolerance of 1e-14.
#[test]
fn conditions_that_only_touch_their_bound_are_met() {
    for (condition, t) in [("sin(phi2) >= 1", 0.207_998_065_535_71), ("cos(phi2) <= -1", 0.432_357_205_336_86)] {
        for (method, step) in
            [("rk4", "1e-3"), ("rk4", "7e-4"), ("dop853", "0.5"), ("dopri5", "0.3"), ("gauss", "0.05")]
        {
            let run = run(&["quick-return", "--until", condition, "--method", method, "--step", step]);
            assert_eq!(run.status(), 0, "{condition} by {method}: {}", run.stderr());
            let summary = run.summary();
            let number = |name: &str| summary[name].as_f64().unwrap_or_else(|| panic!("{condition}: {name}"));
            near(&format!("{condition} by {method}"), number("end_time"), t, 1e-11);
            // The sine differs from one by a rounding error for that long.
            assert!((1e-10..1e-8).contains(&number("end_time_error")), "{condition}: {}", number("end_time_error"));
        }
    }
}

/// The largest value of `y = 1 - cos(t)` is 2, at t = pi. Steps reach it with an error.
#[test]
#[ignore = "full tier: engine"]
fn a_maximum_within_errors_of_the_bound_is_not_passed_over() {
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/extremes/swing.toml");
    for (condition, method, step) in [
        ("y >= 2", "dop853", "0.5"),
        ("y >= 2", "dop853", "2"),
        ("y >= 2", "dop853", "10"),
        ("y_ddot <= -1", "dop853", "0.1"),
        ("y_ddot <= -1", "gauss", "1"),
        ("y_ddot <= -1", "rk4", "0.5"),
        ("abs(y_ddot) <= 0", "gauss", "1"),
    ] {
        let run = run(&[scene, "--until", condition, "--method", method, "--step", step]);
        let time = if condition.starts_with("abs") { "1.570796" } else { "3.141593" };
        let is_named = run.stderr().contains(&format!("may have become true at t = {time} s"));
        let end = run.summary()["end_time"].as_f64().expect("a number");
        let is_met = run.status() == 0 && (end - time.parse::<f64>().expect("a number")).abs() < 1e-3;
        assert!(is_named || is_met, "{condition} by {method}, step {step}: {}", run.stderr());
    }
    // Masses by which the largest value is 2 within errors of the motion: no design ends at the next maximum.
    let folder = tempfile::tempdir().expect("a temporary folder");
    let table = folder.path().join("sweep.csv");
    let sweep =
        qrm(&["sweep", scene, "--until", "y >= 2", "--vary", "m=1-1e-8:1+1e-8:41", "--out"]).arg(&table).output();
    assert!(sweep.is_ok());
    let rows = std::fs::read_to_string(&table).expect("the table");
    let done: Vec<f64> = rows
        .lines()
        .filter_map(|row| row.split_once(",done,,"))
        .map(|(_, rest)| rest.split(',').next().and_then(|end| end.parse().ok()).expect("an end time"))
        .collect();
    assert!(done.len() > 10 && done.iter().all(|end| (end - PI).abs() < 1e-3), "{done:?}");
    // A zero without a change of sign, where the motion is exact.
    let run = run(&[scene, "--until", "-(x - 2.345)^2 >= 0", "--step", "0.37"]);
    assert_eq!(run.status(), 0, "{}", run.stderr());
    near("the time of the zero", run.summary()["end_time"].as_f64().expect("a number"), 2.345, 1e-14);
}

/// The force of the slider lies between -6.374119509036878 and 5.757269233968793 N; the times are those of 40 digits.
#[test]
#[ignore = "full tier: engine"]
fn conditions_on_forces_hold_at_dead_points_too() {
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/singular/dead-points.toml");
    for (method, step) in [("dop853", "0.1"), ("dopri5", "0.05"), ("gauss", "1e-3"), ("rk4", "1e-3")] {
        for (condition, t) in [
            ("F >= 5.758", None),
            ("F <= -6.3742", None),
            ("F >= 5.757269", Some(0.333_293_243_030_458)),
            ("F >= 5.75726", Some(0.333_081_475_944_487)),
        ] {
            let run = run(&[scene, "--until", condition, "--method", method, "--step", step, "--no-figures"]);
            match t {
                Some(t) => {
                    assert_eq!(run.status(), 0, "{condition} by {method}: {}", run.stderr());
                    let found = run.summary()["end_time"].as_f64().expect("a number");
                    near(&format!("{condition} by {method}"), found, t, 1e-11);
                }
                None => {
                    assert!(run.stderr().contains("did not become true"), "{condition} by {method}: {}", run.stderr())
                }
            }
        }
    }
}

/// The times at which 300 times the angle is 30 degrees, and at which the angle is one radian: Gauss steps at 1e-14.
#[test]
fn conditions_that_are_true_for_moments_are_met() {
    let cases = [
        ("sin(300*phi2) >= 0.5", 0.000_222_231_502_719_24),
        ("1/(phi2 - 1) >= 1e6", 0.130_494_378_600_05),
        ("1e-5 - abs(phi2 - 1) >= 0", 0.130_493_040_683_66),
        // Large exponentials have no bound.
        ("tanh(1000*(phi2 - 1)) >= 0", 0.130_494_378_600_05),
        ("1/(1 + exp(-2000*(phi2 - 1))) >= 0.5", 0.130_494_378_600_05),
    ];
    for (condition, t) in cases {
        for (method, step) in [("rk4", "1e-3"), ("dop853", "0.5"), ("gauss", "0.1")] {
            let run = run(&["quick-return", "--until", condition, "--method", method, "--step", step]);
            assert_eq!(run.status(), 0, "{condition} by {method}: {}", run.stderr());
            let found = run.summary()["end_time"].as_f64().expect("a number");
            near(&format!("{condition} by {method}"), found, t, 1e-10);
        }
    }
}

#[test]
fn a_smaller_number_than_one_without_value_has_no_value() {
    for condition in ["min(sqrt(0.5 - phi2), phi2) >= 1", "max(sqrt(0.5 - phi2) - 9, phi2 - 9) >= 0"] {
        let run = run(&["quick-return", "--until", condition]);
        assert_eq!(run.status(), 1, "{condition}: {}", run.stderr());
        assert!(run.stderr().contains("is not finite"), "{condition}: {}", run.stderr());
    }
}

/// Between two rows the force rises above the bound for a short while.
#[test]
fn derivatives_are_those_of_the_first_crossing() {
    for (method, step, bound) in [(DOP853, 0.01, 1418.1), (RK4, 1e-3, 1418.1), (RK4, 1.3e-3, 1418.1)] {
        let until = event(model("quick-return-loaded"), &format!("N6 >= {bound}"));
        let settings = MethodSettings::new(method, 1e-9);
        let (step, end) = (Some(step), Some(End::Event(&until)));
        let request = SensitivityRequest { settings, step, end, by: &["F6"], ..SensitivityRequest::default() };
        let own = sensitivity(model("quick-return-loaded"), &|_| None, &request).expect("smooth");
        let request = Request { settings, step, end, ..Request::default() };
        let run = simulate(&*mechanism("quick-return-loaded", &[]), &request, &mut ()).expect("a start");
        near(&format!("{bound} by {}", method.name), own.end_time.value, run.end_time, 1e-9);
    }
}

#[test]
fn lanes_of_a_sweep_end_where_single_runs_do() {
    let folder = tempfile::tempdir().expect("a folder");
    for (condition, ..) in CONDITIONS {
        let out = folder.path().join("sweep.csv");
        let sweep = qrm(&["sweep", "quick-return-loaded", "--vary", "O2A=0.15:0.2:9", "--until", condition])
            .args(["--lanes", "most", "--out"])
            .arg(&out)
            .output()
            .expect("the command starts");
        let table = Table::read(&out);
        for row in 0..=table.last() {
            let design = format!("O2A={}", table.text(row, "O2A"));
            let run = run(&["quick-return-loaded", "--method", "dop853", "--until", condition, "--set", &design]);
            let (alone, what) = (run.trajectory(), format!("{condition} of {design}"));
            if run.status() != 0 {
                assert_ne!(sweep.status.code(), Some(0), "{what}: {}", run.stderr());
                continue;
            }
            for (name, column) in [("end_time", "t"), ("phi2", "phi2"), ("phi5_dot", "phi5_dot")] {
                let expected = alone.number(alone.last(), column);
                near(&what, table.number(row, name), expected, 1e-9 * expected.abs().max(1.0));
            }
        }
        fs::remove_file(out).expect("removed");
    }
}

/// Near its turning point a condition hardly changes. Its rounding errors move the end by more than the motion does.
/// The end is at `pi - 2 asin(sqrt(distance/2))`.
#[test]
fn ends_at_conditions_that_hardly_change_state_their_errors() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("sweep.csv");
    for distance in [1e-6_f64, 1e-10, 1e-14] {
        let condition = format!("cos(phi2) <= -1 + {distance:e}");
        let exact = PI - (0.5 * distance).sqrt().asin() * 2.0;
        for method in ["rk4", "dop853"] {
            let run = run(&["quick-return", "--method", method, "--until", &condition]);
            let (table, summary) = (run.trajectory(), run.summary());
            let stated = summary["end_time_error"].as_f64().expect("an error");
            let off = (table.number(table.last(), "phi2") - exact).abs() / table.number(table.last(), "phi2_dot");
            assert!(off <= 3.0 * stated, "{condition} by {method}: {off:e} of {stated:e}");
            let sweep = qrm(&["sweep", "quick-return", "--vary", "w0=12", "--method", method, "--until", &condition])
                .arg("--out")
                .arg(&out)
                .output()
                .expect("the command starts");
            assert!(sweep.status.success(), "{condition} by {method}");
            let table = Table::read(&out);
            let [end, rate, of_time, of_motion] =
                ["phi2", "phi2_dot", "end_time_error", "estimated_error"].map(|column| table.number(0, column));
            let off = (end - exact).abs();
            assert!(off <= 3.0 * of_motion && off <= 3.0 * of_time * rate, "{condition} by {method}: {off:e}");
            fs::remove_file(&out).expect("removed");
        }
    }
}

/// `y_dot = sin(t)`, `x = (t - 2)^3`; the force of the guide jumps to 3 N at t = 1.2345.
#[test]
#[ignore = "full tier: engine"]
fn conditions_that_become_true_slowly_do_so_within_the_stated_error() {
    let mut cases = vec![
        ("guide", "N <= -3".to_owned(), 1.2345, ["0.0033", "0.01"]),
        ("inflection", "x >= 0".to_owned(), 2.0, ["0.1", "0.03"]),
    ];
    for bound in [0.999_999_999_99_f64, 0.999_999_999, 0.999_999] {
        cases.push(("swing", format!("y_dot >= {bound}"), bound.asin(), ["0.1", "0.03"]));
    }
    let mut met = 0;
    for (scene, condition, exact, steps) in cases {
        let scene = format!("{}/tests/extremes/{scene}.toml", env!("CARGO_MANIFEST_DIR"));
        for (method, step) in ["gauss", "dop853", "dopri5", "rk4"].into_iter().flat_map(|m| steps.map(|step| (m, step)))
        {
            let run = run(&[&scene, "--until", &condition, "--method", method, "--step", step]);
            let [end, error] =
                ["end_time", "end_time_error"].map(|key| run.summary()[key].as_f64().unwrap_or(f64::NAN));
            if run.status() == 0 {
                near(&format!("{condition} by {method}, step {step}"), end, exact, 3.0 * error);
                met += 1;
            }
        }
    }
    assert!(met > 30, "{met} runs end at their condition");
}

/// `y_dot = sin(t)` at a tolerance that leaves open whether it exceeds the bound at its first maximum.
#[test]
#[ignore = "full tier: engine"]
fn a_condition_that_hardly_changes_before_its_bound_is_not_passed_over() {
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/extremes/swing.toml");
    for condition in ["y_dot >= 0.999999", "max(y_dot, 0.99999) >= 0.999999"] {
        for method in ["dop853", "dopri5"] {
            let run = run(&[scene, "--until", condition, "--method", method, "--step", "0.1", "--tolerance", "1e-5"]);
            let [end, error] =
                ["end_time", "end_time_error"].map(|key| run.summary()[key].as_f64().unwrap_or(f64::NAN));
            let is_met = (end - 0.999_999_f64.asin()).abs() <= 3.0 * error;
            assert!(
                is_met || run.stderr().contains("may have become true at t = 1.57"),
                "{condition} by {method}: {end}"
            );
        }
    }
}

/// An oscillator with `x = x0 cos(w t) + v0/w sin(w t)`: right times by bisection with 30 digits.
#[test]
#[ignore = "full tier: engine"]
fn end_times_of_an_oscillator_have_their_errors() {
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/extremes/oscillator.toml");
    let cases = [
        ("4 1 0", "rk4 0.1 1e-9", "x <= -0.5", 1.047_197_551_196_597_7),
        ("6.571 0.5783 -1.432", "rk4 0.1 1e-9", "1/abs(x_dot-0.1888) >= 85030", 0.961_698_5),
        ("4.347 0.7194 1.527", "rk4 0.1 1e-9", "1/(x_dot-x-0.5) >= 126100", 0.064_708_045),
        ("6.684 0.3645 0.7215", "rodas 1 1e-4", "sign(x_dot-0.8008)+sin(t) >= 1.9827787", 1.754_360_109_6),
        ("11.67 0.8218 -1.305", "dopri5 2 1e-4", "sign(x+0.8638) <= 0", 0.702_308_114_9),
        ("1.078 0.07377 0.5042", "gauss 1 1e-7", "x+t >= 1.631153", 1.152_208_172_113_809),
        ("3.164 0.2598 -0.6601", "dop853 1 1e-7", "0.03946-x_dot-x^2-x >= 0.92613123", 0.519_394_804_214_8),
        ("3.332 0.0832 -0.7707", "dopri5 1 1e-4", "(x+t-0.5)*x_dot >= 2.9686103", 4.998_686_495_3),
    ];
    for (values, how, condition, exact) in cases {
        let values: Vec<String> =
            values.split(' ').zip(["k", "x0", "v0"]).map(|(value, name)| format!("{name}={value}")).collect();
        let [method, step, tolerance] = how.split(' ').collect::<Vec<_>>()[..] else { panic!("{how}") };
        let mut arguments = vec![scene, "--until", condition, "--method", method, "--step", step, "--no-figures"];
        values.iter().for_each(|value| arguments.extend(["--set", value]));
        if method != "rk4" {
            arguments.extend(["--tolerance", tolerance]);
        }
        let run = run(&arguments);
        let summary = run.summary();
        let [end, error] = ["end_time", "end_time_error"].map(|key| summary[key].as_f64().unwrap_or(f64::NAN));
        let is_right = (end - exact).abs() <= 3.0 * error;
        assert!(is_right || run.status() == 1, "{condition} by {method}: {end} with {error:e}, {}", run.stderr());
        // The largest time is the end itself.
        let largest = &summary["extremes"]["tt"];
        if run.status() == 0 {
            assert_eq!(largest["max"], summary["end_time"], "{condition}");
            assert!(largest["max_error"].as_f64().expect("an error") >= 0.9 * error, "{condition}: {largest}");
        }
    }
    // Where the error of the time is not known, a warning says so.
    let run = run(&[
        scene,
        "--until",
        "sign(sin(x-0.2*t-0.296)) >= 1",
        "--set",
        "k=19.24",
        "--set",
        "x0=-0.1937",
        "--set",
        "v0=1.792",
    ]);
    let is_known = run.summary()["end_time_error"].is_number();
    assert!(is_known || run.stdout().contains("the error of the end time is not known"), "{}", run.stdout());
}

/// No extreme of a design lies behind the end that its condition sets.
#[test]
#[ignore = "full tier: engine"]
fn sweeps_count_no_states_behind_their_conditions() {
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/extremes/oscillator.toml");
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("sweep.csv");
    let sweep = qrm(&["sweep", scene, "--vary", "x0=-1,-0.9,-0.8,-0.7", "--vary", "k=12.5", "--vary", "v0=-1.925"])
        .args(["--until", "x_dot >= 2.83", "--tolerance", "1e-12", "--out"])
        .arg(&out)
        .output()
        .expect("the command starts");
    assert!(sweep.status.success(), "{}", String::from_utf8_lossy(&sweep.stderr));
    let table = Table::read(&out);
    for row in 0..=table.last() {
        let [end, largest] = ["end_time", "tt_max"].map(|column| table.number(row, column));
        near("the largest time", largest, end, 1e-14);
    }
}

/// The polynomial of a step meets the bound where the motion itself only comes near it.
#[test]
fn a_condition_that_comes_near_its_bound_does_not_hold_a_lane() {
    let condition = "sin(3*((q_ddot - 0.216)/0.568)*((p_dot - 0.0481)/0.518)) >= 0.65394204";
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("sweep.csv");
    let sweep = qrm(&["sweep", "slider-crank", "--vary", "k=1,1.1,0.9,0.8,1.2", "--until", condition, "--out"])
        .arg(&out)
        .output()
        .expect("the command starts");
    assert_eq!(sweep.status.code(), Some(0));
    let table = Table::read(&out);
    for row in 0..=table.last() {
        let k = format!("k={}", table.text(row, "k"));
        let run = run(&["slider-crank", "--method", "dop853", "--until", condition, "--set", &k]);
        let alone = run.trajectory();
        near(&k, table.number(row, "end_time"), alone.number(alone.last(), "t"), 1e-7);
    }
}

/// A pendulum that is released level: at the height y, its energy is -m g y and the pull of its rod is -3 m g y/l.
#[test]
fn energies_forces_and_rates_of_points_agree_with_closed_forms() {
    for condition in [
        "S >= m*g",
        "kinetic_energy >= m*g*l/3",
        "potential_energy <= -m*g*l/3",
        "kinetic_energy - potential_energy - energy >= 2*m*g*l/3",
        "P.x_dot^2 + P.y_dot^2 >= 2*g*l/3",
    ] {
        let until = event(model("pendulum"), condition);
        let request = Request { end: Some(End::Event(&until)), ..Request::default() };
        let outcome = simulate(&*mechanism("pendulum", &[]), &request, &mut ()).expect("a start");
        near(condition, outcome.q[1], -1.0 / 3.0, 1e-9);
    }
}

#[test]
fn conditions_on_what_stays_are_refused() {
    for condition in ["O2.x >= 1", "3 >= 4", "F6 >= 1"] {
        let run = run(&["quick-return-loaded", "--until", condition]);
        assert_eq!(run.status(), 2, "{condition}: {}", run.stderr());
        assert!(run.stderr().contains("never changes"), "{condition}: {}", run.stderr());
    }
}

#[test]
fn unknown_names_are_reported_with_those_that_are_near() {
    for (condition, words) in [("N7 >= 1", "N3"), ("lambda_guid >= 1", "lambda_guide"), ("x6_dott >= 1", "x6_dot")] {
        let run = run(&["quick-return-loaded", "--until", condition]);
        assert_eq!(run.status(), 2, "{condition}: {}", run.stderr());
        assert!(run.stderr().contains(words), "{condition}: {}", run.stderr());
    }
}

#[test]
#[ignore = "full tier: engine"]
fn a_scene_ends_at_a_condition_on_forces() {
    let source = fs::read_to_string("scenes/quick-return-loaded.toml").expect("a scene");
    let folder = tempfile::tempdir().expect("a folder");
    let scene = folder.path().join("loaded.toml");
    for (condition, column, value) in CONDITIONS {
        let until = format!("until = '{condition}'");
        assert!(source.contains("until = 'abs(phi2) >= 4*pi'"));
        fs::write(&scene, source.replace("until = 'abs(phi2) >= 4*pi'", &until)).expect("written");
        let run = run(&[&scene.display().to_string(), "--method", "dop853"]);
        assert_eq!(run.status(), 0, "{condition}: {}", run.stderr());
        let table = run.trajectory();
        near(condition, table.number(table.last(), column), value, 1e-9 * value.abs());
    }
}

/// A mass of 1 kg is pushed by forces that jump to a bound of its acceleration, or rise to it, and stay there.
#[test]
#[ignore = "full tier: engine"]
fn accelerations_that_jump_or_rise_to_their_bound_reach_it() {
    let at_place = ((0.01_f64 + 0.031_37).sqrt() - 0.1) / 0.5;
    let cases = [
        ("max(sign(t - 0.3137), 0)", "x_ddot >= 1", 0.3137),
        ("0.5 + max(sign(x - 0.03137), 0)", "x_ddot >= 1.5", at_place),
        ("min(2*t, 1)", "x_ddot >= 1", 0.5),
        // A jump at a row.
        ("sign(t - 0.4)", "x_ddot >= 1", 0.4),
    ];
    let folder = tempfile::tempdir().expect("a folder");
    let scene = folder.path().join("pushed.toml");
    for (force, condition, time) in cases {
        let text = format!(
            "name = \"pushed\"\ncoordinates = [{{ name = \"x\", unit = \"m\" }}]\n[bodies]\nb = {{ mass = '1', com = \
             ['x', '0'] }}\n[loads]\nf = {{ along = 'x', force = '{force}' }}\n[initial]\ngiven = {{ x = 0, x_dot = \
             0.1 }}\n[run]\nstep = 0.01\nend_time = 1\n"
        );
        fs::write(&scene, text).expect("written");
        for (method, step) in
            ["rk4", "dop853", "dopri5", "gauss", "auto"].iter().flat_map(|m| [(m, "0.01"), (m, "0.0123")])
        {
            let file = scene.display().to_string();
            let run = run(&[&file, "--until", condition, "--method", method, "--step", step]);
            let summary = run.summary();
            let [end, stated] = ["end_time", "end_time_error"].map(|name| summary[name].as_f64().expect("a number"));
            near(&format!("{condition} with {force} by {method}"), end, time, 1e-13);
            near(&format!("{condition} with {force} by {method}, as stated"), end, time, 3.0 * stated);
        }
    }
}
