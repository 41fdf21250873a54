//! Stiff and extreme variants by methods that choose their steps, against states from the energy integral and from runs
//! with 50 digits.

use std::fs;

use qrm_cli::api::LoadedScene;
use qrm_model::MODELS;
use qrm_sim::solve::{Dynamics, Linearization, dot};
use qrm_sim::state::State;

use crate::common::chains::stiff_chain;
use crate::common::{Run, Table, qrm, run, with_slot};

const COORDINATES: [&str; 3] = ["phi2", "phi4", "phi5"];

/// How far the end of a case is off, angles modulo a turn, relative to the exact values where those are above one.
fn worst(cases: &Table, row: usize, method: &str, tolerance: &str) -> f64 {
    let parameters = cases.text(row, "params");
    let mut arguments = vec!["quick-return-loaded", "--method", method, "--tolerance", tolerance, "--step", "0.01"];
    arguments.extend(["--end-time", cases.text(row, "t_end"), "--no-error-estimate"]);
    arguments.extend(parameters.split(' ').flat_map(|set| ["--set", set]));
    let run = run(&arguments);
    assert_eq!(run.status(), 0, "{parameters} by {method}: {}", run.stderr());
    off(cases, row, &run.summary()["end_state"])
}

fn off(cases: &Table, row: usize, end: &serde_json::Value) -> f64 {
    let off = |name: &str| {
        let (got, exact) = (end[name].as_f64().expect("a number"), cases.number(row, name));
        let turns = if name.ends_with("_dot") { 0.0 } else { ((got - exact) / std::f64::consts::TAU).round() };
        (got - exact - turns * std::f64::consts::TAU).abs() / exact.abs().max(1.0)
    };
    let names = COORDINATES.iter().flat_map(|name| [(*name).to_owned(), format!("{name}_dot")]);
    names.map(|name| off(&name)).fold(0.0, f64::max)
}

#[test]
#[ignore = "full tier: engine"]
fn every_extreme_case_comes_out_right() {
    let cases = Table::reference("quick-return-extreme-cases.csv");
    for method in ["auto", "rodas", "dop853"] {
        for row in 0..cases.rows.len() {
            let off = worst(&cases, row, method, "1e-9");
            assert!(off < 1e-6, "{} by {method}: off by {off:e}", cases.text(row, "params"));
        }
    }
}

#[test]
#[ignore = "full tier: engine"]
fn long_steps_that_are_wrong_say_so() {
    let cases = Table::reference("quick-return-extreme-cases.csv");
    let mut reported = 0;
    for row in 0..cases.rows.len() {
        let parameters = cases.text(row, "params");
        let mut arguments = vec!["quick-return-loaded", "--end-time", cases.text(row, "t_end"), "--no-figures"];
        arguments.extend(parameters.split(' ').flat_map(|set| ["--set", set]));
        let run = run(&arguments);
        let off = off(&cases, row, &run.summary()["end_state"]);
        assert!(off < 1e-3 || run.status() == 1, "{parameters}: off by {off:e} without a word");
        reported += usize::from(run.status() == 1);
    }
    assert!((7..=9).contains(&reported), "{reported} runs are refused");
}

#[test]
#[ignore = "full tier: engine"]
fn a_constraint_that_vanishes_is_named() {
    // The rocker turns fully; where it points along x, this form of the slot says nothing.
    let (_folder, scene) = with_slot("quick-return-loaded", "A.x/sqrt(A.x^2 + A.y^2) - cos(phi4)");
    let run = run(&[&[scene.as_str()], &FULL_TURN[..], &["--end-time", "1"]].concat());
    assert_eq!(run.status(), 1);
    assert!(run.stderr().contains("came near a singular position"), "{}", run.stderr());
    assert!(run.stderr().contains("constraint `slot` has no gradient there"), "{}", run.stderr());
}

/// A crank that is longer than the ground link, so that the rocker turns fully.
const FULL_TURN: [&str; 6] = ["--set", "O2A=0.301", "--set", "BC=2", "--set", "BG5=1"];

#[test]
#[ignore = "full tier: engine"]
fn a_constraint_with_a_regular_form_is_rewritten() {
    let note = "constraint `slot` is singular where A.y = 0, and is taken as `A.x*sin(phi4) - A.y*cos(phi4)` instead";
    let last = |run: &Run| {
        let state = run.summary()["end_state"].clone();
        ["phi2", "phi4", "phi5"].map(|name| state[name].as_f64().expect("a number"))
    };
    let by = |scene: &str, method: &[&str]| {
        let run = run(&[&[scene], &FULL_TURN[..], &["--end-time", "1", "--no-figures"], method].concat());
        assert_eq!(run.status(), 0, "{method:?}: {}", run.stderr());
        run
    };
    let exact = by("quick-return-loaded", &["--method", "dop853", "--tolerance", "1e-13"]);
    let warnings = exact.summary()["warnings"].to_string();
    assert!(warnings.contains(note), "{warnings}");
    for tolerance in ["1e-6", "1e-9"] {
        let run = by("quick-return-loaded", &["--method", "auto", "--tolerance", tolerance]);
        let error = last(&run).iter().zip(last(&exact)).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        let estimate = run.summary()["estimated_error"].as_f64().expect("a number");
        assert!(error < 3.0 * estimate && error < 1e-3, "{tolerance}: {error:e} with {estimate:e} estimated");
    }
    // The angle between rocker and crank by its tangent, which is regular as long as the crank is the longer one.
    let tangent = "(A.y*cos(phi2) - A.x*sin(phi2))/(A.x*cos(phi2) + A.y*sin(phi2))";
    let (_folder, other) = with_slot("quick-return-loaded", &format!("phi4 - phi2 - atan({tangent})"));
    let other = last(&by(&other, &["--method", "dop853", "--tolerance", "1e-13"]));
    assert!(last(&exact).iter().zip(other).all(|(a, b)| (a - b).abs() < 1e-9), "{other:?}");
}

#[test]
#[ignore = "full tier: engine"]
fn mirrored_positions_have_no_regular_form() {
    // The root form holds for the mirrored rocker too.
    let (_folder, scene) = with_slot("quick-return", "A.x - sqrt(A.x^2 + A.y^2)*cos(-phi4)");
    let run = run(&[&scene, "--set", "O2A=0.301", "--set", "BC=2", "--end-time", "0.1", "--no-figures"]);
    assert_eq!(run.status(), 0, "{}", run.stderr());
    assert_eq!(run.summary()["warnings"], serde_json::json!([]));
}

#[test]
fn the_implicit_method_takes_few_steps_where_dampers_are_stiff() {
    let steps = |damper: &str, method: &str| {
        let damper = format!("cd={damper}");
        let arguments = ["quick-return-loaded", "--method", method, "--tolerance", "1e-6", "--step", "0.05"];
        let more = ["--end-time", "0.5", "--no-error-estimate", "--set", &damper];
        let run = run(&[&arguments[..], &more[..]].concat());
        assert_eq!(run.status(), 0, "{}", run.stderr());
        run.summary()["steps"].as_u64().expect("a number")
    };
    // The step of an explicit method is bound by the fastest rate, 6.3e-4 /s for each N s/m.
    let (explicit, implicit) = (steps("1e7", "dop853"), steps("1e7", "rodas"));
    assert!(implicit < 100 && explicit > 4 * implicit, "{implicit} against {explicit} steps");
    assert!(steps("1e9", "rodas") < 100);
    // It takes some steps to notice.
    assert!(steps("1e9", "auto") < 100);
}

#[test]
fn auto_stays_with_implicit_steps_as_long_as_a_damper_holds_the_motion() {
    let arguments = ["quick-return-loaded", "--method", "auto", "--tolerance", "1e-9", "--step", "0.5"];
    let more = ["--end-time", "60", "--no-error-estimate", "--set", "cd=1e7"];
    let run = run(&[&arguments[..], &more[..]].concat());
    assert_eq!(run.status(), 0, "{}", run.stderr());
    let [steps, implicit] = ["steps", "implicit_steps"].map(|name| run.summary()[name].as_u64().expect("a number"));
    // Explicit ones begin, until it is noticed.
    assert!(implicit > 20 && steps < implicit + 55, "{implicit} of {steps} steps");
}

/// The time at which all rods of `n-four-bar-2` are in line, in s: the cranks stay parallel, so the motion is that of a
/// pendulum (Gonzalez and others 2006).
const PASSAGE: f64 = 0.714_355_529_292_960_5;
/// The angle `a0` of `n-four-bar-2` after 10 s, in rad.
const END: f64 = std::f64::consts::FRAC_PI_2 - 31.750_597_186_986_1;

/// The error of the angle `a0` of `n-four-bar-2` after 10 s.
fn error_after_passages(summary: &serde_json::Value) -> f64 {
    (summary["end_state"]["a0"].as_f64().expect("a number") - END).abs()
}

#[test]
fn steps_that_end_at_a_singular_position_go_on() {
    for (steps, allowed) in [(71.0, 2e-6), (100.0, 1e-6), (500.0, 1e-8), (714.5, 1e-8), (1000.0, 1e-9), (7143.0, 1e-9)]
    {
        let step = format!("{:?}", PASSAGE / steps);
        let run = run(&["n-four-bar-2", "--step", &step, "--end-time", "10", "--no-figures"]);
        assert_eq!(run.status(), 0, "{steps}: {}", run.stderr());
        let summary = run.summary();
        let off = error_after_passages(&summary);
        assert!(off < allowed, "{steps} steps to the passage: off by {off:e}");
        let nearest = summary["smallest_singular_value"]["value"].as_f64().expect("a number");
        // Whole numbers of steps land there, 71 of them within the error of the motion until then.
        assert!(steps == 714.5 || nearest < 1e-7, "{nearest:e}");
        assert!(summary["warnings"].to_string().contains("came near a singular position"), "{summary}");
    }
}

#[test]
#[ignore = "full tier: compiled"]
fn adaptive_methods_pass_singular_positions_at_every_tolerance() {
    for method in ["auto", "dop853", "dopri5", "gauss"] {
        for (tolerance, allowed) in [(1e-8, 1e-6), (1e-9, 1e-7), (1e-10, 1e-8), (1e-11, 2e-9), (1e-12, 2e-10)] {
            let tolerance = format!("{tolerance:e}");
            let run = run(&["n-four-bar-2", "--method", method, "--tolerance", &tolerance, "--no-figures"]);
            assert_eq!(run.status(), 0, "{method} {tolerance}: {}", run.stderr());
            let off = error_after_passages(&run.summary());
            assert!(off < allowed, "{method} {tolerance}: off by {off:e}");
        }
    }
}

/// The derivatives of the equations of a large tree, against central differences.
#[test]
#[ignore = "full tier: engine"]
fn large_trees_have_exact_derivatives() {
    let (_folder, path) = stiff_chain();
    let scene = LoadedScene::load(MODELS, &path).expect("a scene");
    let mechanism = scene.model().mechanism(&|_| None);
    let n = 13_usize;
    let numbers = |phase: f64| (0..n).map(|i| (1.7 * i as f64 + phase).sin()).collect::<Vec<f64>>();
    let at = State { t: 0.3, q: numbers(0.1), qd: numbers(0.2), qdd: numbers(0.3), ..State::default() };
    let mut own = Linearization::zero(n, 0);
    assert!(own.evaluate(&*mechanism, &at));
    let excess = |q: &[f64], qd: &[f64]| -> Vec<f64> {
        let Dynamics { mass_matrix, generalized_forces, .. } = Dynamics::at(&*mechanism, at.t, q, qd);
        mass_matrix.iter().zip(generalized_forces).map(|(row, force)| dot(row, &at.qdd) - force).collect()
    };
    for j in 0..n {
        let moved = |x: &[f64], by: f64| -> Vec<f64> {
            let mut moved = x.to_vec();
            moved[j] += by;
            moved
        };
        let by = 1e-5;
        let slope = |low: Vec<f64>, high: Vec<f64>, i: usize| (high[i] - low[i]) / (2.0 * by);
        for i in 0..n {
            let [low, high] = [-by, by].map(|by| excess(&moved(&at.q, by), &at.qd));
            let off = (own.stiffness[i][j] - slope(low, high, i)).abs();
            assert!(off < 1e-6 * (1.0 + own.stiffness[i][i].abs()), "stiffness {i} {j}: {off:e}");
            let [low, high] = [-by, by].map(|by| excess(&at.q, &moved(&at.qd, by)));
            let off = (own.damping[i][j] - slope(low, high, i)).abs();
            assert!(off < 1e-6 * (1.0 + own.damping[i][i].abs()), "damping {i} {j}: {off:e}");
        }
    }
}

#[test]
#[ignore = "full tier: engine"]
fn stiff_chains_take_few_implicit_steps() {
    let (_folder, path) = stiff_chain();
    let runs = ["dop853", "rodas", "auto"].map(|method| {
        let tolerance = ["--tolerance", "1e-8", "--no-error-estimate", "--no-figures"];
        let run = run(&[&[path.as_str(), "--method", method][..], &tolerance[..]].concat());
        assert_eq!(run.status(), 0, "{method}: {}", run.stderr());
        run.summary()
    });
    let steps = runs.each_ref().map(|summary| summary["steps"].as_u64().expect("a number"));
    assert!(steps[1] < 500 && steps[2] < 500 && steps[0] > 5000, "{steps:?}");
    for (name, exact) in
        runs[0]["end_state"].as_object().expect("numbers").iter().filter(|(name, _)| !name.contains('_'))
    {
        let [exact, rodas, auto] = [exact, &runs[1]["end_state"][name], &runs[2]["end_state"][name]]
            .map(|value| value.as_f64().expect("a number"));
        assert!((rodas - exact).abs() < 1e-7 && (auto - exact).abs() < 1e-7, "{name}: {exact} {rodas} {auto}");
    }
}

/// Derivatives of implicit steps by parameters contain those of the linearization.
#[test]
#[ignore = "full tier: engine"]
fn implicit_steps_of_large_trees_have_sensitivities() {
    let (_folder, path) = stiff_chain();
    let end = |set: &str| {
        let run = run(&[&path, "--method", "rodas", "--tolerance", "1e-10", "--end-time", "0.1", "--set", set]);
        assert_eq!(run.status(), 0, "{}", run.stderr());
        run.summary()["end_state"]["a3"].as_f64().expect("a number")
    };
    let difference = (end("m=0.5005") - end("m=0.4995")) / 1e-3;
    let folder = tempfile::tempdir().expect("a temporary folder");
    let output = qrm(&["sensitivity", &path, "--by", "m", "--method", "rodas", "--tolerance", "1e-10", "--no-check"])
        .args(["--end-time", "0.1", "--out"])
        .arg(folder.path())
        .output()
        .expect("it starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let table = fs::read_to_string(folder.path().join("sensitivity.csv")).expect("a table");
    let row = table.lines().find(|line| line.starts_with("end,a3,")).expect("a row");
    let derivative: f64 = row.split(',').nth(4).and_then(|text| text.parse().ok()).expect("a number");
    assert!((derivative - difference).abs() < 1e-5 * difference.abs(), "{derivative} {difference}");
}

/// Momenta of unit masses are the rates themselves.
#[test]
#[ignore = "full tier: engine"]
fn large_trees_of_unit_masses_move() {
    let list = |entry: &dyn Fn(usize) -> String| (0..14).map(entry).collect::<Vec<_>>().join(", ");
    let text = format!(
        "name = 'blocks'\ncoordinates = [{}]\n[bodies]\n{}\n[loads]\npull = {{ gravity = ['2', '0'] }}\n[initial]\n\
         given = {{ {} }}\n[run]\nstep = 0.01\nend_time = 1\nstiff = true\n",
        list(&|i| format!("{{ name = 'x{i}', unit = 'm' }}")),
        list(&|i| format!("b{i} = {{ mass = 1, com = ['x{i}', '0'] }}")).replace("}, ", "}\n"),
        list(&|i| format!("x{i} = {i}, x{i}_dot = 0")),
    );
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("blocks.toml").display().to_string();
    fs::write(&path, text).expect("written");
    for method in ["rk4", "rodas"] {
        let run = run(&[&path, "--method", method, "--no-figures"]);
        assert_eq!(run.status(), 0, "{method}: {}", run.stderr());
        let end = run.summary()["end_state"]["x3"].as_f64().expect("a number");
        assert!((end - 4.0).abs() < 1e-9, "{method}: {end}");
    }
    let certified = qrm(&["certify", &path, "--end-time", "0.01"]).current_dir(folder.path()).output();
    let certified = certified.expect("it starts");
    assert!(certified.status.success(), "{}", String::from_utf8_lossy(&certified.stderr));
}
