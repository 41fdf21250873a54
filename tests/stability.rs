//! `qrm stability`: what the linearized equations predict against what runs do, and extreme cases by every method.

use std::process::Output;

use tempfile::TempDir;

use crate::common;
use crate::common::{Table, qrm};

/// `qrm stability ARGUMENTS --out` into a fresh folder.
fn output(arguments: &[&str]) -> (TempDir, Output) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let output = qrm(&["stability"]).args(arguments).arg("--out").arg(folder.path()).output().expect("it starts");
    (folder, output)
}

fn stability(arguments: &[&str]) -> (TempDir, String) {
    let (folder, output) = output(arguments);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    (folder, String::from_utf8_lossy(&output.stdout).into_owned())
}

/// The limit that is predicted, and the longest step of a run that held.
fn limits(folder: &TempDir) -> (f64, f64) {
    let text = std::fs::read_to_string(folder.path().join("stability.json")).expect("it was written");
    let limit: serde_json::Value = serde_json::from_str(&text).expect("it is JSON");
    let number = |value: &serde_json::Value| value.as_f64().expect("a number");
    (number(&limit["predicted_step"]), number(&limit["steps_by_trial"][0]))
}

fn column(folder: &TempDir, name: &str) -> Vec<f64> {
    let table = Table::read(&folder.path().join("stability.csv"));
    (0..table.rows.len()).map(|row| table.number(row, name)).collect()
}

#[test]
#[ignore = "full tier: compiled"]
fn predicted_steps_are_those_at_which_runs_blow_up() {
    for parameter in ["k", "cd"] {
        for exponent in 5..=9 {
            let set = format!("{parameter}=1e{exponent}");
            let arguments = ["quick-return-loaded", "--set", &set, "--end-time", "0.5", "--no-extremes"];
            let (predicted, found) = limits(&stability(&arguments).0);
            assert!((predicted / found - 1.0).abs() < 0.15, "{set}: {predicted:e} predicted, {found:e} found");
        }
    }
}

#[test]
fn rates_are_those_known_from_elsewhere() {
    // The largest c (dx6/dphi2)^2 / J along the motion, from the generalized inertia of the one freedom, with 50
    // digits.
    let arguments = ["quick-return-loaded", "--set", "cd=1e7", "--end-time", "0.05", "--no-extremes"];
    let (folder, _) = stability(&arguments);
    let fastest = column(&folder, "rate").into_iter().fold(0.0, f64::max);
    assert!((fastest / 6336.294 - 1.0).abs() < 1e-4, "{fastest}");
}

#[test]
fn derivatives_by_differences_give_what_generated_ones_give() {
    let [generated, differenced] = ["quick-return-loaded", "quick-return"]
        .map(|scene| stability(&[scene, "--end-time", "0.5", "--step", "0.05", "--no-extremes"]).0);
    for name in ["rate", "frequency", "growth", "longest_step", "condition_loops", "smallest_singular_value"] {
        let (generated, differenced) = (column(&generated, name), column(&differenced, name));
        assert!(!generated.is_empty() && generated.len() == differenced.len());
        for (a, b) in generated.iter().zip(&differenced) {
            assert!((a - b).abs() < 1e-6 * (1.0 + a.abs()), "{name}: {a} and {b}");
        }
    }
}

#[test]
#[ignore = "full tier: engine"]
fn no_extreme_case_is_wrong_in_silence() {
    let (folder, said) = stability(&["quick-return-loaded"]);
    let cases = Table::read(&folder.path().join("extremes.csv"));
    assert_eq!(cases.rows.len(), 10 * 6);
    for row in 0..cases.rows.len() {
        let (method, verdict) = (cases.text(row, "method"), cases.text(row, "verdict"));
        let expected = if method == "rk4" { ["right", "refused"] } else { ["right", "right"] };
        assert!(expected.contains(&verdict), "{} by {method}: {verdict}", cases.text(row, "case"));
    }
    assert!(said.contains("rk4      3 right, 7 refused by the run itself, 0 wrong and unnoticed"), "{said}");
    assert!(said.contains("Not stiff"), "{said}");
}

#[test]
#[ignore = "full tier: compiled"]
fn a_stiff_damper_is_called_stiff() {
    let arguments = ["quick-return-loaded", "--set", "cd=1e9", "--end-time", "0.5", "--no-extremes"];
    let (_, said) = stability(&arguments);
    assert!(said.contains("Stiff: ") && said.contains("RK4 cannot take the step used, 0.001 s"), "{said}");
}

#[test]
#[ignore = "full tier: engine"]
fn singular_positions_are_named() {
    let (_folder, scene) = common::with_slot("quick-return-loaded", "A.x/sqrt(A.x^2 + A.y^2) - cos(phi4)");
    let set = ["O2A=0.31", "BC=2", "BG5=1"].map(|set| ["--set", set]).concat();
    let (_, output) = output(&[&[scene.as_str(), "--no-extremes"][..], &set].concat());
    let said = String::from_utf8_lossy(&output.stdout);
    assert!(said.contains("constraint `slot` has no gradient there") && said.contains("phi4 = 3.14"), "{said}");
}

#[test]
fn a_motion_that_no_tolerance_follows_is_refused() {
    let (_, output) = output(&["double-pendulum", "--set", "a0=2.1", "--end-time", "40", "--no-extremes"]);
    assert_eq!(output.status.code(), Some(1));
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(said.contains("do not trust the numbers: the estimated error of `"), "{said}");
}
