//! Friction that follows from the forces in joints.

use crate::common;
use crate::common::{near, qrm};

fn path(name: &str) -> String {
    format!("{}/tests/linkage/{name}.toml", env!("CARGO_MANIFEST_DIR"))
}

fn crank() -> String {
    format!("{}/scenes/linkages/slider-crank-friction.toml", env!("CARGO_MANIFEST_DIR"))
}

/// Status, output and errors of a command.
fn said(arguments: &[&str]) -> (Option<i32>, String, String) {
    let output = qrm(arguments).output().expect("the command starts");
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (output.status.code(), text(&output.stdout), text(&output.stderr))
}

const TIGHT: [&str; 4] = ["--method", "dop853", "--tolerance", "1e-12"];

/// Simpson's rule over rows at equal distances.
fn integral(values: &[f64], step: f64) -> f64 {
    let weight = |i: usize| match i {
        0 => 1.0,
        i if i == values.len() - 1 => 1.0,
        i => [2.0, 4.0][i % 2],
    };
    step / 3.0 * values.iter().enumerate().map(|(i, value)| weight(i) * value).sum::<f64>()
}

#[test]
#[ignore = "full tier: engine"]
fn its_work_is_the_loss_of_energy() {
    let run =
        common::run(&[&[crank().as_str(), "--no-figures", "--end-time", "1", "--step", "1e-4"], &TIGHT[..]].concat());
    assert_eq!(run.status(), 0, "{}", run.stderr());
    let table = run.trajectory();
    let powers = |row: usize| ["P_O", "P_A", "P_B", "P_G"].iter().map(|name| table.number(row, name)).sum::<f64>();
    let powers: Vec<f64> = (0..=table.last()).map(powers).collect();
    assert!(powers.iter().all(|power| *power <= 0.0), "friction takes energy");
    let loss = table.number(table.last(), "energy") - table.number(0, "energy");
    assert!(loss < -1.0, "{loss}");
    near("work", integral(&powers, 1e-4), loss, 1e-6 * loss.abs());
}

#[test]
#[ignore = "full tier: engine"]
fn a_block_is_slowed_down_by_its_weight() {
    let dir = tempfile::tempdir().expect("a folder");
    let scene = dir.path().join("block.toml");
    let text = r#"
name = "block"
coordinates = [{ name = "s", unit = "m" }]
[parameters]
slope = '-pi/6'
[points]
P = ['s*cos(slope)', 's*sin(slope)']
[bodies]
block = { mass = 3, com = "P" }
[loads]
weight = { gravity = ['0', '-9.81'] }
rub = { along = 's', friction = 0.2, slip = 1e-3, normal = "N" }
[outputs]
N = { free_body = [{ bodies = ["block"], points = ["P"], along = ['-sin(slope)', 'cos(slope)'] }], unit = "N" }
[initial]
given = { s = 0, s_dot = 5 }
[run]
step = 1e-3
end_time = 0.5
"#;
    std::fs::write(&scene, text).expect("a scene");
    let run = common::run(&[scene.to_str().expect("a path"), "--no-figures"]);
    assert_eq!(run.status(), 0, "{}", run.stderr());
    let table = run.trajectory();
    let normal = 3.0 * 9.81 * 0.75_f64.sqrt();
    near("normal force", table.number(table.last(), "N"), normal, 1e-11);
    near("acceleration", table.number(table.last(), "s_ddot"), 9.81 / 2.0 - 0.2 * normal / 3.0, 1e-12);
}

/// One end of a rod pushes it into the line on which it slides: the critical coefficient is 4/3.
#[test]
#[ignore = "full tier: engine"]
fn where_there_is_no_solution_it_is_refused() {
    for (mu, is_possible) in [("1.333", true), ("1.334", false), ("3", false)] {
        let run = common::run(&[&path("painleve"), "--no-figures", "--set", &format!("mu={mu}"), "--end-time", "1e-4"]);
        let said = run.stderr();
        assert_eq!(!said.contains("Painleve"), is_possible, "{mu}: {said}");
        assert!(is_possible || said.contains("joint `line`"), "{said}");
    }
    // From the other side there are several: the slot holds the rod on both sides.
    let run = common::run(&[&path("painleve"), "--no-figures", "--set", "mu=3", "--set", "angle=atan(2)"]);
    assert!(run.stderr().contains("Painleve"), "{}", run.stderr());
}

#[test]
#[ignore = "full tier: engine"]
fn sticking_by_a_jump_is_named() {
    let scene = format!("{}/tests/singular/sticking.toml", env!("CARGO_MANIFEST_DIR"));
    for method in ["rk4", "dop853", "dopri5"] {
        let (status, _, errors) = said(&["run", &scene, "--no-figures", "--method", method]);
        assert_eq!(status, Some(1), "{method}");
        assert!(errors.contains("help: if the motion sticks where `sign` in a load jumps"), "{method}: {errors}");
    }
}

#[test]
#[ignore = "full tier: engine"]
fn what_it_cannot_be_combined_with_is_refused() {
    let (status, _, errors) = said(&["inverse", &crank()]);
    assert_ne!(status, Some(0));
    assert!(errors.contains("friction depends on the forces in joints"), "{errors}");
    // A second guide holds what the first one holds.
    let dir = tempfile::tempdir().expect("a folder");
    let scene = dir.path().join("twice.toml");
    let text = std::fs::read_to_string(crank()).expect("the scene");
    let twice = text.replace("[loads]", "G2 = { pin_in_slot = [\"piston.B\", \"ground.O\"] }\n[loads]");
    std::fs::write(&scene, twice).expect("a scene");
    let run = common::run(&[scene.to_str().expect("a path"), "--no-figures"]);
    assert_ne!(run.status(), 0);
    assert!(run.stderr().contains("that are not determined"), "{}", run.stderr());
}

#[test]
#[ignore = "full tier: engine"]
fn the_scene_that_it_becomes_moves_the_same() {
    let dir = tempfile::tempdir().expect("a folder");
    let (status, whole, errors) = said(&["derive", "--scene", &path("friction")]);
    assert_eq!(status, Some(0), "{errors}");
    let scene = dir.path().join("whole.toml");
    std::fs::write(&scene, whole).expect("a scene");
    let ends = [path("friction"), scene.to_str().expect("a path").to_owned()].map(|scene| {
        let run = common::run(&[&[scene.as_str(), "--no-figures"], &TIGHT[..]].concat());
        assert_eq!(run.status(), 0, "{}", run.stderr());
        run.summary()["end_state"]["phi_crank"].as_f64().expect("an angle")
    });
    near("crank", ends[0], ends[1], 1e-12);
}

#[test]
#[ignore = "full tier: engine"]
fn derivatives_go_through_it() {
    let scene = crank();
    let dir = tempfile::tempdir().expect("a folder");
    let asked = ["--end-time", "0.1", "--step", "1e-4", "--by", "mu", "--of", "F_A", "--out"];
    let folder = dir.path().to_str().expect("a path");
    let (status, text, errors) = said(&[&["sensitivity", scene.as_str()], &asked[..], &[folder]].concat());
    assert_eq!(status, Some(0), "{errors}");
    let line = text.lines().find(|line| line.contains("against difference quotients")).expect("a check");
    let difference: f64 = line.split_whitespace().nth(3).expect("a number").parse().expect("a number");
    assert!(difference < 1e-6, "{text}");
}
