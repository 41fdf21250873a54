//! Scenes in links and joints: their motion, and the ordinary scenes that they become.

#![cfg(feature = "generate")]

mod common;

use std::f64::consts::PI;
use std::fs;

use common::{near, qrm};
use serde_json::Value;

/// A scene of this folder.
fn path(name: &str) -> String {
    format!("{}/tests/linkage/{name}.toml", env!("CARGO_MANIFEST_DIR"))
}

/// The state at the end of a run that chooses its steps.
fn end(scene: &str) -> impl Fn(&str) -> f64 + use<> {
    let run = common::run(&[scene, "--method", "dop853", "--tolerance", "1e-13", "--no-figures"]);
    assert_eq!(run.status(), 0, "{}", run.stderr());
    let summary = run.summary();
    move |name| summary["end_state"][name].as_f64().unwrap_or_else(|| panic!("no `{name}` in {summary}"))
}

#[test]
fn the_quick_return_moves_as_the_one_in_formulae() {
    let (own, formulae) = (end(&path("quick-return")), end("quick-return"));
    for name in ["phi2", "phi4", "phi5", "phi2_dot", "phi4_dot", "phi5_dot"] {
        near(name, own(name), formulae(name), 1e-12 * formulae(name).abs().max(1.0));
    }
}

#[test]
fn a_link_slides_along_a_line() {
    let end = end(&path("incline"));
    // Down a slope of 30 degrees: s = s0 + v t + g sin(30) t^2/2.
    near("s", end("s_slope"), 0.2 + 0.3 + 9.81 / 4.0, 1e-12);
}

#[test]
fn a_pin_moves_a_slotted_link() {
    let run = common::run(&[&path("yoke"), "--no-figures"]);
    assert_eq!(run.status(), 0, "{}", run.stderr());
    let summary = run.summary();
    let angle: f64 = 0.5 + 4.0 + 1.0;
    near("crank", summary["end_state"]["phi_crank"].as_f64().expect("an angle"), angle, 1e-12);
    near("yoke", summary["end_state"]["s_guide"].as_f64().expect("a length"), 0.2 * angle.cos(), 1e-12);
}

#[test]
fn welded_links_are_one_pendulum() {
    let end = end(&path("weld"));
    // The energy of one rigid body about its pivot.
    let [upper, lower] = [(1.2, 0.6_f64), (0.8, 0.4)];
    let inertia = upper.0 * upper.1.powi(2) / 3.0 + lower.0 * (lower.1.powi(2) / 3.0 + upper.1.powi(2));
    let energy = |angle: f64, rate: f64| {
        let height = upper.0 * 0.3 * angle.sin() + lower.0 * (0.6 * angle.sin() + 0.2 * (angle + PI / 2.0).sin());
        0.5 * inertia * rate.powi(2) + 9.81 * height
    };
    near("energy", energy(end("phi_upper"), end("phi_upper_dot")), energy(0.3, 0.1), 1e-11);
    assert!(end("phi_upper") < 0.0, "it has fallen");
}

#[test]
fn a_rod_without_mass_keeps_a_distance() {
    let end = end(&path("rod"));
    let (angle, rate) = (end("phi_crank"), end("phi_crank_dot"));
    let place = |angle: f64| 0.2 * angle.cos() + (0.25 - (0.2 * angle.sin()).powi(2)).sqrt();
    near("piston", end("s_guide"), place(angle), 1e-12);
    let energy = |angle: f64, rate: f64| {
        let slope = (place(angle + 1e-5) - place(angle - 1e-5)) / 2e-5;
        2.0 * 0.04 / 6.0 * rate.powi(2) + 0.75 * (slope * rate).powi(2)
    };
    near("energy", energy(angle, rate), energy(1.0, 5.0), 1e-8);
}

#[test]
fn a_link_without_joints_flies() {
    let end = end(&path("free"));
    near("angle", end("phi_bar"), 2.3, 1e-12);
    // The centre of mass flies along a parabola, 0.4 m from the origin of the bar.
    let com = |origin: f64, along: f64| origin + 0.4 * along;
    let rate = [3.0 - 0.4 * 2.0 * 0.3_f64.sin(), 4.0 + 0.4 * 2.0 * 0.3_f64.cos()];
    near("x", com(end("x_bar"), 2.3_f64.cos()), com(0.1, 0.3_f64.cos()) + rate[0], 1e-12);
    near("y", com(end("y_bar"), 2.3_f64.sin()), com(0.2, 0.3_f64.sin()) + rate[1] - 9.81 / 2.0, 1e-11);
}

#[test]
fn the_scene_that_it_becomes_moves_the_same() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for entry in fs::read_dir(path("").replace("/.toml", "")).expect("the scenes") {
        let own = entry.expect("an entry").path();
        let printed = qrm(&["derive", "--scene"]).arg(&own).output().expect("the command starts");
        assert!(printed.status.success(), "{}", String::from_utf8_lossy(&printed.stderr));
        let file = folder.path().join("expanded.toml");
        fs::write(&file, &printed.stdout).expect("written");
        let state = |scene: &std::path::Path| -> Value {
            let run = common::run(&[&scene.display().to_string(), "--no-figures"]);
            assert_eq!(run.status(), 0, "{}: {}", scene.display(), run.stderr());
            run.summary()["end_state"].clone()
        };
        assert_eq!(state(&own), state(&file), "{}", own.display());
    }
}

#[test]
fn a_four_bar_and_a_quick_return_are_short() {
    for (name, most) in [("four-bar", 12), ("quick-return", 20)] {
        let text = fs::read_to_string(path(name)).expect("a scene");
        assert!(text.lines().count() <= most, "{name}: {} lines", text.lines().count());
    }
}
