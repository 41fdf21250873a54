//! Scenes in links and joints: their motion, and the ordinary scenes that they become.

use std::f64::consts::PI;
use std::fs;

use nalgebra::Vector2;
use serde_json::Value;

use crate::common;
use crate::common::{near, qrm};

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

/// Rows of a trajectory, by the names of their columns.
struct Rows {
    header: Vec<String>,
    rows: Vec<Vec<f64>>,
}

impl Rows {
    fn new(scene: &str) -> Self {
        let run = common::run(&[&path(scene), "--no-figures"]);
        assert_eq!(run.status(), 0, "{}", run.stderr());
        Self::of_table(&fs::read_to_string(run.path("trajectory.csv")).expect("the trajectory"))
    }

    fn of_table(text: &str) -> Self {
        let mut lines = text.lines().map(|line| line.split(','));
        let header = lines.next().expect("a header").map(str::to_owned).collect();
        let rows = lines.map(|line| line.map(|number| number.parse().expect("a number")).collect()).collect();
        Self { header, rows }
    }

    /// Every so many rows, each as a function from names to numbers.
    fn every(&self, many: usize) -> impl Iterator<Item = impl Fn(&str) -> f64> {
        let value = |row: &'_ [f64], name: &str| {
            row[self.header.iter().position(|own| own == name).unwrap_or_else(|| panic!("no column `{name}`"))]
        };
        self.rows.iter().step_by(many).map(move |row| move |name: &str| value(row, name))
    }
}

/// A vector that turns with a link, with its two rates.
fn turning(value: &impl Fn(&str) -> f64, angle: &str, offset: f64, length: f64) -> [Vector2<f64>; 3] {
    let [q, qd, qdd] = ["", "_dot", "_ddot"].map(|suffix| value(&format!("{angle}{suffix}")));
    let (sin, cos) = (q + offset).sin_cos();
    let (along, across) = (Vector2::new(cos, sin), Vector2::new(-sin, cos));
    [length * along, length * qd * across, length * (qdd * across - qd * qd * along)]
}

fn plus(a: [Vector2<f64>; 3], b: [Vector2<f64>; 3]) -> [Vector2<f64>; 3] {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

/// The linkages that `qrm new` begins with run as they are written.
#[test]
#[ignore = "full tier: engine"]
fn new_linkages_move() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for from in ["four-bar", "slider-crank", "cylinder", "quick-return", "cam", "gears"] {
        let file = folder.path().join(format!("my-{from}.toml"));
        let name = format!("my-{from}");
        let output = qrm(&["new", &name, "--from", from, "--out"]).arg(&file).output().expect("the command starts");
        assert!(output.status.success(), "{from}");
        let run = common::run(&[&file.display().to_string(), "--no-figures"]);
        assert_eq!((run.status(), run.stderr().as_str()), (0, ""), "{from}");
        let lines = fs::read_to_string(&file).expect("the scene").lines().count();
        assert!((10..=35).contains(&lines), "{from} has {lines} lines");
    }
}

#[test]
#[ignore = "full tier: engine"]
fn the_quick_return_moves_as_the_one_in_formulae() {
    let (own, formulae) = (end(&path("quick-return")), end("quick-return"));
    for name in ["phi2", "phi4", "phi5", "phi2_dot", "phi4_dot", "phi5_dot"] {
        near(name, own(name), formulae(name), 1e-12 * formulae(name).abs().max(1.0));
    }
}

#[test]
#[ignore = "full tier: engine"]
fn a_link_slides_along_a_line() {
    let end = end(&path("incline"));
    // Down a slope of 30 degrees: s = s0 + v t + g sin(30) t^2/2.
    near("s", end("s_slope"), 0.2 + 0.3 + 9.81 / 4.0, 1e-12);
}

#[test]
#[ignore = "full tier: engine"]
fn a_pin_moves_a_slotted_link() {
    let run = common::run(&[&path("yoke"), "--no-figures"]);
    assert_eq!(run.status(), 0, "{}", run.stderr());
    let summary = run.summary();
    let angle: f64 = 0.5 + 4.0 + 1.0;
    near("crank", summary["end_state"]["phi_crank"].as_f64().expect("an angle"), angle, 1e-12);
    near("yoke", summary["end_state"]["s_guide"].as_f64().expect("a length"), 0.2 * angle.cos(), 1e-12);
}

#[test]
#[ignore = "full tier: engine"]
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
#[ignore = "full tier: engine"]
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
#[ignore = "full tier: engine"]
fn a_planet_turns_with_its_carrier() {
    let end = end(&path("planet"));
    // The planet turns three times as fast as the arm about a sun of twice its radius.
    let inertia = 2.0 * 0.09 / 3.0 + 1.5 * 0.09 + 9.0 * 0.01;
    near("arm", end("phi_arm"), PI / 9.0 + 4.0 / inertia / 2.0, 1e-12);
    near("planet", end("phi_planet"), 3.0 * end("phi_arm"), 1e-11);
}

#[test]
#[ignore = "full tier: engine"]
fn a_disc_rolls_down_a_slope() {
    let run = common::run(&[&path("roll"), "--no-figures"]);
    assert_eq!(run.status(), 0, "{}", run.stderr());
    let summary = run.summary();
    let value = |table: &str, name: &str| summary[table][name].as_f64().expect("a number");
    // A third of the weight along the slope turns the disc.
    let acceleration = 9.81 / 2.0 * 2.0 / 3.0;
    near("place", value("end_state", "s_height"), 0.5 + acceleration / 2.0, 1e-11);
    near("angle", value("end_state", "phi_disc"), -(0.5 + acceleration / 2.0) / 0.2, 1e-10);
    // Up the slope.
    let friction = 3.0 * 9.81 / 2.0 / 3.0;
    let extremes = &summary["extremes"];
    near("friction", extremes["F"]["max"].as_f64().expect("a force"), friction, 1e-10);
    near("friction, x", extremes["F_x"]["max"].as_f64().expect("a force"), -friction * 0.75_f64.sqrt(), 1e-10);
}

#[test]
#[ignore = "full tier: engine"]
fn the_foot_of_a_leg_is_where_circles_meet() {
    let rows = Rows::new("jansen");
    // The point at these distances from two others, on the left of the way from the first to the second.
    let meeting = |a: Vector2<f64>, from_a: f64, b: Vector2<f64>, from_b: f64| {
        let way = b - a;
        let along = (from_a.powi(2) - from_b.powi(2) + way.norm_squared()) / (2.0 * way.norm());
        let across = (from_a.powi(2) - along.powi(2)).sqrt();
        let unit = way.normalize();
        a + along * unit + across * Vector2::new(-unit.y, unit.x)
    };
    let z = Vector2::new(-0.38, -0.078);
    for value in rows.every(100) {
        let angle = 3.0 * value("t");
        let m = 0.15 * Vector2::new(angle.cos(), angle.sin());
        let p = meeting(z, 0.415, m, 0.5);
        let r = meeting(z, 0.401, p, 0.558);
        let q = meeting(m, 0.619, z, 0.393);
        let s = meeting(q, 0.367, r, 0.394);
        let t = meeting(q, 0.49, s, 0.657);
        near("x", value("x"), t.x, 1e-11);
        near("y", value("y"), t.y, 1e-11);
    }
}

#[test]
#[ignore = "full tier: engine"]
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
#[ignore = "full tier: engine"]
fn the_scene_that_it_becomes_moves_the_same() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let linkages = format!("{}/scenes/linkages", env!("CARGO_MANIFEST_DIR"));
    let folders = [path("").replace("/.toml", ""), linkages];
    let files = folders.iter().flat_map(|folder| fs::read_dir(folder).expect("the scenes"));
    let files = files.map(|entry| entry.expect("an entry").path());
    for own in files.filter(|file| file.extension().is_some_and(|extension| extension == "toml")) {
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

/// The forces in the joints of the quick-return by hand, from the ram to the crank, at the state of a row.
#[test]
#[ignore = "full tier: engine"]
fn forces_in_joints_are_those_of_free_bodies() {
    let (all, mut rows) = (Rows::new("joint-forces"), 0);
    for value in all.every(37) {
        let force = |name: &str| Vector2::new(value(&format!("{name}_x")), value(&format!("{name}_y")));
        let turning = |angle: &str, length: f64| turning(&value, angle, 0.0, length);
        let o2 = Vector2::new(0.0, 0.3);
        let a = plus([o2, Vector2::zeros(), Vector2::zeros()], turning("phi2", 0.2));
        let (b, g4) = (turning("phi4", 0.7), turning("phi4", 0.4));
        let (c, g5) = (plus(b, turning("phi5", 0.6)), plus(b, turning("phi5", 0.3)));
        let weight = |mass: f64| Vector2::new(0.0, -9.81 * mass);
        let stretch = c[0] - a[0];
        let along = stretch.normalize();
        let pull = -300.0 * (stretch.norm() - 0.4) - 5.0 * (c[1] - a[1]).dot(&along);
        let spring = pull * along;
        let cutting = Vector2::new(1000.0, 0.0);
        // The ram along its guide, the rod about B, the rod as a whole, the ram across its guide.
        let x = cutting.x - 2.0 * c[2].x;
        let arm = c[0] - b[0];
        let spin = 6.0 * value("phi5_ddot") + 4.0 * (g5[0] - b[0]).perp(&g5[2])
            - (g5[0] - b[0]).perp(&weight(4.0))
            - arm.perp(&spring);
        let f_c = Vector2::new(x, (spin + arm.y * x) / arm.x);
        let f_b = f_c + spring + weight(4.0) - 4.0 * g5[2];
        let f_guide = f_c - weight(2.0) - cutting + 2.0 * c[2];
        // The rocker about O4, the rocker as a whole.
        let normal = (b[0].perp(&f_b) + g4[0].perp(&weight(6.0))
            - 20.0 * value("phi4_dot")
            - 10.0 * value("phi4_ddot")
            - 6.0 * g4[0].perp(&g4[2]))
            / a[0].norm();
        let f_slot = normal * Vector2::new(-value("phi4").sin(), value("phi4").cos());
        let f_o4 = 6.0 * g4[2] - f_b + f_slot - weight(6.0);
        let f_a = f_slot + weight(0.5) - 0.5 * a[2];
        let f_o2 = spring - f_a;
        let size = 1e-9 * f_o2.norm().max(1000.0);
        for (name, expected) in [
            ("F_C", f_c),
            ("F_B", f_b),
            ("F_guide", f_guide),
            ("F_slot", f_slot),
            ("F_O4", f_o4),
            ("F_A", f_a),
            ("F_O2", f_o2),
        ] {
            let off = (force(name) - expected).norm();
            assert!(off < size, "{name}: {} instead of {expected}", force(name));
            near(name, value(name), expected.norm(), size);
        }
        near("crank", (a[0] - o2).perp(&(f_a - spring)), 100.0 * value("phi2_ddot"), size);
        rows += 1;
    }
    assert!(rows > 40, "{rows}");
}

/// The force in a slider, whether what pulls its block is written along its coordinate or at its point.
#[test]
#[ignore = "full tier: engine"]
fn a_load_along_the_coordinate_of_a_slider_acts_on_its_block() {
    let scene = "name = 'block'
run = { step = 1e-2, end_time = 0.5 }
[links]
ground = { points = { A = [0, 0] } }
one = { points = { P = [0, 0] }, mass = 3, com = 'P' }
[joints]
A = { prismatic = ['one.P', 'ground.A'], direction = '30deg', start = 0.5, rate = 0.2 }
[loads]
weight = { gravity = [0, -9.81] }
pull = LOAD
[outputs]
F_A = { joint = 'A' }
F_G = { joint = 'A', on = 'ground' }
";
    let normal = 3.0 * 9.81 * (PI / 6.0).cos();
    for load in ["{ along = 's_A', force = 20 }", "{ force = ['20*cos(30deg)', '20*sin(30deg)'], at = 'P' }"] {
        let largest = |name: &str| largest_in(&scene.replace("LOAD", load), name);
        near(load, largest("F_A"), normal, 1e-9);
        near(load, largest("F_A_y"), normal * (PI / 6.0).cos(), 1e-9);
        near(load, largest("F_G"), normal, 1e-9);
        near(load, largest("F_G_x"), normal * (PI / 6.0).sin(), 1e-9);
    }
}

/// The force in the pin of a piston: the load belongs to the link that is named.
#[test]
#[ignore = "full tier: engine"]
fn a_load_on_a_shared_pin_belongs_to_the_named_link() {
    let scene = "name = 'engine'
run = { step = 1e-3, end_time = 1e-3 }
[links]
ground = { points = { O = [0, 0] } }
crank = { bar = ['O', 'A'], length = 0.05 }
rod = { bar = ['A', 'B'], length = 0.2 }
piston = { points = { B = [0, 0] }, mass = 1e-9, com = 'B' }
[joints]
O = { revolute = ['crank', 'ground'], drive = '1 + 0.1*t' }
A = { revolute = ['crank', 'rod'] }
B = { revolute = ['rod', 'piston'], near = [0.2, 0] }
guide = { prismatic = ['piston.B', 'ground.O'] }
[loads]
gas = { force = [-1000, 0], LINK }
[outputs]
F_B = { joint = 'B' }
";
    // At the end, where the rod is steepest.
    let sin = 0.05 / 0.2 * 1.0001_f64.sin();
    let along_rod = 1000.0 / (1.0 - sin * sin).sqrt();
    let across = 1000.0 * sin / (1.0 - sin * sin).sqrt();
    for (link, force) in [
        ("at = 'piston.B'", along_rod),
        ("at = 'B', on = 'piston'", along_rod),
        ("at = 'rod.B'", across),
        ("at = 'B', on = 'rod'", across),
    ] {
        near(link, largest_in(&scene.replace("LINK", link), "F_B"), force, 1e-3);
    }
}

/// A ladder that leans against a wall leaves it where its top has come down by a third, whatever the order of joints.
#[test]
#[ignore = "full tier: engine"]
fn a_ladder_leaves_the_wall() {
    let wall = "wall = { pin_in_slot = ['ladder.T', 'ground.W'], direction = '90deg', one_sided = '<= 0' }";
    let floor = "floor = { pin_in_slot = ['ladder.B', 'ground.F'], one_sided = '>= 0', start = 2 }";
    for joints in [[wall, floor], [floor, wall]] {
        let scene = format!(
            "name = 'ladder'
run = {{ step = 1e-3, end_time = 0.9 }}
[links]
ground = {{ points = {{ W = [0, 0], F = [0, 0] }} }}
ladder = {{ bar = ['B', 'T'], length = 4, mass = 10, angle = '120deg', rate = 0 }}
[joints]
{}
{}
[loads]
weight = {{ gravity = [0, -9.81] }}
[outputs]
N = {{ joint = 'wall' }}
",
            joints[0], joints[1]
        );
        let run = run_of(&scene, &["--until", "sin(phi_ladder) <= 2/3*sin(pi/3)"]);
        let least = run.summary()["extremes"]["N"]["min"].as_f64().expect("a force");
        assert!(least.abs() < 1e-7, "{least}");
        near(
            "height",
            run.summary()["end_state"]["phi_ladder"].as_f64().expect("an angle").sin(),
            3.0_f64.sqrt() / 3.0,
            1e-12,
        );
    }
}

/// The largest value of an output in a run of a scene.
fn largest_in(scene: &str, output: &str) -> f64 {
    run_of(scene, &[]).summary()["extremes"][output]["max"].as_f64().expect("a force")
}

/// A run of a scene.
fn run_of(scene: &str, options: &[&str]) -> common::Run {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("scene.toml");
    fs::write(&file, scene).expect("written");
    let run = common::run(&[&[&*file.display().to_string(), "--no-figures"], options].concat());
    assert_eq!(run.status(), 0, "{}", run.stderr());
    run
}

/// The moments in joints, and what acts on the ground, by hand.
#[test]
#[ignore = "full tier: engine"]
fn teeth_push_gears_against_their_pins() {
    // The sun with 24 teeth is 42 mm from the planet with 18: its pin bears its weight and the force of the teeth.
    let folder = tempfile::tempdir().expect("a folder");
    let scene = fs::read_to_string("scenes/linkages/planetary.toml").expect("the scene");
    let file = folder.path().join("planetary.toml");
    let more = "M = { moment = \"inner\", on = \"sun\" }\nT = { drive = \"S\" }\n";
    fs::write(&file, scene + more).expect("written");
    let run = common::run(&[file.to_str().expect("text"), "--no-figures"]);
    assert_eq!(run.status(), 0, "{}", run.stderr());
    let rows = Rows::of_table(&fs::read_to_string(run.path("trajectory.csv")).expect("the trajectory"));
    for value in rows.every(100) {
        let teeth = value("F_S_x").hypot(value("F_S_y") - 0.4 * 9.81);
        near("force of the teeth", teeth, value("M").abs() / (0.042 * 24.0 / 42.0), 1e-9 * teeth);
        // What accelerates the sun is the rest.
        near("torque of the drive", value("T") + value("M"), 1.2e-4 * 40.0, 1e-12);
    }
}

#[test]
#[ignore = "full tier: engine"]
fn moments_in_joints_are_those_of_free_bodies() {
    let (all, mut rows) = (Rows::new("moments"), 0);
    for value in all.every(50) {
        rows += 1;
        let force = |name: &str| Vector2::new(value(&format!("{name}_x")), value(&format!("{name}_y")));
        let weight = |mass: f64| Vector2::new(0.0, -9.81 * mass);
        let crank = |length: f64| turning(&value, "phi_crank", 0.0, length);
        let tip = |length: f64| plus(crank(0.1), turning(&value, "phi_crank", PI / 3.0, length));
        let (a, d) = (crank(0.1), tip(0.08));
        // The change of the angular momentum of a bar about a point, less the moment of its weight.
        let spin = |mass: f64, com: [Vector2<f64>; 3], about: Vector2<f64>| {
            (com[0] - about).perp(&(mass * com[2] - weight(mass)))
        };
        let [alpha, rate] = [value("phi_crank_ddot"), value("phi_crank_dot")];
        let stretch = d[0] - Vector2::new(0.0, 0.05);
        let along = stretch.normalize();
        let tie = (-50.0 * (stretch.norm() - 0.1) - 2.0 * d[1].dot(&along)) * along;
        let of_tip = 0.5 * 0.08 * 0.08 / 12.0 * alpha + spin(0.5, tip(0.04), a[0]) - (d[0] - a[0]).perp(&tie);
        near("weld", value("M_weld"), of_tip, 1e-12);
        near("weld, the other way", value("M_weld_on_crank"), -of_tip, 1e-12);
        let rod = |length: f64| plus(a, turning(&value, "phi_rod", 0.0, length));
        let (c, ram) = (rod(0.4), Vector2::new(0.1, 0.03));
        let push = Vector2::new(-40.0, 5.0);
        let of_ram = ram.perp(&(3.0 * c[2] - weight(3.0) - push));
        near("guide", value("M_guide"), of_ram, 1e-10);
        let q = turning(&value, "phi_wheel", 0.0, 0.02);
        let of_wheel = 0.05 * value("phi_wheel_ddot") + spin(4.0, q, Vector2::zeros()) + 3.0;
        near("wheel", value("M_wheel"), of_wheel, 1e-11);
        near("crank", value("M_crank"), 2.0 * of_wheel, 1e-11);
        let of_crank = 1.0 * 0.01 / 12.0 * alpha + spin(1.0, crank(0.05), Vector2::zeros()) - a[0].perp(&force("F_A"))
            + 0.5 * 0.08 * 0.08 / 12.0 * alpha
            + spin(0.5, tip(0.04), Vector2::zeros())
            - d[0].perp(&tie)
            - value("M_crank")
            + 0.3 * rate;
        near("drive", value("T"), of_crank, 1e-10);
        near("its power", value("P_T"), value("T") * rate, 1e-10);
        // Springs act on the ground too; gears by the pins alone.
        let on_ground = -force("F_O") - force("F_P") - force("F_guide") - tie;
        near("shaking, x", value("S_x"), on_ground.x, 1e-10);
        near("shaking, y", value("S_y"), on_ground.y, 1e-10);
        let about = -Vector2::new(-0.3, 0.0).perp(&force("F_P"))
            - c[0].perp(&force("F_guide"))
            - value("M_guide")
            - Vector2::new(0.0, 0.05).perp(&tie)
            - value("T")
            + 0.3 * rate
            + 3.0;
        near("shaking moment", value("S_O"), about, 1e-10);
    }
    assert!(rows > 20, "{rows}");
}

/// A reaction of a guide bears the weight that it holds, as the force in the joint does.
#[test]
#[ignore = "full tier: engine"]
fn the_reaction_of_a_guide_bears_the_weight() {
    let largest = |output: &str, name: &str| {
        let text = fs::read_to_string(path("quick-return")).expect("a scene");
        let text =
            text.replace("[loads]", "[loads]\nweight = { gravity = [0, -9.81] }") + "[outputs]\n" + output + "\n";
        largest_in(&text, name)
    };
    let reaction = largest("N = { reaction = \"guide\", at = \"C\", along = [0, 1] }", "N");
    let force = largest("F = { joint = \"guide\" }", "F_y");
    near("reaction", reaction, force, 1e-9 * force.abs());
}

fn check(arguments: &[&str]) -> String {
    let output = qrm(&["check"]).args(arguments).output().expect("the command starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).expect("text")
}

#[test]
#[ignore = "full tier: engine"]
fn mobility_is_known_by_count_and_by_rank() {
    let text = check(&[&path("four-bar")]);
    assert!(text.contains("1 degree of freedom: 3 coordinates, 2 constraints of rank 2"), "{text}");
    assert!(text.contains("crank-rocker: `crank` turns fully, `rocker` rocks"), "{text}");
    // Crank and ground overlap: the diagonal is 0.4 m - 0.1 m.
    let angle: f64 = ((0.35_f64.powi(2) + 0.25_f64.powi(2) - 0.3_f64.powi(2)) / (2.0 * 0.35 * 0.25)).acos();
    assert!(text.contains(&format!("at least {:.4} deg as `crank` moves", angle.to_degrees())), "{text}");
    let text = check(&[&path("parallel")]);
    assert!(text.contains("1 degree of freedom: 4 coordinates, 4 constraints of rank 3"), "{text}");
    assert!(text.contains("by count there would be 0: 1 constraint repeats others"), "{text}");
    assert!(text.contains("change point: "), "{text}");
}

#[test]
#[ignore = "full tier: engine"]
fn branches_are_found_by_pairs_of_links() {
    // The other branch of a four-bar is the image in the line from the far end of the crank to that of the ground.
    let text = check(&[&path("four-bar"), "--branches"]);
    assert!(text.starts_with("my-four-bar: 2 branches with phi_crank = 45.0000 deg"), "{text}");
    let row = |number: &str| -> Vec<f64> {
        let line = text.lines().find(|line| line.trim_start().starts_with(number)).expect("a row");
        line.split_whitespace().skip(1).step_by(2).take(2).map(|word| word.parse().expect("an angle")).collect()
    };
    let b = Vector2::new(0.1, 0.1) * (0.25 * PI).cos();
    let diagonal = Vector2::new(0.4, 0.0) - b;
    let axis = 2.0 * diagonal.y.atan2(diagonal.x).to_degrees();
    for (own, other) in row("1").iter().zip(row("2")) {
        near("image", (own + other - axis).rem_euclid(360.0).min((axis - own - other).rem_euclid(360.0)), 0.0, 2e-4);
    }
    // Three dyads have two positions each.
    assert!(check(&[&path("jansen"), "--branches"]).starts_with("jansen: 8 branches\n"));
}

#[test]
fn scenes_are_short() {
    for (name, most) in [("four-bar", 12), ("quick-return", 20), ("jansen", 30)] {
        let text = fs::read_to_string(path(name)).expect("a scene");
        assert!(text.lines().count() <= most, "{name}: {} lines", text.lines().count());
    }
}
