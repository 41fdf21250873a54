//! Mechanisms of a working life in links, as short as they can be written, against closed forms.

use std::f64::consts::TAU;
use std::fs;

use crate::common::{Table, near, qrm, run};

fn path(name: &str) -> String {
    format!("{}/tests/mechanisms/{name}.toml", env!("CARGO_MANIFEST_DIR"))
}

/// The trajectory of a mechanism.
fn trajectory(name: &str) -> Table {
    let run = run(&[&path(name), "--no-figures"]);
    assert_eq!(run.status(), 0, "{name}: {}", run.stderr());
    run.trajectory()
}

#[test]
fn mechanisms_are_short() {
    for (name, most) in [("wiper", 20), ("bucket", 22), ("press", 25), ("bonnet", 20), ("geneva", 14)] {
        let count = fs::read_to_string(path(name)).expect("a scene").lines().count();
        assert!(count <= most, "{name} has {count} lines, more than {most}");
    }
}

/// The angle `atan2(r sin a, r cos a - d)` of the wheel, and the power of its inertia.
#[test]
#[ignore = "full tier: engine"]
fn a_geneva_wheel_turns_as_its_slot() {
    let table = trajectory("geneva");
    let (d, r, inertia) = (0.1, 0.1 / 2.0_f64.sqrt(), 2e-4);
    for row in (1..table.last()).step_by(25) {
        let a = -TAU / 8.0 + TAU * table.number(row, "t");
        let (s, c) = a.sin_cos();
        let angle = (r * s).atan2(r * c - d);
        let off = (table.number(row, "turned").to_radians() - angle).rem_euclid(TAU);
        near("angle", off.min(TAU - off), 0.0, 1e-12);
        let (above, below) = (r * r - r * d * c, r * r + d * d - 2.0 * r * d * c);
        let (slope, curvature) = (above / below, (r * d * s * below - above * 2.0 * r * d * s) / (below * below));
        near("speed", table.number(row, "speed"), 60.0 * slope, 1e-9);
        near("torque", table.number(row, "T"), inertia * slope * curvature * TAU * TAU, 1e-10);
    }
}

/// The place where two circles cross, to the left of the line from the first centre to the second one.
fn crossing([ax, ay]: [f64; 2], a: f64, [bx, by]: [f64; 2], b: f64) -> [f64; 2] {
    let (dx, dy) = (bx - ax, by - ay);
    let d = dx.hypot(dy);
    let along = (a * a - b * b + d * d) / (2.0 * d);
    let across = (a * a - along * along).sqrt();
    [ax + (along * dx - across * dy) / d, ay + (along * dy + across * dx) / d]
}

#[test]
#[ignore = "full tier: engine"]
fn a_wiper_sweeps_as_circles_cross() {
    let table = trajectory("wiper");
    for row in (0..=table.last()).step_by(100) {
        let crank = TAU * 0.75 * table.number(row, "t");
        let pivot = [0.3, 0.05];
        let [x, y] = crossing(pivot, 0.08, [0.05 * crank.cos(), 0.05 * crank.sin()], 0.3);
        // The rod holds the arm 80 mm below its pivot in its own frame.
        let arm = (x - pivot[0]).atan2(pivot[1] - y);
        near("arm", table.number(row, "sweep"), arm.to_degrees(), 1e-9);
    }
}

/// The rod of the wiper is closest to the first arm where crank and ground are in one line. The tie stays parallel to the
/// ground, and is closest to the second arm at the end of the sweep.
#[test]
#[ignore = "full tier: engine"]
fn a_check_reports_the_transmission_angles_of_the_motion() {
    let output = qrm(&["check", &path("wiper")]).output().expect("the command starts");
    let text = String::from_utf8(output.stdout).expect("text");
    let (rod, arm, reach): (f64, f64, f64) = (0.3, 0.08, 0.3_f64.hypot(0.05) - 0.05);
    let least = ((rod * rod + arm * arm - reach * reach) / (2.0 * rod * arm)).acos().to_degrees();
    let sweep = |crank: f64| {
        let [x, y] = crossing([0.3, 0.05], arm, [0.05 * crank.cos(), 0.05 * crank.sin()], rod);
        (x - 0.3).atan2(0.05 - y).to_degrees()
    };
    let end = (0..20_000).map(|i| sweep(TAU * f64::from(i) / 20_000.0)).fold(f64::MIN, f64::max);
    let tie = 6.0_f64.atan2(5.0).to_degrees() - end;
    for (links, angle) in [("`rod` and `arm1`", least), ("`tie` and `arm2`", tie)] {
        let line = format!("transmission angle between {links}: at least {angle:.2} deg, at t = ");
        assert!(text.contains(&line), "{line}\n{text}");
    }
    assert!(
        text.contains("transmission angle between `tie` and `arm2`: at least 0.0000 deg as `arm1` moves"),
        "{text}"
    );
}

/// The power of the cylinder, of the force at the tip and of the weights is the change of the kinetic energy.
#[test]
#[ignore = "full tier: engine"]
fn the_cylinder_of_a_bucket_does_the_work() {
    let table = trajectory("bucket");
    for row in (10..table.last()).step_by(100) {
        let slope = |column: &str| {
            (table.number(row + 1, column) - table.number(row - 1, column))
                / (table.number(row + 1, "t") - table.number(row - 1, "t"))
        };
        let (angle, rate) = (table.number(row, "phi_bucket"), table.number(row, "phi_bucket_dot"));
        let (s, c) = angle.sin_cos();
        let [x, y] = [1.2 * c + 0.3 * s, 1.2 * s - 0.3 * c];
        // The constant force at the tip has a potential.
        let tip = (-15e3 * -y + 8e3 * x) * rate;
        let power = table.number(row, "F") * 1e3 * 0.06;
        near("power", power, slope("energy"), 1e-4 * power.abs());
        assert!(tip.abs() > 100.0);
    }
}

#[test]
#[ignore = "full tier: engine"]
fn a_press_works_on_its_way_down_and_a_bonnet_opens() {
    let table = trajectory("press");
    let mut pressed = 0;
    for row in 1..table.last() {
        let (place, before) = (table.number(row, "stroke"), table.number(row - 1, "stroke"));
        let power = table.number(row, "P_work");
        if place < -446.0 && place < before - 1e-3 {
            assert!(power < 0.0, "{power} kW at {place} mm");
            pressed += 1;
        } else if place > -444.0 {
            near("power", power, 0.0, 1e-9);
        }
    }
    assert!(pressed > 50, "{pressed}");
    let bonnet = trajectory("bonnet");
    let [first, last] = [0, bonnet.last()].map(|row| bonnet.number(row, "open"));
    assert!((last - first).abs() > 5.0, "from {first} to {last} deg");
}
