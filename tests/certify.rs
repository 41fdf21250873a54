//! `qrm certify`: intervals against exact values, and against motions in numbers of 32 digits.

use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_2, TAU};
use std::time::{Duration, Instant};

use qrm_core::{Interval, Model, StoredTape};
use qrm_sim::analysis::{
    Enclosure, EnclosureEnd, NoSeries, NotEnclosed, Reason, ReferenceState, enclose, reference_states,
};
use serde_json::Value;

use crate::common::chains::chain;
use crate::common::{Table, event, model, qrm, run};

/// The motion of a scene, enclosed.
#[track_caller]
fn enclosed(name: &str, end: EnclosureEnd) -> Enclosure {
    enclose(model(name), &|_| None, end, &|| false).unwrap_or_else(|e| panic!("{name}: {:?}", e.reason))
}

/// Asserts that an interval contains a number, but for the rounding of that, and is at most so wide.
#[track_caller]
fn holds(name: &str, interval: Interval, value: f64, width: f64) {
    assert!(interval.lo() <= value.next_up() && value.next_down() <= interval.hi(), "{name}: {value} in {interval:?}");
    assert!(interval.width() <= width, "{name}: width {:e}", interval.width());
}

#[test]
fn one_revolution_of_the_quick_return() {
    let begun = Instant::now();
    let end = enclosed("quick-return", EnclosureEnd::Turn { coordinate: 0, before: 10.0 });
    assert!(begun.elapsed() < Duration::from_secs(10), "{:?}", begun.elapsed());
    assert!(end.is_at_event);
    // With 50 digits from the energy integral. The motion recurs after a turn.
    holds("t", end.t, 0.877_997_139_511_224_4, 1e-11);
    let start = [TAU, 0.982_793_723_247_329, 2.583_847_219_989_958];
    let rates = [7.853_981_633_974_483, 2.416_609_733_530_610_3, 1.843_253_610_983_725_4];
    let exact = start.iter().chain(&rates);
    for (i, (value, exact)) in end.q.iter().chain(&end.qd).zip(exact).enumerate() {
        holds(&i.to_string(), *value, *exact, 2e-11);
    }
}

#[test]
fn exact_states_of_the_quick_return() {
    let exact = Table::reference("quick-return-states.csv");
    for row in 0..exact.rows.len() {
        let t = exact.number(row, "t");
        if t == 0.0 || t > 0.6 {
            continue;
        }
        let at = enclosed("quick-return", EnclosureEnd::Time(t));
        let names = |suffix: &str| ["phi2", "phi4", "phi5"].map(|name| format!("{name}{suffix}"));
        for (suffix, values, width) in [("", &at.q, 1e-12), ("_dot", &at.qd, 2e-12), ("_ddot", &at.qdd, 1e-9)] {
            for (name, value) in names(suffix).iter().zip(values) {
                // A time such as 0.01 is not the double next to it.
                holds(name, *value + Interval::new(-1e-15, 1e-15), exact.number(row, name), width);
            }
        }
        assert_eq!(at.t, Interval::point(t));
    }
    let half = enclosed("quick-return", EnclosureEnd::Time(0.5));
    for (value, exact) in half.outputs[4..].iter().zip([602.576_704_996_570_8, -960.811_495_641_164_6]) {
        holds("force", *value, exact, 1e-8);
    }
}

/// The elliptic sine and the complete integral of a modulus, by the arithmetic-geometric mean.
fn elliptic(modulus: f64) -> (impl Fn(f64) -> f64, f64) {
    let mut means = vec![(1.0, (1.0 - modulus * modulus).sqrt(), modulus)];
    while means[means.len() - 1].2 > 1e-16 {
        let (a, b, _) = means[means.len() - 1];
        means.push((0.5 * (a + b), (a * b).sqrt(), 0.5 * (a - b)));
    }
    let (last, count) = (means[means.len() - 1].0, means.len() - 1);
    let sine = move |u: f64| {
        let mut phi = 2_f64.powi(count as i32) * last * u;
        for (a, _, c) in means[1..].iter().rev() {
            phi = 0.5 * (phi + (c / a * phi.sin()).asin());
        }
        phi.sin()
    };
    (sine, FRAC_PI_2 / last)
}

#[test]
fn a_pendulum_by_elliptic_functions() {
    let (sine, quarter) = elliptic(FRAC_1_SQRT_2);
    for t in [0.1, 0.7, 1.3, 2.9] {
        let at = enclosed("pendulum", EnclosureEnd::Time(t));
        let angle = 2.0 * (FRAC_1_SQRT_2 * sine(quarter - 9.81_f64.sqrt() * t)).asin();
        for (value, exact) in at.q.iter().zip([angle.sin(), -angle.cos()]) {
            holds("position", *value + Interval::new(-4e-15, 4e-15), exact, 1e-11);
        }
    }
    let at = enclosed("pendulum", EnclosureEnd::Time(10.0));
    for (value, exact) in at.q.iter().zip([0.275_087_462_576_116_9, -0.961_419_205_099_125]) {
        holds("position", *value, exact, 1e-10);
    }
}

/// Asserts that the enclosures of a scene contain a motion in numbers of 32 digits, at some times.
#[track_caller]
fn contains_reference(model: &Model, times: &[f64], width: f64) {
    let states = reference_states(model, &|_| None, times, 1e-22).expect("a reference");
    for ReferenceState { rounded: state, .. } in states {
        let at = enclosed(model.description.name, EnclosureEnd::Time(state.t));
        let exact = state.q.iter().chain(&state.qd);
        for (i, (value, exact)) in at.q.iter().chain(&at.qd).zip(exact).enumerate() {
            holds(&format!("{} {i} at {}", model.description.name, state.t), *value, *exact, width);
        }
    }
}

#[test]
#[ignore = "full tier: compiled"]
fn motions_in_numbers_of_32_digits_are_contained() {
    contains_reference(model("double-pendulum"), &[0.137, 0.5, 1.0], 1e-10);
    contains_reference(model("four-bar"), &[0.9, 2.3, 5.0], 1e-11);
    contains_reference(model("quick-return"), &[0.211, 0.614, 0.8], 1e-11);
    contains_reference(model("quick-return-loaded"), &[0.3], 1e-11);
    contains_reference(model("quick-return-driven"), &[0.7], 1e-12);
    contains_reference(model("slider-crank"), &[1.0], 1e-12);
    contains_reference(model("thrown-stick"), &[0.25], 1e-10);
}

#[test]
fn a_replaced_parameter_is_enclosed() {
    let replaced = |name: &str| (name == "O2A").then_some(0.19);
    let found = enclose(model("quick-return"), &replaced, EnclosureEnd::Time(0.1), &|| false).expect("a motion");
    let exact = reference_states(model("quick-return"), &replaced, &[0.1], 1e-22).expect("a reference");
    for (value, exact) in found.q.iter().zip(&exact[0].rounded.q) {
        holds("O2A", *value, *exact, 1e-12);
    }
}

#[test]
fn a_turn_backwards_is_enclosed() {
    let replaced = |name: &str| (name == "w0").then_some(-7.0);
    let end = EnclosureEnd::Turn { coordinate: 0, before: 10.0 };
    let found = enclose(model("quick-return"), &replaced, end, &|| false).expect("a motion");
    assert!(found.is_at_event);
    holds("phi2", found.q[0], -TAU, 1e-10);
    let exact = reference_states(model("quick-return"), &replaced, &[found.t.mid()], 1e-22).expect("a reference");
    holds("phi2 at the time", found.q[0], exact[0].rounded.q[0], 1e-10);
    // The energy recurs, and with it the rate.
    holds("phi2_dot", found.qd[0], -7.0, 1e-10);
}

#[test]
fn a_crank_that_does_not_turn_ends_at_the_time() {
    let found = enclosed("four-bar", EnclosureEnd::Turn { coordinate: 0, before: 1.0 });
    assert!(!found.is_at_event && found.t == Interval::ONE);
}

/// The time of a condition lies between times at which 32 digits show that it is false and true.
#[test]
fn the_first_time_of_a_condition_is_enclosed() {
    let values = |condition: &str, q: &[f64], qd: &[f64]| match condition {
        "phi2 >= 3" | "abs(phi2) >= 3" => q[0] - 3.0,
        "phi4_dot <= -1" => -1.0 - qd[1],
        "C.x <= -0.5" => -0.5 - (0.7 * q[1].cos() + 0.6 * q[2].cos()),
        _ => unreachable!("{condition}"),
    };
    for condition in ["phi2 >= 3", "abs(phi2) >= 3", "phi4_dot <= -1", "C.x <= -0.5"] {
        let tape = event(model("quick-return"), condition);
        let found = enclosed("quick-return", EnclosureEnd::Event { tape: &tape, before: 10.0 });
        assert!(found.is_at_event && found.t.width() < 1e-12, "{condition}: {:?}", found.t);
        let times = [found.t.lo() - 1e-12, found.t.hi() + 1e-12];
        let states = reference_states(model("quick-return"), &|_| None, &times, 1e-22).expect("a reference");
        let [before, after] = [0, 1].map(|i| values(condition, &states[i].rounded.q, &states[i].rounded.qd));
        assert!(before < 0.0 && after > 0.0, "{condition}: {before:e} {after:e}");
    }
}

#[test]
fn conditions_that_cannot_be_proved_are_refused() {
    let reason = |condition: &str| {
        let tape = event(model("quick-return"), condition);
        let end = EnclosureEnd::Event { tape: &tape, before: 10.0 };
        enclose(model("quick-return"), &|_| None, end, &|| false).map(|found| found.t).map_err(|error| error.reason)
    };
    assert_eq!(reason("N6 >= 100"), Err(Reason::EventOnForces));
    assert_eq!(reason("phi2 <= 9"), Err(Reason::EventAtStart));
    assert_eq!(reason("min(phi2, 3) >= 3"), Err(Reason::NotCrossed));
    assert_eq!(reason("sin(phi2) >= 1"), Err(Reason::NotCrossed));
}

#[test]
fn a_corner_ends_what_is_proved() {
    let NotEnclosed { reached, reason } =
        enclose(model("shaper"), &|_| None, EnclosureEnd::Time(0.3), &|| false).expect_err("a table has corners");
    assert!(matches!(reason, Reason::NoSeries(NoSeries::Operation(_))), "{reason:?}");
    let reached = reached.expect("states up to the corner");
    let exact = reference_states(model("shaper"), &|_| None, &[reached.t.lo()], 1e-22).expect("a reference");
    for (value, exact) in reached.q.iter().zip(&exact[0].rounded.q) {
        holds("shaper", *value, *exact, 1e-11);
    }
}

#[test]
fn friction_in_joints_is_refused() {
    let of = model("quick-return");
    let description = Box::leak(Box::new(qrm_core::Description { friction: &["slot"], ..*of.description }));
    let tape = Box::leak(Box::new(StoredTape::from(of.named_tape().clone())));
    let reason = enclose(&Model::interpreted(description, tape), &|_| None, EnclosureEnd::Time(1.0), &|| false);
    assert_eq!(reason.expect_err("it is found by iteration").reason, Reason::Friction);
}

/// Status, standard output and errors of `qrm certify ARGUMENTS`, and its file.
fn certify(arguments: &[&str]) -> (Option<i32>, String, String, Option<Value>) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let output =
        qrm(&["certify"]).args(arguments).arg("--out").arg(folder.path()).output().expect("the command starts");
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    let file = std::fs::read_to_string(folder.path().join("certify.json")).ok();
    let file = file.map(|file| serde_json::from_str(&file).expect("JSON"));
    (output.status.code(), text(&output.stdout), text(&output.stderr), file)
}

#[test]
fn the_command_writes_what_is_proved() {
    let (status, printed, errors, file) = certify(&["quick-return"]);
    assert_eq!(status, Some(0), "{errors}");
    assert!(
        printed.starts_with("quick-return: intervals that contain the motion after one turn (85 steps, "),
        "{printed}"
    );
    let file = file.expect("a file");
    let column = |name: &str| {
        let columns = file["columns"].as_array().expect("columns");
        columns.iter().find(|column| column["name"] == name).unwrap_or_else(|| panic!("{name}")).clone()
    };
    let [lower, upper] = ["lower", "upper"].map(|end| column("t")[end].as_f64().expect("a number"));
    assert!(lower < 0.877_997_139_511_224_4 && 0.877_997_139_511_224_4 < upper && upper - lower < 1e-11);
    assert_eq!(column("lambda_slot")["unit"], "N");
    assert!(printed.contains("  phi2          6.28318530718  "), "{printed}");
}

#[test]
fn the_command_says_how_far_it_got() {
    let (status, printed, errors, file) = certify(&["shaper", "--end-time", "0.3"]);
    assert_eq!(status, Some(1), "{errors}");
    assert!(printed.starts_with("shaper: intervals that contain the motion at the time t"), "{printed}");
    assert!(errors.starts_with("error: proved up to t = 0.029") && errors.contains("may have a corner"), "{errors}");
    assert!(file.is_some());
    let (status, _, errors, file) = certify(&["quick-return", "--until", "phi2 >= 9", "--end-time", "0.1"]);
    assert_eq!(status, Some(1), "{errors}");
    assert!(errors.contains("`phi2 >= 9` does not become true up to t = 0.1 s: that is proved"), "{errors}");
    assert!(file.is_some_and(|file| file["condition"].is_null()));
    let (status, printed, errors, file) = certify(&["quick-return", "--set", "O2A=0.2999", "--end-time", "-1"]);
    assert_eq!((status, printed, file), (Some(2), String::new(), None), "{errors}");
}

/// The full mass matrix of a large tree is made of its momenta, in intervals and in numbers of 32 digits.
#[test]
#[ignore = "full tier: engine"]
fn large_trees_are_enclosed_and_have_references() {
    let (_folder, scene) = chain();
    let (status, _, errors, file) = certify(&[&scene, "--end-time", "0.001"]);
    assert_eq!(status, Some(0), "{errors}");
    let file = file.expect("a file");
    let run = run(&[&scene, "--method", "gauss", "--tolerance", "1e-14", "--end-time", "0.001"]).trajectory();
    for column in file["columns"].as_array().expect("columns").iter().filter(|column| column["name"] != "t") {
        let [lower, upper] = ["lower", "upper"].map(|end| column[end].as_f64().expect("a number"));
        let name = column["name"].as_str().expect("a name");
        let value = run.number(run.rows.len() - 1, name);
        assert!(lower - 1e-12 < value && value < upper + 1e-12, "{name}: {value} is not in [{lower}, {upper}]");
        // Accelerations are solutions of thirteen equations in intervals, which widen them.
        let width = if name.ends_with("_ddot") { 1e-2 } else { 1e-9 };
        assert!(upper - lower < width, "{name}: [{lower}, {upper}]");
    }
    let folder = tempfile::tempdir().expect("a temporary folder");
    let study =
        qrm(&["accuracy", &scene, "--end-time", "0.01", "--out"]).arg(folder.path()).output().expect("it starts");
    assert!(study.status.success(), "{}", String::from_utf8_lossy(&study.stderr));
}
