//! `qrm import`: scenes of models of other programs, and their motion against published results.

use std::fs;
use std::path::Path;
use std::process::Output;

use crate::common::{Table, near, qrm};

/// Imports a model of `tests/import` into a folder.
fn import(model: &str, folder: &Path, arguments: &[&str]) -> Output {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/import").join(model);
    let mut command = qrm(&["import"]);
    command.arg(file).args(arguments).current_dir(folder);
    command.output().expect("the command starts")
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&[&output.stdout[..], &output.stderr[..]].concat()).into_owned()
}

/// Imports a model, runs its scene and returns the rows.
fn rows(model: &str) -> Table {
    let folder = tempfile::tempdir().expect("a folder");
    let output = import(model, folder.path(), &["--out", "scene.toml", "--name", "imported"]);
    assert!(output.status.success(), "{}", said(&output));
    let mut run = qrm(&["run", "scene.toml", "--out", "out"]);
    let output = run.current_dir(folder.path()).output().expect("the command starts");
    assert!(output.status.success(), "{}", said(&output));
    Table::read(&folder.path().join("out/trajectory.csv"))
}

#[test]
fn a_scene_is_written_once_and_with_the_name_of_its_file() {
    let folder = tempfile::tempdir().expect("a folder");
    let output = import("four-bar.asmt", folder.path(), &[]);
    assert!(said(&output).starts_with("wrote four-bar.toml, 3 links and 4 joints of an assembly"), "{}", said(&output));
    let text = fs::read_to_string(folder.path().join("four-bar.toml")).expect("a scene");
    assert!(text.contains("\nname = \"four-bar\"\n"), "{text}");
    assert!(text.starts_with("# Imported from four-bar.asmt, an assembly of the Ondsel solver.\n"), "{text}");
    let again = import("four-bar.asmt", folder.path(), &[]);
    assert_eq!(again.status.code(), Some(2));
    assert!(said(&again).contains("four-bar.toml is there already"), "{}", said(&again));
    assert_eq!(fs::read_to_string(folder.path().join("four-bar.toml")).expect("a scene"), text);
    // The same model gives the same text.
    import("four-bar.asmt", folder.path(), &["--out", "other.toml"]);
    assert_eq!(fs::read_to_string(folder.path().join("other.toml")).expect("a scene"), text);
}

#[test]
fn wrong_names_and_files_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("model.txt");
    let refuse = |content: &[u8], arguments: &[&str], text: &str| {
        fs::write(&file, content).expect("written");
        let output = qrm(&["import", "model.txt"]).args(arguments).current_dir(folder.path()).output().expect("starts");
        assert_eq!(output.status.code(), Some(2), "{}", said(&output));
        assert!(said(&output).contains(text), "{}", said(&output));
        assert!(!folder.path().join("model.toml").exists());
    };
    refuse(b"ground a R 0 0", &["--name", "My Scene"], "cannot be the name of a scene");
    refuse(b"", &[], "model.txt is empty");
    refuse(b"\xff\xfe<\0", &[], "UTF-16");
    refuse(b"<mujoco>\xff</mujoco>", &[], "is not UTF-8 text: line 1");
    refuse(b"hello", &[], "this is not a model that can be imported");
    refuse("9 ".repeat(1_000_000).as_bytes(), &[], "this is not a model that can be imported");
    refuse(b"ground a R 0 0\na b R 0 0\nb c R 0 0\nc ground R 0 0", &[], "the scene of this model has an error");
    refuse(b"ground a R 0 0", &["--out", "c.txt"], "c.txt is not the name of a scene file");
    refuse(b"ground a R 0 0\na b R 1 0\nb ground R 1 1", &[], "this model cannot move");
    let output = qrm(&["import", "."]).current_dir(folder.path()).output().expect("starts");
    assert!(said(&output).contains(". is a folder"), "{}", said(&output));
    let output = qrm(&["import", "missing.txt"]).current_dir(folder.path()).output().expect("starts");
    assert!(said(&output).contains("cannot read missing.txt"), "{}", said(&output));
}

/// The torque and the forces that the Ondsel solver publishes for this four-bar, with 14 digits.
#[test]
#[ignore = "full tier: commands"]
fn a_four_bar_of_ondsel_has_its_published_torque() {
    let rows = rows("four-bar.asmt");
    // The solver states the torque and the forces on the first marker, which is on the ground and on the crank.
    let published = [(0, -12.193233423319), (250, 1.439401188672), (500, -7.2826054679257), (750, 4.3314192323015)];
    for (row, torque) in published {
        near(&format!("torque in row {row}"), rows.number(row, "T_O"), torque, 1e-12 * f64::abs(torque));
    }
    let forces = [
        ("F_O_x", -27.138030750487),
        ("F_O_y", -14.260541779148),
        ("F_A_x", 23.979757342138),
        ("F_A_y", 16.222541779148),
    ];
    for (column, force) in forces {
        near(column, rows.number(0, column), force, 1e-12 * f64::abs(force));
    }
}

/// The results of a slider-crank that the Ondsel solver stores in its file for the start.
#[test]
#[ignore = "full tier: commands"]
fn a_slider_crank_of_ondsel_has_its_stored_forces() {
    let rows = rows("slider-crank.asmt");
    let stored = [
        ("T_O", 199.11480726164132),
        ("F_O_x", -198.20664630113217),
        ("F_O_y", 249.8745090770516),
        ("F_A_x", 195.04837289278356),
        ("F_A_y", -247.91250907705162),
        ("F_B_x", 190.31096278026067),
        ("F_B_y", -241.27091797753303),
        ("F_Guide_x", 190.31096278026064),
    ];
    for (column, force) in stored {
        near(column, rows.number(0, column), force, 1e-13 * f64::abs(force));
    }
}

/// The accelerations that MuJoCo 4.0.0 computes for an open chain with springs, dampers and actuators.
#[test]
#[ignore = "full tier: commands"]
fn an_arm_of_mujoco_has_its_accelerations() {
    let rows = rows("arm.xml");
    let [upper, lower] = ["phi_upper_ddot", "phi_lower_ddot"].map(|name| rows.number(0, name));
    near("shoulder", -upper, 29.643762049370576, 1e-13);
    near("elbow", lower - upper, 44.37106415100621, 1e-13);
    near("slide", rows.number(0, "s_slide_ddot"), 11.859652362501722, 1e-13);
}

/// The accelerations of loops with exact constraints, from mass matrix, forces and Jacobian of MuJoCo 4.0.0.
#[test]
#[ignore = "full tier: commands"]
fn loops_of_mujoco_have_the_accelerations_of_exact_constraints() {
    let rows = rows("loops.xml");
    near("crank", rows.number(0, "phi_crank_ddot"), 0.461572505488763, 1e-13);
    near("rocker", rows.number(0, "phi_rocker_ddot"), -0.3077150036591753, 1e-13);
    near("wheel", -rows.number(0, "phi_wheel_ddot"), -1.153931263721915, 1e-13);
    near("rack", rows.number(0, "s_R_ddot"), -0.3461793791165724, 1e-13);
    near("cart", rows.number(0, "s_cy_ddot"), -9.81, 1e-13);
}
