//! `qrm modes` and `qrm linearize` against closed forms, 40 digits and runs.

use std::f64::consts::TAU;
use std::path::Path;
use std::process::Output;

use serde_json::Value;
use tempfile::TempDir;

use crate::common::qrm;

/// `qrm COMMAND ARGUMENTS --out` into a fresh folder.
fn output(arguments: &[&str]) -> (TempDir, Output) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut command = qrm(arguments);
    command.arg("--out").arg(folder.path());
    let output = command.output().expect("the command starts");
    (folder, output)
}

fn json(path: &Path) -> Value {
    serde_json::from_str(&std::fs::read_to_string(path).expect("it was written")).expect("it is JSON")
}

/// The contents of a file of a command that succeeds.
fn file(arguments: &[&str], name: &str) -> Value {
    let (folder, output) = output(arguments);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    json(&folder.path().join(name))
}

/// The contents of `modes.json`.
fn modes(arguments: &[&str]) -> Value {
    file(&[&["modes"], arguments].concat(), "modes.json")
}

/// The error of a command that fails.
fn error(arguments: &[&str]) -> String {
    let (_, output) = output(arguments);
    assert!(!output.status.success(), "{}", String::from_utf8_lossy(&output.stdout));
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn number(value: &Value) -> f64 {
    value.as_f64().expect("a number")
}

/// Compares a number with its value: its error is at most three times the stated one, which is small.
fn within(found: &Value, stated: &Value, expected: f64, most: f64) {
    let (found, stated) = (number(found), number(stated));
    let error = (found - expected).abs();
    assert!(
        error <= 3.0 * stated && stated <= most,
        "{found} instead of {expected}: off by {error:e}, stated {stated:e}"
    );
}

/// Compares derivatives to this part of their values.
fn derivatives(mode: &Value, expected: &[(&str, f64)], part: f64) {
    for (name, expected) in expected {
        let found = number(&mode["by"][name]);
        assert!((found - expected).abs() <= part * expected.abs(), "{name}: {found} instead of {expected}");
    }
}

/// `w^2 = (2 -+ sqrt 2) g/l`, with the lower mass `+-sqrt 2` as far as the upper one.
#[test]
fn a_double_pendulum_has_the_frequencies_of_its_closed_form() {
    let found = modes(&["double-pendulum", "--at", "a=10deg,b=3deg"]);
    assert_eq!(found["equilibrium"]["stability"], "stable");
    for (mode, sign) in [(0, -1.0), (1, 1.0)] {
        let rate = ((2.0 + sign * 2.0_f64.sqrt()) * 9.81).sqrt();
        let mode = &found["modes"][mode];
        within(&mode["rate"], &mode["rate_error"], rate, 1e-14 * rate);
        within(&mode["frequency"], &mode["frequency_error"], rate / TAU, 1e-14 * rate);
        assert!((number(&mode["shape"]["a"]) + sign * 0.5_f64.sqrt()).abs() < 1e-14, "{mode}");
        assert!((number(&mode["shape"]["b"]) - 1.0).abs() < 1e-15, "{mode}");
        derivatives(mode, &[("g", 0.5 * rate / 9.81), ("l", -0.5 * rate)], 1e-13);
        assert!(number(&mode["by"]["m"]).abs() < 1e-13 * rate, "{mode}");
    }
    // All four positions in which the rods hang or stand.
    assert_eq!(found["others"].as_array().expect("others").len(), 3);
    let standing = &found["others"].as_array().expect("others")[2];
    let growth = ((2.0 + 2.0_f64.sqrt()) * 9.81).sqrt();
    assert_eq!(standing["stability"], "unstable");
    assert!((number(&standing["growth"]) - growth).abs() < 1e-13 * growth, "{standing}");
}

/// Equilibrium, frequency and derivatives come from the reduced potential and mass of the loop with 50 digits.
#[test]
#[ignore = "full tier: engine"]
fn a_four_bar_with_springs_to_forty_digits() {
    let found = modes(&["tests/modes/four-bar-springs.toml"]);
    let at = &found["equilibrium"];
    let place = [("a", 1.058_464_928_424_014), ("b", 0.400_531_533_206_956_2), ("c", 1.535_284_947_922_927_4)];
    for (name, expected) in place {
        within(&at["coordinates"][name], &at["errors"][name], expected, 1e-14);
    }
    let mode = &found["modes"][0];
    within(&mode["rate"], &mode["rate_error"], 19.800_911_804_521_634, 1e-12);
    let by = [
        ("d", 19.675_006_423_482_142),
        ("l1", -115.539_786_070_033_81),
        ("l2", -23.034_378_608_490_613),
        ("l3", 18.048_384_010_780_968),
        ("m1", -1.268_572_591_090_179),
        ("m2", -3.137_994_011_321_55),
        ("m3", -0.557_538_219_875_334_7),
        ("J1", -109.440_430_126_115_22),
        ("J2", -5.542_257_226_622_744),
        ("J3", -16.263_042_324_658_306),
        ("g", -0.081_629_871_705_397_56),
        ("k1", 0.286_972_214_360_137_9),
        ("k3", -0.028_423_235_182_191_086),
        ("a0", -5.365_020_092_797_844),
        ("c0", -4.791_585_532_966_689),
        ("T", -0.134_125_502_319_946_09),
    ];
    derivatives(mode, &by, 1e-11);
    assert_eq!(mode["by"]["e"], 0.0);
    let value = &found["eigenvalues"][0];
    within(&value["re"], &value["error"], -0.492_796_770_730_867_9, 1e-12);
    within(&value["im"], &value["error"], 19.794_778_595_205_39, 1e-12);
    assert_eq!(at["stability"], "asymptotically_stable");
}

/// `m x'' + c x' + k x = F`
#[test]
#[ignore = "full tier: engine"]
fn a_damped_oscillator_has_the_eigenvalues_of_its_closed_form() {
    let scene = "tests/modes/oscillator.toml";
    let found = modes(&[scene]);
    within(&found["equilibrium"]["coordinates"]["x"], &found["equilibrium"]["errors"]["x"], 0.2, 1e-15);
    let mode = &found["modes"][0];
    within(&mode["rate"], &mode["rate_error"], 5.0, 1e-14);
    derivatives(mode, &[("k", 0.05), ("m", -1.25)], 1e-14);
    let value = &found["eigenvalues"][0];
    within(&value["re"], &value["error"], -0.75, 1e-13);
    within(&value["im"], &value["error"], (25.0_f64 - 0.75 * 0.75).sqrt(), 1e-13);
    assert!((number(&value["damping_ratio"]) - 0.15).abs() < 1e-14 && (number(&value["time"]) - 4.0 / 3.0).abs() < 1e-13);
    // Critical damping: both eigenvalues are -5, and have half of the digits.
    let critical = modes(&[scene, "--set", "c=20"]);
    for value in critical["eigenvalues"].as_array().expect("eigenvalues") {
        within(&value["re"], &value["error"], -5.0, 1e-6);
        within(&value["im"], &value["error"], 0.0, 1e-6);
    }
    // Strong damping: a fast and a slow decay.
    let strong = modes(&[scene, "--set", "c=2000"]);
    let root = (500.0_f64 * 500.0 - 25.0).sqrt();
    within(&strong["eigenvalues"][0]["re"], &strong["eigenvalues"][0]["error"], -25.0 / (500.0 + root), 1e-14);
    within(&strong["eigenvalues"][1]["re"], &strong["eigenvalues"][1]["error"], -500.0 - root, 1e-10);
}
