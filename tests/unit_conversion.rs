//! Scenes with units move like the same scenes in SI units.

use std::f64::consts::PI;
use std::fs;

use crate::common::{near, qrm, run};

/// A scene of these tests.
fn scene(name: &str) -> String {
    format!("{}/tests/unit_conversion/{name}.toml", env!("CARGO_MANIFEST_DIR"))
}

/// The last row of a run, by the names of the columns.
fn last_row(arguments: &[&str]) -> impl Fn(&str) -> f64 + use<> {
    let run = run(&[arguments, &["--no-figures", "--no-error-estimate"]].concat());
    assert_eq!(run.status(), 0, "{}", run.stderr());
    let table = run.trajectory();
    move |name| {
        let place = table.columns.iter().position(|own| own == name).unwrap_or_else(|| panic!("no column `{name}`"));
        table.rows.last().expect("a row")[place].parse().expect("a number")
    }
}

/// Outputs, and their units in the scene with units.
const OUTPUTS: [(&str, f64); 7] = [
    ("turned", PI / 180.0),
    ("speed_rocker", PI / 30.0),
    ("height", 1e-3),
    ("pin", 1e3),
    ("pin_x", 1e3),
    ("power", 1e-3),
    ("phi_crank", 1.0),
];

#[test]
#[ignore = "full tier: engine"]
fn a_scene_in_units_moves_like_the_scene_in_si_units() {
    let [drawing, si] = [&["drawing"], &["si"]].map(|[name]| scene(name));
    let sets: [[&[&str]; 2]; 3] = [
        [&[], &[]],
        [
            &["--set", "crank=12 cm", "--set", "speed=20 rad/s", "--set", "k=3 N/cm"],
            &["--set", "crank=0.12", "--set", "speed=20", "--set", "k=300"],
        ],
        [
            &["--set", "slope=-20", "--set", "m=1 lb", "--end-time", "20 ms"],
            &["--set", "slope=-20 deg", "--set", "m=0.45359237", "--end-time", "0.02"],
        ],
    ];
    for [with_units, without] in sets {
        let own = last_row(&[&[drawing.as_str()], with_units].concat());
        let other = last_row(&[&[si.as_str()], without].concat());
        for (name, factor) in OUTPUTS {
            let (own, other) = (own(name) * factor, other(name));
            near(name, own, other, 1e-10 * (1.0 + other.abs()));
        }
    }
}

#[test]
#[ignore = "full tier: engine"]
fn conditions_and_designs_take_units() {
    let drawing = scene("drawing");
    let at = |condition: &str| last_row(&[&drawing, "--until", condition])("t");
    let first = at("height >= 11 cm");
    assert!(first > 0.0 && first < 0.05, "{first}");
    near("the same in m", at("P.y >= 0.11"), first, 1e-9);
    let refused = |arguments: &[&str], text: &str| {
        let output = qrm(arguments).output().expect("it starts");
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert!(!output.status.success() && stderr.contains(text), "{arguments:?}: {stderr}");
    };
    refused(&["run", &drawing, "--until", "height >= 110"], "a term has no unit, and a length is expected");
    refused(&["run", &drawing, "--until", "height >= 110 deg"], "a length and an angle cannot be");
    refused(&["run", &drawing, "--set", "crank=12 kN"], "expected a length, found a force");
    refused(&["run", &drawing, "--step", "1 mm"], "expected a time, found a length");
    refused(&["run", &drawing, "--start", "phi_crank_dot=1 m/s"], "expected an angular velocity, found a velocity");

    let folder = tempfile::tempdir().expect("a temporary folder");
    let table = folder.path().join("sweep.csv").display().to_string();
    let output = qrm(&["sweep", &drawing, "--vary", "crank=80 mm,9 cm", "--out", &table]).output().expect("it starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = fs::read_to_string(&table).expect("the table");
    let crank = text.lines().next().expect("names").split(',').position(|name| name == "crank").expect("the parameter");
    let values: Vec<&str> = text.lines().skip(1).map(|line| line.split(',').nth(crank).expect("a value")).collect();
    assert_eq!(values, ["80.0", "90.0"]);
}
