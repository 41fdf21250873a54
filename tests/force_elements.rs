//! Cylinders, gas springs and motors move and load a mechanism like the parts and laws that they stand for.

use std::fs;

use crate::common::{Table, near, run};

/// A boom that a cylinder lifts, held by a gas spring and turned by a motor; `joints` and `loads` complete it.
fn boom(links: &str, joints: &str, loads: &str, outputs: &str) -> Table {
    let text = format!(
        "name = \"boom\"\n[links]\nground = {{ points = {{ O = [0, 1], E = [0.2, 0.4], S = [0.5, 0.2] }} }}\n\
         boom = {{ points = {{ O = [0, 0], M = [0.7, -0.1], P = [2, 0] }}, mass = 80, com = [1, 0], angle = 0.1 }}\n\
         {links}\n[joints]\nO = {{ revolute = [\"boom\", \"ground\"] }}\n{joints}\n[loads]\nweight = {{ gravity = [0, \
         -9.81] }}\n{loads}\n[outputs]\nF_O = {{ joint = \"O\" }}\n{outputs}\n[run]\nstep = 1e-3\nend_time = 0.5\n"
    );
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("boom.toml");
    fs::write(&path, text).expect("written");
    let run = run(&[&path.display().to_string(), "--no-figures", "--no-error-estimate"]);
    assert_eq!(run.status(), 0, "{}", run.stderr());
    run.trajectory()
}

fn same(own: &Table, other: &Table, columns: &[[&str; 2]]) {
    assert!(own.last() > 400);
    for row in (0..=own.last()).step_by(50) {
        for [name, expected] in columns {
            let expected = other.number(row, expected);
            near(name, own.number(row, name), expected, 1e-8 * (1.0 + expected.abs()));
        }
    }
}

#[test]
#[ignore = "full tier: engine"]
fn a_cylinder_is_a_driven_slider_between_two_pins() {
    let outputs = "F = { drive = \"lift\" }\nP = { power = \"lift\" }";
    let length = "'0.6 + 0.05*t + 0.02*sin(4*t)'";
    let own = boom("", &format!("lift = {{ cylinder = [\"ground.E\", \"boom.M\"], length = {length} }}"), "", outputs);
    let other = boom(
        "barrel = { points = { E = [0, 0] } }\npiston = { points = { M = [0, 0] } }",
        &format!(
            "E = {{ revolute = [\"barrel\", \"ground\"] }}\nM = {{ revolute = [\"piston\", \"boom\"], near = [0.7, \
             0.9] }}\n\
             lift = {{ prismatic = [\"piston.M\", \"barrel.E\"], drive = {length} }}"
        ),
        "",
        outputs,
    );
    same(&own, &other, &[["phi_boom"; 2], ["F"; 2], ["P"; 2], ["F_O"; 2]]);
    assert!(own.number(0, "F") > 1000.0, "it pushes: {}", own.number(0, "F"));
}

#[test]
#[ignore = "full tier: engine"]
fn a_gas_spring_pushes_more_the_shorter_it_is() {
    let gas = "gas_spring = '2 kN', ratio = 1.3, extended = '1.2 m', stroke = '60 cm'";
    let own = boom("", "", &format!("gas = {{ between = [\"S\", \"M\"], {gas} }}"), "");
    let law = "2000*(1 + 0.3*(1.2 - s)/0.6)";
    let other = boom("", "", &format!("gas = {{ between = [\"S\", \"M\"], force = '{law}' }}"), "");
    same(&own, &other, &[["phi_boom"; 2], ["phi_boom_dot"; 2], ["F_O"; 2]]);
    let change = own.number(own.last(), "energy") - own.number(0, "energy");
    near("its energy is potential", change, 0.0, 1e-6);
}

#[test]
#[ignore = "full tier: engine"]
fn a_motor_is_a_line_from_its_stall_torque_to_its_speed() {
    let own = boom("", "", "motor = { along = 'phi_boom', motor = '1200 N m', no_load = '60 rpm' }", "");
    let law = "1200*(1 - phi_boom_dot/(2*pi))";
    let other = boom("", "", &format!("motor = {{ torque = '{law}', on = \"boom\" }}"), "");
    same(&own, &other, &[["phi_boom"; 2], ["phi_boom_dot"; 2], ["F_O"; 2]]);
}

#[test]
#[ignore = "full tier: engine"]
fn a_force_in_the_frame_of_a_link_turns_with_it() {
    let tip = "tip = { points = { P = [0, 0], Q = [0.3, 0] }, mass = 5, com = \"Q\", inertia = 1 }";
    let weld = "P = { weld = [\"tip\", \"boom\"], rotation = '30 deg' }";
    let own = boom(tip, weld, "push = { force = [40, '3000*cos(3*t)'], at = \"Q\", frame = \"tip\" }", "");
    let angle = "(phi_boom + pi/6)";
    let turned = format!(
        "push = {{ force = ['40*cos({angle}) - 3000*cos(3*t)*sin({angle})', '40*sin({angle}) + \
         3000*cos(3*t)*cos({angle})'], at = \"Q\" }}"
    );
    let other = boom(tip, weld, &turned, "");
    same(&own, &other, &[["phi_boom"; 2], ["phi_boom_dot"; 2], ["F_O"; 2]]);
    let ground = boom(tip, weld, "push = { force = [40, '3000*cos(3*t)'], at = \"Q\", frame = \"ground\" }", "");
    let fixed = boom(tip, weld, "push = { force = [40, '3000*cos(3*t)'], at = \"Q\" }", "");
    same(&ground, &fixed, &[["phi_boom"; 2], ["F_O"; 2]]);
    let off = own.number(own.last(), "phi_boom") - fixed.number(fixed.last(), "phi_boom");
    assert!(off.abs() > 1e-2, "{off}");
}
