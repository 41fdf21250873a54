//! Tests of `qrm check` against exact values and closed forms.

use std::f64::consts::TAU;

use crate::common::{Table, near, qrm};

/// The output of a successful `qrm check ARGUMENTS`.
fn check(arguments: &[&str]) -> String {
    check_with(arguments, 0)
}

/// The output of `qrm check ARGUMENTS` that ends with a status.
fn check_with(arguments: &[&str], status: i32) -> String {
    let output = qrm(&["check"]).args(arguments).output().expect("the command starts");
    assert_eq!(output.status.code(), Some(status), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).expect("text")
}

/// The number that follows a text.
#[track_caller]
fn after(text: &str, lead: &str) -> f64 {
    let rest = text.split_once(lead).unwrap_or_else(|| panic!("`{lead}` is not in\n{text}")).1.trim_start();
    let end = rest.find(|c: char| !c.is_ascii_digit() && !".-+e".contains(c)).unwrap_or(rest.len());
    rest[..end].trim_end_matches('.').parse().unwrap_or_else(|_| panic!("no number after `{lead}` in\n{text}"))
}

#[test]
fn forces_at_rest_are_the_exact_ones() {
    let exact = Table::reference("quick-return-statics.csv");
    for row in 0..exact.rows.len() {
        let text = check(&["--static", &format!("phi2={}deg", exact.text(row, "phi2_deg"))]);
        for (lead, column) in
            [("on phi2", "T2"), ("phi4", "phi4"), ("phi5", "phi5"), ("x6", "x6"), ("N3", "N3"), ("N6", "N6")]
        {
            let expected = exact.number(row, column);
            near(&format!("{column} in row {row}"), after(&text, lead), expected, 1e-9 * expected.abs().max(1.0));
        }
    }
}

#[test]
fn balance_is_the_work_of_the_loads() {
    // By virtual work the torque is -F dx6/dphi2; the derivative by differences of positions that are closed anew.
    let x6 = |angle: f64| after(&check(&["--static", &format!("phi2={angle}")]), "x6");
    let (angle, h) = (0.7, 1e-3);
    let slope = (8.0 * (x6(angle + h) - x6(angle - h)) - x6(angle + 2.0 * h) + x6(angle - 2.0 * h)) / (12.0 * h);
    near("torque", after(&check(&["--static", "phi2=0.7"]), "on phi2"), -1000.0 * slope, 1e-4);
    // Gravity and a torque on the crank are loads like others.
    let loaded = ["quick-return-loaded", "--set", "g=9.81", "--set", "T2=100", "--static", "phi2=0.7"];
    let (with, without) = (check(&loaded), check(&[&loaded[..3], &loaded[5..]].concat()));
    near("T2", after(&with, "on phi2"), after(&without, "on phi2") - 100.0, 1e-7);
}

#[test]
fn the_ram_has_its_stroke_and_time_ratio() {
    let text = check(&[]);
    // The ram stands still where the crank is at right angles to the rocker.
    let from_below = (2.0_f64 / 3.0).acos();
    let [first, second] = [0.75 * TAU - from_below, 0.75 * TAU + from_below];
    near("one dead point", after(&text, "-0.9324202 m at phi2 = "), first.to_degrees(), 1e-4);
    near("the other", after(&text, "9.1316069e-4 m at phi2 = "), second.to_degrees(), 1e-4);
    near(
        "time ratio",
        after(&text, "back during 96.3794 deg: ratio "),
        (TAU - (second - first)) / (second - first),
        2e-6,
    );
    near("stroke", after(&text, "stroke       "), 0.000913160692004732 + 0.9324201726413286, 1e-7);
    assert!(text.contains("energy    kinetic and potential: constant within 1.3e-6 J"), "{text}");
    near("a turn", after(&text, "after a turn of phi2, at t = "), 0.877997139511224, 1e-9);
}

#[test]
fn a_full_turn_needs_certain_lengths() {
    let text = check(&[]);
    near("BC", after(&text, "BC >= "), 0.378250805249050, 6e-8);
    near("O4B", after(&text, "<= O4B <= "), 1.5, 6e-8);
    near("yC", after(&text, "<= yC <= "), 0.6 + 0.7 * (1.0_f64 - 4.0 / 9.0).sqrt(), 6e-8);
    // Its own run turns back at the lock, and so does not get to its end.
    let locked = check_with(&["--set", "BC=0.37"], 1);
    near("what it lacks", after(&locked, "BC >= "), 0.378250805249050, 6e-8);
    // It locks where the rod points straight up, on both sides.
    let angle = after(&locked, "it can move from ").to_radians();
    let rocker = ((0.3 + 0.2 * angle.sin()) / (0.2 * angle.cos())).atan();
    near("height of B", 0.7 * rocker.sin(), 0.9 - 0.37, 1e-6);
    near("the other end", after(&locked, "holds it, to "), 180.0 - angle.to_degrees(), 1e-3);
    assert!(locked.contains("where constraint `guide` holds it"), "{locked}");
    assert!(check(&["--set", "BC=0.3783"]).contains("turns all the way"), "just long enough");
    assert!(check_with(&["--set", "BC=0.3782"], 1).contains("phi2 locks"), "just too short");
    let unloaded = check_with(&["--set", "BC=0.37", "--set", "F6=0"], 1);
    assert!(unloaded.contains("limit positions: always 0.0000000 N m"), "no load, no torque: {unloaded}");
}

#[test]
fn a_ram_with_four_dead_points_has_no_time_ratio() {
    let text = check(&["--set", "O2A=0.25"]);
    let line = text.split_once("dead points  at phi2 = ").expect("dead points").1.lines().next().expect("a line");
    let angles: Vec<f64> = line.split(", ").map(|angle| after(angle, "")).collect();
    // The crank at right angles to the rocker, and the rod in line with the rocker: 0.9 = 1.3 sin(phi4), on both sides.
    let square = (0.25_f64 / 0.3).acos();
    let rocker = (0.9_f64 / 1.3).asin();
    // The slot: O4A points along the rocker, so 0.25 sin(phi2 - phi4) = -0.3 cos(phi4).
    let lean = std::f64::consts::PI - rocker;
    let rest = (0.3 * lean.cos() / 0.25).asin();
    let in_line = [lean - rest, lean + std::f64::consts::PI + rest].map(|angle| angle.rem_euclid(TAU));
    let mut expected = [0.75 * TAU - square, 0.75 * TAU + square, in_line[0], in_line[1]];
    expected.sort_by(f64::total_cmp);
    assert_eq!(angles.len(), 4, "{line}");
    for (angle, expected) in angles.iter().zip(expected) {
        near("a dead point", *angle, expected.to_degrees(), 1e-4);
    }
    assert!(!text.contains("ratio"), "{text}");
}

#[test]
fn units_and_turns_do_not_matter() {
    let lengths = ["O2A=0.2", "O4B=0.7", "BC=0.6", "O4O2=0.3", "O4G4=0.4", "BG5=0.3", "yC=0.9"];
    let scaled = |factor: f64| -> Vec<String> {
        let length = |text: &&str| {
            let (name, value) = text.split_once('=').expect("a value");
            ["--set".to_owned(), format!("{name}={value}*{factor}")]
        };
        lengths.iter().flat_map(length).collect()
    };
    let at_rest = |factor: f64, angle: &str| {
        let mut arguments = scaled(factor);
        arguments.extend(["--static".to_owned(), format!("phi2={angle}")]);
        check(&arguments.iter().map(String::as_str).collect::<Vec<_>>())
    };
    let plain = at_rest(1.0, "45deg");
    for factor in [1e-6, 1e-3, 1e3, 1e6] {
        let text = at_rest(factor, "45deg");
        for angle in ["phi4", "phi5"] {
            near(&format!("{angle} at {factor:e}"), after(&text, angle), after(&plain, angle), 1e-9);
        }
        near("N3", after(&text, "N3"), after(&plain, "N3"), 1e-6);
        near("torque", after(&text, "on phi2") / factor, after(&plain, "on phi2"), 1e-6);
    }
    for turns in [-7, 1, 20] {
        let text = at_rest(1.0, &format!("pi/4+2*pi*{turns}"));
        near("phi4 after turns", after(&text, "phi4"), after(&plain, "phi4"), 1e-9);
        near("phi5 after turns", after(&text, "phi5"), after(&plain, "phi5"), 1e-9);
    }
}

#[test]
fn different_coordinates_make_one_position() {
    let twice = check(&["--static", "phi2=0", "--static", "phi2=90deg"]);
    assert_eq!(twice.matches("quick-return at rest").count(), 2, "{twice}");
}

#[test]
fn work_of_a_damper_is_balanced() {
    let text = check(&["quick-return-loaded", "--set", "cd=50"]);
    let (change, work) = (after(&text, "energy    changes by "), after(&text, "do work of "));
    assert!(change < -100.0, "{text}");
    near("work", work, change, 1e-5);
    assert!(text.contains("the motion does not repeat"), "{text}");
}

#[test]
fn change_of_energy_is_that_of_the_trajectory() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().to_str().expect("text");
    // Runs of many rows and of three.
    for more in [&[][..], &["--step", "0.02", "--end-time", "0.04"]] {
        let text = check(&[&["shaper"], more].concat());
        let run = qrm(&["run", "shaper", "--out", out]).args(more).output().expect("the command starts");
        assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
        let mut table = csv::Reader::from_path(folder.path().join("trajectory.csv")).expect("a table");
        let place = table.headers().expect("columns").iter().position(|name| name == "energy").expect("energy");
        let energy: Vec<f64> =
            table.records().map(|row| row.expect("a row")[place].parse().expect("a number")).collect();
        near("change", after(&text, "energy    changes by "), energy[energy.len() - 1] - energy[0], 1e-6);
    }
}

#[test]
#[ignore = "full tier: engine"]
fn a_drive_is_released_to_look_at_its_way() {
    let driven = check(&["quick-return-driven"]);
    let lines = |text: &str, from: &str, to: &str| {
        let (_, rest) = text.split_once(from).unwrap_or_else(|| panic!("no `{from}` in\n{text}"));
        rest.split_once(to).unwrap_or_else(|| panic!("no `{to}` in\n{text}")).0.to_owned()
    };
    let of_turn = |text: &str| lines(text, "  turn ", "  run ");
    assert_eq!(of_turn(&driven), of_turn(&check(&["quick-return"])));
    // The drive holds what a torque on the crank would.
    let at_rest = check(&["quick-return-driven", "--static", "phi2=45deg"]);
    let torque = after(&check(&["quick-return", "--static", "phi2=45deg"]), "on phi2");
    near("torque on the crank", after(&at_rest, "on phi2"), torque, 1e-9);
    near("torque of the drive", after(&at_rest, "\n  torque"), torque, 1e-9);
    // A slider on a rod of 0.5 m and a crank of 0.2 m, driven along its line from 0.6 m on.
    let slider = check(&["tests/linkage/driven-slider.toml"]);
    near("inner dead point", after(&slider, "open_drive locks: it can move from "), 0.5 - 0.2 - 0.6, 1e-6);
    near("outer dead point", after(&slider, "dead point, to "), 0.5 + 0.2 - 0.6, 1e-6);
    assert!(slider.contains("s_tree moves freely"), "{slider}");
    assert!(slider.contains("beyond all bounds at "), "a force on a slider at its dead point moves nothing: {slider}");
    // Scissors of two stages: the height is twice the rise of a bar of 2 m. By virtual work, that of the screw is
    // F dx = sum m g dy.
    let lift = "scenes/linkages/scissor-lift.toml";
    let text = check(&[lift]);
    near("lowered", after(&text, "dead point, to "), 0.4, 1e-6);
    near("raised", after(&text, "4.0000000 m at screw_drive = "), -1.6, 1e-4);
    let held = check(&[lift, "--static", "screw_drive=-0.4"]);
    let weight = 9.81 * (40.0 * (0.5 + 0.5 + 1.5 + 1.5) + 450.0 * 2.0);
    near("force of the screw", after(&held, "on screw_drive"), -weight * 1.2 / 1.6, 1e-6);
}

#[test]
#[ignore = "full tier: engine"]
fn an_output_of_rounding_errors_does_not_move() {
    let text = check(&["scenes/linkages/planetary.toml"]);
    assert!(text.contains("ratio     always 0.0000000\n"), "{text}");
}

#[test]
fn positions_that_cannot_be_asked_for() {
    for (position, said) in [
        ("phi2", "`phi2` has no `=`"),
        ("phi4=1", "`phi4` follows from the constraints"),
        ("ph2=1", "did you mean `phi2`?"),
        ("phi2=x", "contains the name `x`"),
        ("phi2=1/0", "gives inf"),
    ] {
        let output = qrm(&["check", "--static", position]).output().expect("the command starts");
        let error = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{position}: {error}");
        assert!(error.contains(said), "{position}: {error}");
    }
    let beyond = qrm(&["check", "--set", "BC=0.37", "--static", "phi2=270deg"]).output().expect("the command starts");
    let error = String::from_utf8_lossy(&beyond.stderr).into_owned();
    assert_eq!(beyond.status.code(), Some(2), "{error}");
    assert!(error.contains("the mechanism locks at phi2 = 209.27"), "{error}");
}

#[test]
fn a_crank_turns_through_change_points() {
    let text = check(&["n-four-bar-2"]);
    assert!(text.contains("a0 turns all the way"), "{text}");
    assert!(text.contains("to another branch: 0.0000 deg, 180.0000 deg\n"), "{text}");
    assert!(text.contains("dead points  at a0 = 0.0000 deg, 180.0000 deg\n"), "{text}");
    // The weights of three cranks and two couplers turn the cranks, which stay parallel.
    near("torque", after(&text, "largest      34"), 3.5 * 9.81 - 34.0, 1e-6);
    // Four-bars whose shortest and longest links are as long together as the others, and one that misses it by a hair.
    let four_bar = |lengths: [&str; 4]| {
        let mut command = qrm(&["check", "four-bar"]);
        for (i, length) in lengths.into_iter().enumerate() {
            command.args(["--set".to_owned(), format!("l{}={length}", i + 1)]);
        }
        String::from_utf8(command.output().expect("the command starts").stdout).expect("text")
    };
    for (lengths, angles) in [
        (["0.13", "0.24", "0.21", "0.32"], "180.0000 deg"),
        (["0.11", "0.24", "0.21", "0.34"], "180.0000 deg"),
        (["0.13", "0.24", "0.13", "0.24"], "180.0000 deg, 0.0000 deg"),
        (["0.24", "0.13", "0.24", "0.13"], "180.0000 deg, 0.0000 deg"),
        (["0.2"; 4], "180.0000 deg, 0.0000 deg"),
    ] {
        let text = four_bar(lengths);
        assert!(text.contains("q1 turns all the way"), "{lengths:?}: {text}");
        assert!(text.contains(&format!("to another branch: {angles}\n")), "{lengths:?}: {text}");
    }
    let text = four_bar(["0.1100001", "0.24", "0.21", "0.34"]);
    // It locks where the second and third rod are in line.
    let (ground, first, rest) = (0.110_000_1_f64, 0.24_f64, 0.34 - 0.21);
    let inner = ((ground * ground + first * first - rest * rest) / (2.0 * ground * first)).acos();
    near("the lock", after(&text, "begins, to "), 180.0 - inner.to_degrees(), 1e-3);
}

/// A rod on a pin: the torque that balances its weight is `m g l/2 cos(phi)`, with a motor and without.
#[test]
#[ignore = "full tier: engine"]
fn torques_of_motors_at_standstill_do_not_balance_loads() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("scene.toml");
    let with = |motor: &str| {
        let text = format!(
            r#"
name = "rod"
[links]
ground = {{ points = {{ A = [0, 0] }} }}
rod = {{ bar = ["A", "B"], length = 1, mass = 2, angle = 0 }}
[joints]
A = {{ revolute = ["rod", "ground"] }}
[loads]
weight = {{ gravity = [0, -9.81] }}
{motor}
[run]
step = 1e-3
end_time = 0.1
"#
        );
        std::fs::write(&path, text).expect("written");
        check(&[path.to_str().expect("a path")])
    };
    let alone = with("");
    for motor in [
        "motor = { along = 'phi_rod', motor = '300 N m', no_load = '60 rpm' }",
        "motor = { along = 'phi_rod', force = '300*(1 - s_dot/6)', damper = 2 }",
        "motor = { torque = '300*(1 - phi_rod_dot/6)', on = \"rod\" }",
    ] {
        let text = with(motor);
        for lead in ["smallest    ", "largest     "] {
            near(lead, after(&text, lead), after(&alone, lead), 1e-12);
        }
        near("largest", after(&text, "largest     "), 9.81, 1e-6);
        assert!(text.contains("balances the loads other than `motor`"), "{text}");
        let held = check(&[path.to_str().expect("a path"), "--static", "phi_rod=60deg"]);
        near("held", after(&held, "on phi_rod"), 9.81 * 0.5, 1e-9);
    }
}
