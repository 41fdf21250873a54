//! Cams, belts, and splines through tables.

use std::f64::consts::{PI, TAU};

use crate::common;
use crate::common::{Run, near};

/// Runs a scene of this text by tight steps.
fn run(text: &str, more: &[&str]) -> Run {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("scene.toml");
    std::fs::write(&path, text).expect("a scene");
    let tight = ["--no-figures", "--method", "dop853", "--tolerance", "1e-12"];
    let run = common::run(&[&[path.to_str().expect("a path")], &tight[..], more].concat());
    assert_eq!(run.status(), 0, "{}", run.stderr());
    run
}

/// The standard output and error output of a run.
fn said(run: &Run) -> String {
    String::from_utf8_lossy(&run.output.stdout).into_owned() + &run.stderr()
}

/// A cam that turns at a constant speed, and a tappet above it, which gravity and a spring press down.
fn tappet(lobe: &str) -> String {
    format!(
        r#"
name = "tappet"
run = {{ step = 1e-3, end_time = 1 }}
[links]
ground = {{ points = {{ O = [0, 0], G = [0.01, 0.2] }} }}
cam    = {{ points = {{ O = [0, 0] }}, inertia = 1 }}
tappet = {{ points = {{ F = [0, 0] }}, mass = 0.5, com = "F" }}
[joints]
O     = {{ revolute = ["cam", "ground"], drive = '10*t' }}
guide = {{ prismatic = ["tappet.F", "ground.G"], direction = '90deg', start = -0.15 }}
lobe  = {{ cam = ["tappet.F", "cam.O"], {lobe}, one_sided = ">= 0" }}
[loads]
weight = {{ gravity = [0, -9.81] }}
spring = {{ along = 'F.y', spring = 400 }}
[outputs]
F = {{ joint = "lobe" }}
T = {{ drive = "O" }}
y = {{ value = 'F.y', unit = "m" }}
v = {{ rate = 'F.y', unit = "m/s" }}
a = {{ second_rate = 'F.y', unit = "m/s^2" }}
"#
    )
}

/// A flat face on an eccentric moves by the cosine, whatever its offset.
#[test]
#[ignore = "full tier: engine"]
fn a_flat_face_on_an_eccentric() {
    let run = run(&tappet("face = '90deg', profile = '0.04 + 0.01*cos(theta)'"), &[]);
    let table = run.trajectory();
    for row in (0..=table.last()).step_by(37) {
        // The normal points up: the cam sees it turn back.
        let angle = PI / 2.0 - 10.0 * table.number(row, "t");
        near("place", table.number(row, "y"), 0.04 + 0.01 * angle.cos(), 1e-13);
        near("rate", table.number(row, "v"), 0.1 * angle.sin(), 1e-12);
        near("acceleration", table.number(row, "a"), -angle.cos(), 1e-11);
        let force = 0.5 * (9.81 - angle.cos()) + 400.0 * (0.04 + 0.01 * angle.cos());
        near("force", table.number(row, "F_y"), force, 1e-10);
        // Power: the face rises by the force, the shaft turns at 10 rad/s.
        near("torque", table.number(row, "T"), force * 0.1 * angle.sin() / 10.0, 1e-11);
    }
    assert!(!said(&run).contains("one-sided"), "{}", said(&run));
}

/// A point beside the axis on a disc about its middle stays where it is, and is pushed towards the axis' other side.
#[test]
#[ignore = "full tier: engine"]
fn a_point_on_a_disc() {
    let run = run(&tappet("profile = '0.05', near = [0.01, 0.049]"), &[]);
    let table = run.trajectory();
    let height = (0.05_f64.powi(2) - 0.01_f64.powi(2)).sqrt();
    for row in (0..=table.last()).step_by(97) {
        near("place", table.number(row, "y"), height, 1e-13);
        let force = 0.5 * 9.81 + 400.0 * height;
        near("force, y", table.number(row, "F_y"), force, 1e-10);
        near("force, x", table.number(row, "F_x"), force * 0.01 / height, 1e-10);
        let angle = (height / 0.01).atan();
        let seen = table.number(row, "theta_lobe") + 10.0 * table.number(row, "t");
        near("contact", seen, angle, 1e-12);
    }
}

/// The spline through a cosine at every degree is the cosine up to the fourth power of a degree.
#[test]
#[ignore = "full tier: engine"]
fn a_table_with_a_periodic_spline_lifts() {
    let (mut x, mut y) = (Vec::new(), Vec::new());
    for degree in (0..=360).step_by(5) {
        x.push(degree.to_string());
        y.push(format!("{:.17}", 10.0 * f64::from(degree % 360).to_radians().cos()));
    }
    let table =
        format!("[tables]\nlift = {{ x = [{}], y = [{}], spline = \"periodic\" }}\n", x.join(", "), y.join(", "));
    let text = tappet("face = '90deg', profile = '0.04 + 1e-3*lift(theta*180/pi)'").replacen(
        "[links]",
        &(table + "[links]"),
        1,
    );
    let run = run(&text, &["--end-time", "2"]);
    let rows = run.trajectory();
    let h = 5.0_f64.to_radians();
    for row in (0..=rows.last()).step_by(37) {
        let angle = PI / 2.0 - 10.0 * rows.number(row, "t");
        near("place", rows.number(row, "y"), 0.04 + 0.01 * angle.cos(), 0.01 * h.powi(4) / 300.0);
        near("rate", rows.number(row, "v"), 0.1 * angle.sin(), 0.1 * h.powi(3) / 20.0);
        near("acceleration", rows.number(row, "a"), -angle.cos(), h.powi(2) / 6.0);
    }
    assert!(rows.number(rows.last(), "theta_lobe") < -2.0 * TAU, "it has turned several times");
}

#[test]
#[ignore = "full tier: engine"]
fn a_follower_that_lifts_off_is_told() {
    // Downward the face would have to accelerate faster than it falls: 2 m/s^2 and the spring are not enough.
    let lobe = "face = '90deg', profile = '0.04 + 0.01*cos(theta)'";
    let text = tappet(lobe).replace("drive = '10*t'", "drive = '80*t'");
    let run = run(&text, &[]);
    assert!(said(&run).contains("the joint `lobe` is one-sided"), "{}", said(&run));
}

#[test]
#[ignore = "full tier: engine"]
fn a_crossed_belt_turns_the_other_way() {
    let text = r#"
name = "belt"
run = { step = 1e-3, end_time = 1 }
[links]
ground = { points = { A = [0, 0], B = [0.5, 0] } }
a = { points = { A = [0, 0] }, inertia = 2, angle = 0, rate = 3 }
b = { points = { B = [0, 0] }, inertia = 5, angle = 0 }
[joints]
A = { revolute = ["a", "ground"] }
B = { revolute = ["b", "ground"] }
strap = { belt = ["a", "b"], radii = [0.1, 0.2], crossed = true }
[loads]
push = { torque = 4, on = "a" }
[outputs]
M = { moment = "strap" }
"#;
    let run = run(text, &[]);
    let summary = run.summary();
    // Both as one wheel: 2 + 5/4, pushed by 4.
    let acceleration = 4.0 / 3.25;
    let end = |name: &str| summary["end_state"][name].as_f64().expect("an angle");
    near("a", end("phi_a"), 3.0 + acceleration / 2.0, 1e-12);
    near("b", end("phi_b"), -(3.0 + acceleration / 2.0) / 2.0, 1e-12);
    near("moment", summary["extremes"]["M"]["max"].as_f64().expect("a moment"), 2.0 * acceleration - 4.0, 1e-11);
}

/// A natural spline of a line is the line, also beyond its ends, and a stop condition may contain it.
#[test]
#[ignore = "full tier: engine"]
fn a_natural_spline_goes_on_as_a_line() {
    let text = r#"
name = "line"
coordinates = [{ name = "x", unit = "m" }, { name = "y", unit = "m" }]
[tables]
line = { x = [0, 0.3, 1], y = [1, 1.6, 3], spline = "natural" }
[bodies]
body = { mass = 2, com = ['x', 'y'] }
[constraints]
on = { residual = 'y - line(x)' }
[loads]
weight = { gravity = [0, -9.81] }
[initial]
given = { x = 2, x_dot = 0 }
solve = { y = 5 }
[run]
step = 1e-2
until = 'line(x) <= -3'
max_time = 10
"#;
    let run = run(text, &[]);
    let summary = run.summary();
    let end = |name: &str| summary["end_state"][name].as_f64().expect("a place");
    near("x", end("x"), -2.0, 1e-10);
    // Down a slope of two: x_ddot = -2 g/5.
    let duration: f64 = 2.0 * 4.0 / (2.0 * 9.81 / 5.0);
    near("t", summary["end_time"].as_f64().expect("a time"), duration.sqrt(), 1e-10);
}

/// Entries that are formulae of a parameter move a mass as their values do, also with another value of the parameter.
#[test]
#[ignore = "full tier: engine"]
fn entries_of_tables_are_formulae_of_parameters() {
    let scene = |entries: &str, spline: &str| {
        format!(
            r#"
name = "turning"
coordinates = ["phi"]
parameters = {{ M = 3 }}
tables = {{ m = {{ x = [0, 1, 3, 4.5, 6], y = [{entries}]{spline} }} }}
bodies = {{ disc = {{ angle = 'phi', inertia = 1 }} }}
loads = {{ push = {{ torque = 'm(phi)', on = "disc" }} }}
outputs = {{ T = 'm(phi) + sin(phi)' }}
initial = {{ given = {{ phi = 0, phi_dot = 1 }} }}
run = {{ step = 0.01, end_time = 2 }}
"#
        )
    };
    for spline in ["", ", spline = \"natural\"", ", spline = \"periodic\""] {
        let numbers = [("3", "1, 3, -2, 6, 1"), ("4.5", "1.5, 4.5, -2, 9, 1.5")];
        for (size, numbers) in numbers {
            let own = run(&scene("'M/3', 'M', -2, '2*M', 'M/3'", spline), &["--set", &format!("M={size}")]);
            let other = run(&scene(numbers, spline), &["--set", &format!("M={size}")]);
            let (own, other) = (own.trajectory(), other.trajectory());
            for name in ["phi", "phi_dot", "T"] {
                near(name, own.number(own.last(), name), other.number(other.last(), name), 1e-9);
            }
        }
    }
}

/// Quantities in a table have their units, and so has its value.
#[test]
#[ignore = "full tier: engine"]
fn tables_of_quantities_have_units() {
    let text = r#"
name = "sliding"
coordinates = [{ name = "x", unit = "m" }]
parameters = { h = { value = 5, unit = "mm" }, F = { value = 2, unit = "kN" } }
[tables]
lift = { x = [0, '90 deg', '180 deg', '270 deg', '360 deg'], y = [0, 'h', '2*h', 'h', 0], spline = "periodic" }
force = { x = ['0 mm', '10 mm'], y = ['5 kN', '10 kN'] }
[bodies]
block = { mass = 1, com = ['x', '0'] }
[loads]
push = { force = ['force(x) + F', 0], on = "block" }
[outputs]
height = { value = '30 mm + lift(90 deg)', unit = "mm" }
total = { value = 'force(x) + F', unit = "kN" }
[initial]
given = { x = 0.004, x_dot = 0 }
[run]
step = 1e-5
end_time = 1e-4
"#;
    let table = run(text, &[]).trajectory();
    near("height", table.number(0, "height"), 35.0, 1e-12);
    near("total", table.number(0, "total"), 9.0, 1e-12);
    near("acceleration", table.number(0, "x_ddot"), 9000.0, 1e-9);
}
