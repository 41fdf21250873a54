//! Inverse dynamics as the command gives them.

use std::fs;
use std::path::Path;

use crate::common;
use crate::common::{near, qrm};

/// The columns of a table by their names.
fn columns(path: &Path) -> impl Fn(&str) -> Vec<f64> + use<> {
    let text = fs::read_to_string(path).expect("the table");
    let rows: Vec<Vec<String>> = text.lines().map(|line| line.split(',').map(str::to_owned).collect()).collect();
    move |name| {
        let place = rows[0].iter().position(|own| own == name).unwrap_or_else(|| panic!("no column `{name}`"));
        rows[1..].iter().map(|row| row[place].parse().expect("a number")).collect()
    }
}

/// A scene of a folder of the tests.
fn scene(name: &str) -> String {
    format!("{}/tests/{name}.toml", env!("CARGO_MANIFEST_DIR"))
}

fn inverse(arguments: &[&str]) -> (String, tempfile::TempDir) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let output = qrm(&["inverse"]).args(arguments).arg("--out").arg(folder.path()).output().expect("it starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    (String::from_utf8(output.stdout).expect("text"), folder)
}

#[test]
fn a_constant_speed_takes_the_torque_of_the_driven_scene() {
    let (_, folder) = inverse(&["quick-return", "--rate", "150*pi/60", "--time", "0.8", "--rows", "801"]);
    let own = columns(&folder.path().join("inverse.csv"))("torque_phi2");
    let run = common::run(&["quick-return-driven", "--step", "1e-3", "--end-time", "0.8", "--no-figures"]);
    let driven = columns(&run.path("trajectory.csv"))("lambda_drive");
    assert_eq!(own.len(), 801);
    for (torque, lambda) in own.iter().zip(&driven) {
        near("torque", *torque, -lambda, 1e-7);
    }
    let (_, folder) = inverse(&["quick-return-driven"]);
    let summary = fs::read_to_string(folder.path().join("inverse.json")).expect("the summary");
    let summary: serde_json::Value = serde_json::from_str(&summary).expect("JSON");
    let largest = own.iter().fold(f64::NEG_INFINITY, |most: f64, torque| most.max(*torque));
    let stated = summary["results"]["torque_drive"]["maximum"][0].as_f64().expect("a number");
    // Between two rows.
    assert!(stated >= largest && stated < largest + 2.0, "{stated} {largest}");
}

/// Work changes the energy: over a turn from rest to rest it is that of the loads alone.
#[test]
fn the_work_of_a_motion_from_rest_to_rest_is_that_of_its_loads() {
    for motion in ["trapezoid", "polynomial"] {
        let (text, folder) =
            inverse(&["quick-return", "--motion", motion, "--time", "2", "--set", "F6=0", "--rows", "4001"]);
        assert!(text.contains("360.0000 deg in 2 s"), "{text}");
        let column = columns(&folder.path().join("inverse.csv"));
        let (t, power) = (column("t"), column("power"));
        let pieces = t.windows(2).zip(power.windows(2));
        let work: f64 = pieces.map(|(t, p)| 0.5 * (t[1] - t[0]) * (p[0] + p[1])).sum();
        let largest = power.iter().fold(0.0, |most: f64, power| most.max(power.abs()));
        assert!(work.abs() < 1e-6 * largest, "{motion}: {work} of {largest}");
    }
}

#[test]
fn a_table_is_followed_through_its_rows() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let table = folder.path().join("motion.csv");
    fs::write(&table, "t, phi2\n0, 0\n0.1, 0.3\n0.25, 1.2\n0.4, 1.5\n").expect("written");
    let motion = format!("table:{}", table.display());
    let (_, out) = inverse(&["quick-return", "--motion", &motion, "--rows", "9"]);
    let column = columns(&out.path().join("inverse.csv"));
    let (t, angle, torque) = (column("t"), column("phi2"), column("torque_phi2"));
    for (time, value) in [(0.0, 0.0), (0.1, 0.3), (0.25, 1.2), (0.4, 1.5)] {
        let row = t.iter().position(|t| *t == time).expect("a row");
        near("angle", angle[row], value, 1e-14);
        assert!(torque[row].is_finite());
    }
}

/// A mass on a spring and a damper: force = m a + c v + k x, along a coordinate that is a length.
#[test]
#[ignore = "full tier: engine"]
fn a_length_is_moved_by_a_force() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let scene = folder.path().join("block.toml");
    let written = qrm(&["new", "block", "--from", "empty", "--out"]).arg(&scene).output().expect("it starts");
    assert!(written.status.success());
    let text = fs::read_to_string(&scene).expect("the scene");
    let power = text.replace("[outputs]", "[outputs]\npower = { value = 'x', unit = \"m\" }");
    assert_ne!(power, text);
    fs::write(&scene, power).expect("written");
    let scene = scene.display().to_string();
    let (_, out) = inverse(&[&scene, "--motion", "x=0.1*sin(3*t)", "--time", "2", "--rows", "101"]);
    let column = columns(&out.path().join("inverse.csv"));
    let (t, force) = (column("t"), column("force_x"));
    for (t, force) in t.iter().zip(&force) {
        let (sin, cos) = (3.0 * t).sin_cos();
        let expected = -0.9 * 1.0 * sin + 0.3 * 0.5 * cos + 0.1 * 100.0 * sin;
        near("force", *force, expected, 1e-12 * expected.abs().max(1.0));
    }
    // An output of this name is there already.
    assert_eq!(column("power_").len(), t.len());
}

/// The statistics of a force or torque in the summary.
fn statistics(folder: &Path, name: &str) -> serde_json::Value {
    let summary = fs::read_to_string(folder.join("inverse.json")).expect("the summary");
    let summary: serde_json::Value = serde_json::from_str(&summary).expect("JSON");
    summary["results"][name].clone()
}

/// Crank and rod of one length pass the position in which they fold.
#[test]
#[ignore = "full tier: engine"]
fn branches_that_cross_are_followed_smoothly() {
    let (_, folder) = inverse(&[&scene("singular/equal-links")]);
    let columns = columns(&folder.path().join("inverse.csv"));
    for (t, torque) in columns("t").iter().zip(columns("torque_O_drive")) {
        near("torque", torque, 250.0 * (10.0 * t).sin(), 1e-9);
    }
    let mean = statistics(folder.path(), "torque_O_drive")["mean"].as_f64().expect("a number");
    near("mean", mean, 12.5 * (1.0 - f64::cos(20.0)), 1e-10);
}

/// A slider is driven through its dead points, a pin by a law: the extremes are those of `tests/singular.rs`, of 40
/// digits. The motion of a kite is the same before and after its change point, backwards and mirrored.
#[test]
#[ignore = "full tier: engine"]
fn forces_at_dead_points_are_limits() {
    for (name, force, extremes) in [
        ("dead-points", "force_G_drive", [-6.374119509036878, 5.757269233968793]),
        ("crank-by-law", "force_push", [1.3159472534786, 1.9739208802179]),
    ] {
        let (_, folder) = inverse(&[&scene(&format!("singular/{name}"))]);
        let own = statistics(folder.path(), force);
        let error = own["extreme_error"].as_f64().expect("a number");
        assert!((1e-13..3e-9).contains(&error), "{name}: {error}");
        for (end, exact) in ["minimum", "maximum"].into_iter().zip(extremes) {
            near(name, own[end][0].as_f64().expect("a number"), exact, 3.0 * error);
        }
        let columns = columns(&folder.path().join("inverse.csv"));
        assert!(columns(force).iter().all(|force| (extremes[0] - 1e-8..extremes[1] + 1e-8).contains(force)), "{name}");
    }
    let (_, folder) = inverse(&[&scene("singular/kite"), "--time", "10*pi/3"]);
    let columns = columns(&folder.path().join("inverse.csv"));
    let torque = columns("torque_phi_crank");
    for (before, after) in torque.iter().zip(torque.iter().rev()) {
        near("torque", *before, -after, 1e-11);
    }

    // The acceleration that is prescribed jumps where crank and rod fold, at a third of the time.
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("crank.toml");
    let text = fs::read_to_string(scene("singular/equal-links")).expect("a scene");
    let text = text.replace("drive = '5*t'", "").replace("T = { drive = \"O\" }", "");
    let text = text.replace("\"ground\"],  }", "\"ground\"] }");
    let given = text.replace("length = 1, mass = 1 }", "length = 1, mass = 1, angle = 0, rate = 5 }");
    fs::write(&file, given).expect("written");
    let mut refused = qrm(&["inverse", "--motion", "trapezoid", "--time", "2"]);
    let refused = refused.arg(&file).arg("--out").arg(folder.path()).output().expect("it starts");
    let stderr = String::from_utf8_lossy(&refused.stderr);
    assert!(stderr.contains("the motion reaches a dead point near phi_crank = 8"), "{stderr}");

    // With an offset no force at the slider can change the rate of the crank at its dead points.
    let text = fs::read_to_string(scene("singular/dead-points")).expect("a scene");
    let offset = "sqrt(0.1599) + 0.5*(sqrt(0.1599) - sqrt(0.0399))*(cos(2*pi*t + 60deg) - 1)";
    let text = text.replace("G = [0, 0]", "G = [0, 0.01]").replace("0.3 + 0.1*cos(2*pi*t + 60deg)", offset);
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("offset.toml");
    fs::write(&file, text).expect("written");
    let refused = qrm(&["inverse"]).arg(&file).arg("--out").arg(folder.path()).output().expect("it starts");
    assert_eq!(refused.status.code(), Some(1));
    let stderr = String::from_utf8_lossy(&refused.stderr);
    assert!(stderr.contains("the motion reaches a dead point near phi_crank = "), "{stderr}");
}

/// A spring that is touched for a short time near each dead point: the mean torque and power are those of adaptive
/// quadrature with the corners as ends, of 30 digits.
#[test]
#[ignore = "full tier: engine"]
fn integrals_know_of_corners() {
    let (_, folder) = inverse(&[&scene("extremes/stop")]);
    for (name, exact) in [("torque_O_drive", 0.0346073244845), ("power", 9.09191804625)] {
        let own = statistics(folder.path(), name);
        let [mean, error] = ["mean", "mean_error"].map(|key| own[key].as_f64().expect("a number"));
        near(name, mean, exact, 3.0 * error + 1e-11);
        assert!(error < 1e-6, "{name}: {error}");
    }
}

#[test]
#[ignore = "full tier: compiled"]
fn impossible_motions_are_refused() {
    let refused = |arguments: &[&str], status: i32, text: &str| {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let output = qrm(&["inverse"]).args(arguments).arg("--out").arg(folder.path()).output().expect("it starts");
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert!(stderr.contains(text), "{arguments:?}: {stderr}");
        assert_eq!(output.status.code(), Some(status), "{arguments:?}");
    };
    refused(&["four-bar"], 1, "the mechanism locks at q1 = 157.3801 deg");
    refused(&["double-pendulum"], 2, "which coordinate is to move?");
    refused(&["double-pendulum", "--motion", "constant"], 2, "which coordinate?");
    refused(&["quick-return", "--motion", "phi4=constant"], 2, "does not give `phi4` at its start");
    refused(&["quick-return", "--motion", "constnat"], 2, "contains the name `constnat`");
    refused(&["quick-return", "--motion", "t*"], 2, "--motion");
    refused(&["quick-return", "--motion", "table:/nowhere.csv"], 2, "is no table of a motion");
    refused(&["quick-return", "--motion", "trapezoid", "--time", "0"], 2, "must be above zero");
    refused(&["quick-return", "--motion", "polynomial", "--distance=-1"], 2, "how long is the motion");
    refused(&["quick-return", "--motion", "constant", "--motion", "constant"], 2, "has two motions");
    refused(&["quick-return-driven", "--motion", "constant"], 2, "prescribe its motion already");
    refused(&["quick-return", "--motion", "log(t - 1)"], 1, "is not finite at t = 0 s");
    refused(&["quick-return", "--motion", "sqrt(t)", "--time", "1"], 1, "is not finite at t = 0 s");
    refused(
        &["quick-return", "--motion", "sign(t - 0.5)", "--time", "1"],
        1,
        "the motion of `phi2` jumps after t = 0.5",
    );
    refused(&["quick-return", "--motion", "3*t", "--rate", "1"], 2, "`--rate` has no meaning");
    refused(&["quick-return", "--motion", "exp(30*t)", "--time", "2"], 1, "too far from one row to the next");
}
