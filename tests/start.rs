//! Motions from another start than the scene's, and starts that are dragged.

use std::f64::consts::PI;
use std::path::Path;

use qrm_pictures::position_error;
use qrm_scene::evaluate::parameter_values;
use qrm_scene::resolve;
use qrm_sim::analysis::inverse_kinematics;
use qrm_sim::position::{Start, assemble};

use crate::common;
use crate::common::{model, near, qrm, run};

fn scene(name: &str) -> String {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/singular");
    folder.join(name).with_extension("toml").display().to_string()
}

/// The message with which `run quick-return` refuses these starts.
fn refused(starts: &[&str]) -> String {
    let options: Vec<&str> = starts.iter().flat_map(|start| ["--start", start]).collect();
    let output = qrm(&["run", "quick-return"]).args(options).output().expect("the command starts");
    assert_eq!(output.status.code(), Some(2));
    String::from_utf8_lossy(&output.stderr).into_owned()
}

#[test]
fn a_motion_goes_on_from_the_middle_of_another() {
    // The state at t = 0.5 s by the energy integral, as in the scene's own reference values.
    let given = ["phi2=3.6021190260597796478", "phi2_dot=6.8078802569558837100"];
    let method = ["quick-return", "--no-figures", "--method", "dop853", "--tolerance", "1e-13"];
    let run = common::run(&[&method[..], &["--start", given[0], "--start", given[1]]].concat());
    let table = run.trajectory();
    for (name, expected) in [
        ("phi2", 3.602_119_026_059_78),
        ("phi4", 2.274_506_384_184_564_4),
        ("phi5", 2.484_927_832_307_542),
        ("phi2_dot", 6.807_880_256_955_884),
        ("phi4_dot", 1.184_065_142_088_816_7),
        ("phi5_dot", -1.128_541_919_454_831),
        ("N3", 602.576_704_996_570_9),
        ("N6", -960.811_495_641_164_6),
    ] {
        near(name, table.number(0, name), expected, 1e-11 * f64::abs(expected));
    }
    // The end of the whole motion, at 1.755994279022448806876974 s, is 0.5 s nearer.
    let end = run.summary()["end_time"].as_f64().expect("a number");
    near("end", end, 1.255_994_279_022_448_8, 1e-12);
}

#[test]
fn starts_that_cannot_be_are_refused() {
    assert_eq!(
        refused(&["phi4=1"]),
        "error: `phi4` is not given at the start of scene `quick-return`\n  = help: did you mean `phi2`?\n"
    );
    assert_eq!(
        refused(&["speed=1"]),
        "error: `speed` is not given at the start of scene `quick-return`\n  = help: given at the start: phi2, \
         phi2_dot\n"
    );
    assert_eq!(refused(&["phi2"]), "error: `--start phi2` has no `=`\n  = help: write `--start NAME=VALUE`\n");
    assert_eq!(refused(&["phi2=0/0"]), "error: `--start phi2` needs a number, but `0/0` gives NaN\n");
}

#[test]
fn a_dragged_point_is_as_near_as_it_can_be() {
    let model = model("quick-return");
    let (scene, _) = resolve::read("quick-return.toml", model.description.source).expect("the scene is right");
    let mechanism = model.mechanism(&|_| None);
    let parameters = parameter_values(&scene, |_| None);
    let point = |name: &str| scene.points.iter().position(|point| point.name == name).expect("a point");
    let (crank, pivot) = (point("A"), point("O2"));
    let (mut q, _) = assemble(&*mechanism, Start::new(&*mechanism)).expect("a start");
    // The end of the crank, 0.2 m long, about (0, 0.3); a hand moves it in pieces.
    for turn in 1..=40 {
        let angle = 0.1 * f64::from(turn);
        let place = [0.2 * angle.cos(), 0.3 + 0.2 * angle.sin()];
        q = inverse_kinematics(&*mechanism, &q, |q| position_error(&scene, &parameters, q, &[(crank, 1.0)], place));
        near("phi2 at the place", q[0], angle, 1e-9);
    }
    let rocker = (0.3 + 0.2 * q[0].sin()).atan2(0.2 * q[0].cos());
    near("phi4", q[1], rocker, 1e-9);
    near("phi5", q[2], PI - ((0.9 - 0.7 * rocker.sin()) / 0.6).asin(), 1e-9);
    // Beyond its circle it points to the place; the middle of the crank does too.
    for points in [&[(crank, 1.0)][..], &[(crank, 0.5), (pivot, 0.5)]] {
        let place = [0.35 * f64::cos(2.0), 0.3 + 0.35 * f64::sin(2.0)];
        let q = inverse_kinematics(&*mechanism, &q, |q| position_error(&scene, &parameters, q, points, place));
        near("phi2 beyond", q[0], 2.0, 2e-3);
    }
}

/// A slider starts a crank at its dead point, where its place determines the crank's angle only within the root of
/// rounding errors: 4e-8 rad. Given by the angle, the motion is known to ten digits.
#[test]
#[ignore = "full tier: engine"]
fn a_start_at_a_dead_point_is_uncertain() {
    let scene = scene("start-at-dead-point");
    for method in ["rk4", "dop853", "gauss"] {
        let run = run(&[&scene, "--no-figures", "--method", method]);
        assert_eq!(run.status(), 0, "{}", run.stderr());
        let summary = run.summary();
        let number = |place: &str| summary[place]["phi"].as_f64().expect("a number");
        let (error, stated) = ((number("end_state") - 0.905_295_796_036_5).abs(), number("end_state_errors"));
        assert!(error <= 3.0 * stated && stated < 1e-7, "{method}: off by {error:e}, stated {stated:e}");
        let said = run.stdout() + &run.stderr();
        assert!(said.contains("the given coordinates determine `phi` only within 2e-8 rad"), "{said}");
    }
}

/// Links of any size are assembled alike: forces of bars without gravity grow with the square of the unit of length.
#[test]
#[ignore = "full tier: engine"]
fn the_size_of_a_mechanism_does_not_matter() {
    let scene = scene("four-bar-in-cm");
    let forces = |cm: &str| -> [f64; 2] {
        let run = run(&[&scene, "--no-figures", "--set", &format!("cm={cm}")]);
        assert_eq!(run.status(), 0, "cm = {cm}: {}", run.stderr());
        let unit = cm.parse::<f64>().expect("a number").powi(2);
        ["F_B", "F_C"].map(|name| run.summary()["extremes"][name]["max"].as_f64().expect("a number") / unit)
    };
    let own = forces("0.01");
    for cm in ["1e-6", "1e-4", "0.3", "1", "10", "1e4"] {
        for (scaled, own) in forces(cm).into_iter().zip(own) {
            near(cm, scaled, own, 1e-12 * own);
        }
    }
}

/// The block starts at the end of its reach or next to it; its position and rate determine the angle of the crank badly
/// or not at all.
#[test]
#[ignore = "full tier: engine"]
fn starts_next_to_a_dead_point_have_their_errors() {
    let scene = scene("block-at-reach");
    let start = |x: &str, rate: &str| run(&[&scene, "--no-figures", "--start", x, "--start", rate]);
    let refused = |x: &str, rate: &str| {
        let run = start(x, rate);
        assert_eq!(run.status(), 2, "{}", run.stdout());
        run.stderr()
    };
    // Beyond by an ulp is a dead point too.
    for x in ["s_G=0.4", "s_G=0.40000000000000007"] {
        let run = start(x, "s_G_dot=0");
        assert_eq!(run.status(), 0, "{}", run.stderr());
        assert!(run.stdout().contains("determine `phi_crank` only within"), "{}", run.stdout());
        assert!(refused(x, "s_G_dot=0.1").contains("do not determine the rate of `phi_crank`"));
    }
    assert!(refused("s_G=0.400000000001", "s_G_dot=0").contains("constraint `R` stays 1.000e-12 m from closed"));
    // The scene's own start is at the dead point, so that the guess of the crank chooses the branch.
    let run = start("s_G=0.39", "s_G_dot=0");
    assert_eq!(run.status(), 0, "{}", run.stderr());
    near("phi_crank", run.trajectory().number(0, "phi_crank"), 0.39144433900188087, 1e-14);
}

/// A four-bar linkage with a driven crank; `crank` and `near` complete it.
fn four_bar(crank: &str, near: &str) -> common::Run {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("scene.toml");
    let text = format!(
        r#"
name = "four-bar"
[links]
ground  = {{ points = {{ A = [0, 0], D = [0.4, 0] }} }}
crank   = {{ bar = ["A", "B"], length = 0.1, mass = 1, {crank} }}
coupler = {{ bar = ["B", "C"], length = 0.35, mass = 3 }}
rocker  = {{ bar = ["D", "C"], length = 0.25, mass = 2 }}
[joints]
A = {{ revolute = ["crank", "ground"], drive = '1 + 2*t' }}
B = {{ revolute = ["crank", "coupler"] }}
C = {{ revolute = ["coupler", "rocker"], near = [{near}] }}
D = {{ revolute = ["rocker", "ground"] }}
[run]
step = 1e-2
end_time = 1
"#
    );
    std::fs::write(&path, text).expect("written");
    run(&[path.to_str().expect("a path"), "--no-figures"])
}

#[test]
#[ignore = "full tier: engine"]
fn a_rate_that_a_drive_contradicts_is_refused() {
    let refused = four_bar("rate = 3", "0.35, 0.25");
    assert_ne!(refused.status(), 0);
    assert!(refused.stderr().contains("a drive prescribes a rate of its own"), "{}", refused.stderr());
    assert_eq!(four_bar("rate = 2", "0.35, 0.25").status(), 0);
}

#[test]
#[ignore = "full tier: engine"]
fn a_rough_place_far_from_its_joint_is_reported() {
    let far = four_bar("", "350, 250");
    assert_eq!(far.status(), 0);
    assert!(far.stdout().contains("joint `C` starts 429."), "{}", far.stdout());
    let close = four_bar("", "0.3, 0.3");
    assert!(!close.stdout().contains("warning"), "{}", close.stdout());
}

/// Two of the first coordinates belong to one loop with one degree of freedom. Links whose angles are written keep
/// them, wherever they stand.
#[test]
#[ignore = "full tier: engine"]
fn given_coordinates_are_independent() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("scene.toml");
    let text = r#"
name = "two"
[links]
ground   = { points = { A = [0, 0], D = [3, 0], P = [0, 5] } }
coupler  = { bar = ["B", "C"], length = 3, mass = 1 }
rocker   = { bar = ["D", "C"], length = 2.5, mass = 1 }
crank    = { bar = ["A", "B"], length = 1, mass = 1, angle = '60 deg' }
pendulum = { bar = ["P", "Q"], length = 1, mass = 1, angle = 0 }
[joints]
A = { revolute = ["crank", "ground"] }
B = { revolute = ["crank", "coupler"] }
C = { revolute = ["coupler", "rocker"], near = [2, 2] }
D = { revolute = ["rocker", "ground"] }
P = { revolute = ["pendulum", "ground"] }
[loads]
weight = { gravity = [0, -9.81] }
[run]
step = 1e-3
end_time = 0.5
"#;
    std::fs::write(&path, text).expect("written");
    let run = run(&[path.to_str().expect("a path"), "--no-figures"]);
    assert_eq!(run.status(), 0, "{}", run.stderr());
    let table = run.trajectory();
    near("crank", table.number(0, "phi_crank"), PI / 3.0, 1e-15);
    near("pendulum", table.number(0, "phi_pendulum"), 0.0, 0.0);
    // The energy of a rod about its end: phi_dot^2 = 3 g sin(-phi).
    let [phi, rate] = ["phi_pendulum", "phi_pendulum_dot"].map(|name| table.number(table.last(), name));
    near("rate", rate * rate, -3.0 * 9.81 * phi.sin(), 1e-9);
}
