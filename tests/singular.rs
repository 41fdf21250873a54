//! Forces at singular positions, where the constraint Jacobian loses rank, against closed forms and 50 digits.

use std::f64::consts::PI;
use std::path::Path;

use serde_json::Value;

use crate::common::{Run, Table, near, qrm, run};

const METHODS: [&str; 4] = ["rk4", "dop853", "dopri5", "gauss"];
const STEPS: [&str; 6] = ["0.00021", "0.001", "0.00213", "0.0047", "0.0098", "0.0137"];

fn scene(name: &str) -> String {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/singular").join(name).with_extension("toml").display().to_string()
}

fn completed(name: &str, arguments: &[&str]) -> Run {
    let run = run(&[&[scene(name).as_str(), "--no-figures"], arguments].concat());
    assert_eq!(run.status(), 0, "{name} {arguments:?}: {}", run.stderr());
    run
}

/// Compares the extremes of a column with exact ones, and their stated errors with a billionth of them.
fn compare(run: &Run, column: &str, exact: [f64; 2], what: &str) {
    for (stated, exact) in within_errors(run, column, exact, what).into_iter().zip(exact) {
        assert!(stated <= 1e-9 * exact.abs(), "{what}: {exact} with an error of {stated:e}");
    }
}

/// Compares the extremes of a column with exact ones, within three stated errors and two units in the last place; the
/// stated errors.
fn within_errors(run: &Run, column: &str, exact: [f64; 2], what: &str) -> [f64; 2] {
    let found: &Value = &run.summary()["extremes"][column];
    [("min", exact[0]), ("max", exact[1])].map(|(end, exact)| {
        let value = found[end].as_f64().expect("a number");
        let stated = found[format!("{end}_error")].as_f64().expect("an error");
        let error = (value - exact).abs();
        assert!(
            error <= 3.0 * stated + 2.0 * f64::EPSILON * exact.abs(),
            "{what}: {value} is off by {error:e} of {stated:e}"
        );
        stated
    })
}

#[test]
#[ignore = "full tier: engine"]
fn forces_through_dead_points_are_those_of_the_closed_form() {
    // J a'' = 0.1 F sin(a), a = w t + 1 + sin(w t + 1)/5, so F = -J w^2/(0.1 (5 + cos)) of a = n pi.
    let [inertia, rate] = [0.02, 2.0 * PI];
    let force = |t: f64| {
        let phase = rate * t + 1.0;
        let angle = phase + phase.sin() / 5.0;
        // Both sines vanish at the dead points; at a distance from them the quotient has all digits.
        10.0 * inertia * rate * rate * phase.sin() / 5.0 / angle.sin()
    };
    for step in STEPS {
        for method in METHODS {
            let run = completed("crank-by-law", &["--step", step, "--method", method]);
            let limits = [0.6, 0.4].map(|divisor| inertia * rate * rate / divisor);
            let what = format!("step {step} by {method}");
            compare(&run, "F", limits, &what);
            let table = run.trajectory();
            let stated = run.summary()["estimated_errors"]["F"].as_f64().expect("an error");
            for row in 0..table.rows.len() {
                let t = table.number(row, "t");
                let distance = (rate * t + 1.0).sin().abs();
                let error = (table.number(row, "F") - force(t)).abs();
                let rounding = 1e-15 / distance.max(1e-15);
                assert!(error <= 3.0 * stated + rounding, "{what}, t = {t}: off by {error:e} of {stated:e}");
            }
        }
    }
}

/// At a distance `d` from a dead point the rounding of the scene's decimal numbers is 1e-17/d^4 of the force. The force
/// at the dead point is known to nine digits, and its error is stated. Exact: the change of the kinetic energy over the
/// rate of the slider, with 50 digits.
#[test]
#[ignore = "full tier: engine"]
fn rounded_numbers_of_a_scene_limit_the_force_at_a_dead_point() {
    const EXACT: f64 = -96.376_415_327_987_95;
    for step in STEPS {
        for method in METHODS {
            let run = completed("slider-by-cosines", &["--step", step, "--method", method]);
            let found = &run.summary()["extremes"]["F"];
            let [value, stated] = ["min", "min_error"].map(|key| found[key].as_f64().expect("a number"));
            let error = (value - EXACT).abs();
            assert!(error <= 3.0 * stated, "{method}, step {step}: {value} is off by {error:e} of {stated:e}");
            assert!(stated <= 1e-8 * EXACT.abs(), "{method}, step {step}: {stated:e}");
        }
    }
}

/// Extremes of the driving force with sliders of 0.5, 1 and 2 kg: the change of the kinetic energy over the rate of the
/// slider, by differences with 50 digits.
const DEAD_POINTS: [(&str, [f64; 2]); 3] = [
    ("m=0.5", [-4.400_198_628_819_006, 3.783_348_353_750_921]),
    ("m=1", [-6.374_119_509_036_877, 5.757_269_233_968_793]),
    ("m=2", [-10.321_961_269_472_62, 9.705_110_994_404_536]),
];

/// Crank and rod are equal, and fold at a quarter turn: the force of the guide is the limit of 250 N cos/cos there. The
/// accelerations of both links are zero.
#[test]
#[ignore = "full tier: engine"]
fn equal_links_pass_the_position_in_which_they_fold() {
    for step in STEPS {
        for method in METHODS {
            let run = completed("equal-links", &["--step", step, "--method", method]);
            for (column, most) in [("F_A_y", 225.0), ("N_y", 250.0), ("T", 250.0), ("F_A_x", 275.0)] {
                compare(&run, column, [-most, most], &format!("{column}, step {step} by {method}"));
            }
        }
    }
}

/// A column with its smallest and its largest value.
type Exact = (&'static str, [f64; 2]);

/// Newton and Euler at 60 digits, with the angle of the crank in closed form.
const LAWS: [(&str, [Exact; 3]); 2] = [
    (
        "slider-by-law",
        [
            ("F", [-416.133_127_131_523_36, 38.244_449_155_955_368]),
            ("F_O_x", [-356.433_861_623_091_6, 244.731_226_379_676_58]),
            ("F_O", [150.508_777_123_778_46, 356.433_861_623_091_6]),
        ],
    ),
    (
        "slider-by-another-law",
        [
            ("F", [-766.333_911_236_186_6, 559.293_770_971_037_7]),
            ("F_O_x", [-410.370_059_784_828_6, 44.538_365_558_141_19]),
            ("F_O", [3.079_452_687_130_320_3, 410.370_059_784_828_6]),
        ],
    ),
];

#[test]
#[ignore = "full tier: engine"]
fn sizes_of_joint_forces_at_dead_points_are_limits_too() {
    let settings: [&[&str]; 5] = [
        &["--step", "1e-3"],
        &["--step", "0.01685"],
        &["--method", "dop853", "--tolerance", "1e-9", "--step", "0.013"],
        &["--method", "gauss", "--tolerance", "1e-10"],
        &["--method", "dopri5", "--tolerance", "1e-7"],
    ];
    for (name, exact) in LAWS {
        for settings in settings {
            let run = run(&[&[scene(name).as_str(), "--no-figures"], settings].concat());
            if run.status() != 0 {
                // The longest steps are refused.
                assert!(settings.contains(&"0.01685"), "{name} {settings:?}: {}", run.stderr());
                continue;
            }
            for (column, exact) in exact {
                let what = format!("{column} of {name} {settings:?}");
                let stated = within_errors(&run, column, exact, &what);
                let largest = exact[0].abs().max(exact[1].abs());
                assert!(stated.iter().all(|stated| *stated <= 1e-9 * largest), "{what}: errors of {stated:?}");
            }
        }
    }
}

#[test]
#[ignore = "full tier: engine"]
fn a_slider_drives_a_crank_through_its_dead_points() {
    for (set, exact) in DEAD_POINTS {
        for step in STEPS {
            for method in METHODS {
                let run = completed("dead-points", &["--set", set, "--step", step, "--method", method]);
                compare(&run, "F", exact, &format!("{set}, step {step} by {method}"));
            }
        }
    }
}

#[test]
#[ignore = "full tier: engine"]
fn sweeps_find_the_same_forces() {
    for method in ["dop853", "rk4"] {
        let folder = tempfile::tempdir().expect("a folder");
        let out = folder.path().join("sweep.csv");
        let mut command = qrm(&["sweep", &scene("dead-points"), "--vary", "m=0.5,1,2", "--method", method, "--out"]);
        let output = command.arg(&out).output().expect("a command");
        let said = String::from_utf8_lossy(&output.stdout).into_owned();
        assert!(output.status.success() && said.contains("warning: in 3 designs, first in design 0: "), "{said}");
        let table = Table::read(&out);
        for (row, (set, exact)) in DEAD_POINTS.into_iter().enumerate() {
            for (column, exact) in ["F_min", "F_max"].into_iter().zip(exact) {
                let error = (table.number(row, column) - exact).abs();
                assert!(error <= 1e-13 * exact.abs(), "{set} by {method}: `{column}` is off by {error:e}");
            }
        }
    }
}

#[test]
#[ignore = "full tier: engine"]
fn forces_of_links_without_mass_are_zero() {
    let text = std::fs::read_to_string(scene("dead-points")).expect("a scene");
    let text = text.replace(", mass = 1", "").replace(", mass = 'm', com = \"B\"", "");
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("massless.toml");
    std::fs::write(&file, text).expect("written");
    for step in STEPS {
        let run = run(&[&file.display().to_string(), "--step", step, "--no-figures"]);
        let largest = run.summary()["extremes"]["F_O"]["max"].as_f64().expect("bounded");
        assert!(largest < 1e-11, "step {step}: {largest}");
    }
}

/// Dry friction at the slider jumps at the dead points of the crank. The search for extremes ends, and states the jump
/// as their error.
#[test]
#[ignore = "full tier: engine"]
fn friction_that_jumps_at_dead_points_does_not_hold_the_search_for_extremes() {
    let text = std::fs::read_to_string(scene("dead-points")).expect("a scene");
    let friction = "[loads]\nfriction = { force = ['-3*sign(B.x_dot)', 0], at = \"slider.B\" }\n[outputs]";
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("friction.toml");
    std::fs::write(&file, text.replace("[outputs]", friction)).expect("written");
    let run = run(&[&file.display().to_string(), "--step", "3e-3", "--no-figures"]);
    assert_eq!(run.status(), 0, "{}", run.stderr());
    // The drive bears the friction besides the force without it.
    within_errors(&run, "F", [DEAD_POINTS[1].1[0] - 3.0, DEAD_POINTS[1].1[1] + 3.0], "friction");
    let error = run.summary()["extremes"]["F"]["max_error"].as_f64().expect("a number");
    assert!((1.0..3.1).contains(&error), "{error}");
}

#[test]
#[ignore = "full tier: engine"]
fn forces_have_no_derivatives_at_dead_points() {
    let said = |of: &str| {
        let out = tempfile::tempdir().expect("a folder");
        let mut command = qrm(&["sensitivity", &scene("dead-points"), "--step", "3e-4", "--of", of, "--out"]);
        let output = command.arg(out.path()).output().expect("a command");
        (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
    };
    let (status, text) = said("F");
    assert!(status == Some(1) && text.contains("the mechanism is near a singular position"), "{text}");
    assert_eq!(said("end"), (Some(0), String::new()));
}

/// The rate of the crank and its derivative by the frequency next to a dead point, in closed form with 40 digits.
#[test]
#[ignore = "full tier: engine"]
fn derivatives_next_to_dead_points_state_their_errors() {
    let text = std::fs::read_to_string(scene("dead-points")).expect("a scene");
    let text = text.replace("2*pi*t", "w*t").replace("[links]", "w = { value = 7, unit = \"rad/s\" }\n[links]");
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("frequency.toml");
    std::fs::write(&file, text).expect("written");
    let file = file.display().to_string();
    let mut derived = 0;
    for (end, exact) in
        [("0.298", 1.232_771_205_467_634_8), ("0.2987", 1.228_098_404_293_113_8), ("0.3", 1.219_331_948_376_121_7)]
    {
        for method in METHODS {
            let out = folder.path().join(format!("{method}-{end}"));
            let arguments =
                ["sensitivity", &file, "--of", "end", "--by", "w", "--method", method, "--end-time", end, "--out"];
            let output = qrm(&arguments).arg(&out).output().expect("a command");
            if output.status.code() != Some(0) {
                continue;
            }
            let table = Table::read(&out.join("sensitivity.csv"));
            let row = (0..=table.last()).find(|row| table.text(*row, "of") == "phi_crank_dot").expect("the rate");
            near(
                &format!("{end} by {method}"),
                table.number(row, "by_w"),
                exact,
                3.0 * table.number(row, "by_w_error"),
            );
            derived += 1;
        }
    }
    assert!(derived >= 6, "{derived} motions have derivatives");
}

#[test]
#[ignore = "full tier: engine"]
fn a_free_kite_passes_its_change_point() {
    for step in ["0.0005", "0.001", "0.0037"] {
        for method in METHODS {
            let run = completed("kite", &["--step", step, "--method", method]);
            let force = run.summary()["extremes"]["F_A"]["max"].as_f64().expect("a number");
            assert!((force - 1.176_565_80).abs() < 6e-9, "step {step} by {method}: {force}");
        }
    }
}

#[test]
#[ignore = "full tier: engine"]
fn a_pole_of_a_force_is_refused() {
    // With an offset the crank passes its dead points with a rate that no force at the slider can change.
    let text = std::fs::read_to_string(scene("dead-points")).expect("a scene");
    let offset = "sqrt(0.1599) + 0.5*(sqrt(0.1599) - sqrt(0.0399))*(cos(2*pi*t + 60deg) - 1)";
    let text = text.replace("G = [0, 0]", "G = [0, 0.01]").replace("0.3 + 0.1*cos(2*pi*t + 60deg)", offset);
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("offset.toml");
    std::fs::write(&file, text).expect("written");
    let file = file.display().to_string();
    for step in STEPS {
        for method in ["rk4", "dop853"] {
            let run = run(&[&file, "--step", step, "--method", method, "--no-figures"]);
            assert_eq!(run.status(), 1, "step {step} by {method}: {}", run.stderr());
            assert!(run.stderr().contains("forces grow without bound at t = "), "{}", run.stderr());
        }
    }
}

#[test]
#[ignore = "full tier: engine"]
fn a_constraint_without_gradient_is_refused() {
    for (name, constraint) in [("parallel-guides", "right"), ("guides-in-line", "right"), ("guide-by-length", "guide")]
    {
        for command in ["run", "check"] {
            let output = qrm(&[command, &scene(name)]).output().expect("a command");
            let said = String::from_utf8_lossy(&output.stderr).into_owned();
            assert!(!output.status.success(), "{command} {name}");
            assert!(
                said.contains(&format!("constraint `{constraint}` has no gradient wherever it is closed")),
                "{said}"
            );
        }
    }
}
