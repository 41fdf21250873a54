//! `qrm steady` against 40 digits, long runs, closed forms and difference quotients.

use qrm_sim::integrate::{DOP853, MethodSettings};
use qrm_sim::position::Start;
use qrm_sim::run::{End, Request, simulate};
use serde_json::Value;

use crate::common::{self, Run, Table, mechanism, number, within};

/// `qrm steady ARGUMENTS --out` into a fresh folder.
fn run(arguments: &[&str]) -> Run {
    common::writing(&[&["steady"], arguments].concat())
}

/// The contents of `steady.json`.
fn steady(arguments: &[&str]) -> Value {
    common::written(&[&["steady"], arguments].concat(), "steady.json")
}

/// The error of a search that fails.
fn error(arguments: &[&str]) -> String {
    common::error(&[&["steady"], arguments].concat())
}

/// Compares the multipliers, the largest first, with real and imaginary parts.
fn multipliers(motion: &Value, expected: &[[f64; 2]], most: f64) {
    let found = motion["multipliers"].as_array().expect("multipliers");
    assert_eq!(found.len(), expected.len());
    for (multiplier, [re, im]) in found.iter().zip(expected) {
        within(&multiplier["re"], &multiplier["error"], *re, most);
        within(&multiplier["im"], &multiplier["error"], *im, most);
    }
}

/// The states and multipliers come from Taylor series of 40 digits; the period of van der Pol's equation is published
/// too (6.66328685932313...).
#[test]
#[ignore = "full tier: engine"]
fn motions_of_one_coordinate_to_forty_digits() {
    let motion = steady(&["tests/steady/duffing-slider.toml"]);
    within(&motion["start"]["x"], &motion["start_errors"]["x"], 0.604_759_984_473_273_6, 1e-11);
    within(&motion["start"]["x_dot"], &motion["start_errors"]["x_dot"], 0.867_298_254_321_796_5, 1e-11);
    let pair = [0.281_111_841_367_876_2, 0.521_436_419_730_318_6];
    multipliers(&motion, &[pair, [pair[0], -pair[1]]], 1e-11);
    assert_eq!(motion["stability"], "attracting");
    // What the force does, the damper takes.
    let work = |name: &str| (number(&motion["columns"][name]["work"]), number(&motion["columns"][name]["work_error"]));
    let [drive, damper] = ["P_drive", "P_damper"].map(work);
    assert!(
        (drive.0 + damper.0).abs() <= drive.1 + damper.1 && drive.1 < 1e-10 && drive.0 > 0.6,
        "{drive:?} {damper:?}"
    );

    let motion = steady(&["tests/steady/self-excited-slider.toml"]);
    within(&motion["period"], &motion["period_error"], 6.663_286_859_323_13, 1e-11);
    multipliers(&motion, &[[8.596_950_636_038_052e-4, 0.0]], 1e-10);

    // Nothing moves, and the deviations follow the equation of Mathieu.
    let motion = steady(&["tests/steady/swinging-support.toml"]);
    let pair = [-0.893_319_552_293_087_3, 0.449_422_048_291_890_2];
    multipliers(&motion, &[pair, [pair[0], -pair[1]]], 1e-11);
    assert_eq!(motion["stability"], "undecided");

    let motion = steady(&["tests/steady/driven-pendulum.toml"]);
    within(&motion["start"]["phi"], &motion["start_errors"]["phi"], -0.208_598_990_569_326_4, 1e-11);
    within(&motion["start"]["phi_dot"], &motion["start_errors"]["phi_dot"], 1.956_208_440_213_382, 1e-11);
    multipliers(&motion, &[[-1.129_628_972_333_107, 0.0], [-0.007_952_426_186_959_038, 0.0]], 1e-10);
    assert_eq!(motion["stability"], "repelling");
}

/// At resonance the motion of a linear oscillator is `F/(c w) sin(w t)`.
#[test]
#[ignore = "full tier: engine"]
fn a_linear_oscillator_at_resonance() {
    let motion = steady(&["tests/steady/duffing-slider.toml", "--set", "k3=0", "--set", "w=1"]);
    within(&motion["start"]["x"], &motion["start_errors"]["x"], 0.0, 1e-11);
    within(&motion["start"]["x_dot"], &motion["start_errors"]["x_dot"], 1.5, 1e-11);
    let damping = (-0.1 * std::f64::consts::TAU).exp();
    let frequency = std::f64::consts::TAU * (1.0_f64 - 0.01).sqrt();
    let pair = [damping * frequency.cos(), (damping * frequency.sin()).abs()];
    multipliers(&motion, &[pair, [pair[0], -pair[1]]], 1e-11);
    // A conservative one is one of many, and keeps the amplitude of its start.
    let motion = steady(&["tests/steady/self-excited-slider.toml", "--set", "c=0", "--settle", "0"]);
    within(&motion["period"], &motion["period_error"], std::f64::consts::TAU, 1e-11);
    let fastest = &motion["columns"]["x_dot"];
    assert!((number(&fastest["max"]) - 2.0).abs() < 1e-9 && motion["stability"] == "one_of_many", "{fastest}");
}

#[test]
#[ignore = "full tier: engine"]
fn where_a_period_doubles_two_cycles_are_attracting() {
    assert!(
        run(&["tests/steady/driven-pendulum.toml"])
            .stdout()
            .contains("seek a motion of twice the period with --cycles 2")
    );
    let motion = steady(&["tests/steady/driven-pendulum.toml", "--cycles", "2"]);
    assert_eq!(motion["stability"], "attracting");
    // Liouville's formula: the product of all multipliers is exp(-b T / J).
    let product: f64 = motion["multipliers"].as_array().expect("two").iter().map(|m| number(&m["re"])).product();
    let period = number(&motion["period"]);
    assert!((product / (-0.5 * period).exp() - 1.0).abs() < 1e-6, "{product}");
}

/// A branch: `branch.json` and `branch.csv`.
fn branch(arguments: &[&str]) -> (Value, Table) {
    let run = run(arguments);
    assert!(run.output.status.success(), "{}", run.stderr());
    assert!(run.path("branch.svg").exists());
    (run.json("branch.json"), Table::read(&run.path("branch.csv")))
}

/// The folds come from the harmonic balance with 16 odd harmonics, the period doubling from Newton's method on the
/// motion, its derivatives and `det(M + I) = 0`, all with 15 digits.
#[test]
#[ignore = "full tier: engine"]
fn a_branch_goes_around_folds() {
    let (found, rows) = branch(&["tests/steady/duffing-slider.toml", "--vary", "w=0.4:2.5"]);
    let special = found["special"].as_array().expect("special points");
    assert_eq!((special.len(), &found["end"]), (2, &Value::from("reached")));
    for (fold, [w, x]) in special
        .iter()
        .zip([[1.383_856_531_999_59, -0.162_695_765_249_95], [1.303_045_969_455_67, -0.519_404_453_936_45]])
    {
        assert_eq!(fold["kind"], "fold");
        within(&fold["value"], &fold["error"], w, 1e-11);
        within(&fold["start"]["x"], &fold["start_errors"]["x"], x, 1e-9);
        within(&fold["multipliers"][0]["re"], &fold["multipliers"][0]["error"], 1.0, 1e-10);
    }
    let parts = found["parts"].as_array().expect("parts");
    let stabilities: Vec<&Value> = parts.iter().map(|part| &part["stability"]).collect();
    assert_eq!(stabilities, ["attracting", "repelling", "attracting"]);
    // The last row is the motion at the end of the range.
    let last = rows.last();
    assert!(rows.number(last, "w") == 2.5 && last > 20);
    let motion = steady(&["tests/steady/duffing-slider.toml", "--set", "w=2.5"]);
    assert!((rows.number(last, "start_x") - number(&motion["start"]["x"])).abs() < 1e-11);
    let works = (rows.number(last, "P_drive_work"), number(&motion["columns"]["P_drive"]["work"]));
    assert!((works.0 - works.1).abs() < 1e-10, "{works:?}");

    let (found, _) = branch(&["tests/steady/driven-pendulum.toml", "--vary", "T=1.07:1.05"]);
    assert_eq!((&found["end"], found["special"].as_array().map(Vec::len)), (&Value::from("reached"), Some(1)));
    let doubling = &found["special"][0];
    assert_eq!(doubling["kind"], "period_doubling");
    within(&doubling["value"], &doubling["error"], 1.066_372_862_455_207, 1e-10);
    within(&doubling["multipliers"][0]["re"], &doubling["multipliers"][0]["error"], -1.0, 1e-9);

    // A symmetric motion loses its symmetry: from `det(M + I) = 0` of half a period, with the sign changed.
    let (found, _) = branch(&["tests/steady/driven-pendulum.toml", "--vary", "T=0.9:1.1"]);
    let crossing = found["special"].as_array().expect("special points");
    assert_eq!((crossing.len(), &crossing[0]["kind"]), (1, &Value::from("branch_point")));
    within(&crossing[0]["value"], &crossing[0]["error"], 1.004_319_477_426_47, 1e-8);
}

/// Each point of a linear oscillator through its resonance has a closed form.
#[test]
#[ignore = "full tier: engine"]
fn errors_are_stated_all_along_a_branch() {
    let (_, rows) = branch(&["tests/steady/duffing-slider.toml", "--set", "k3=0", "--vary", "w=0.5:3"]);
    let (c, force) = (0.2, 0.3);
    let mut worst: f64 = 0.0;
    for row in 0..rows.rows.len() {
        let w = rows.number(row, "w");
        let amplitude = force / (1.0 - w * w).hypot(c * w);
        let phase = (c * w).atan2(1.0 - w * w);
        let work = std::f64::consts::PI * force * amplitude * phase.sin();
        for (name, expected) in [
            ("start_x", amplitude * phase.cos()),
            ("start_x_dot", amplitude * w * phase.sin()),
            ("x_dot_max", amplitude * w),
            ("P_drive_work", work),
            ("P_damper_work", -work),
        ] {
            let error = (rows.number(row, name) - expected).abs();
            worst = worst.max(error / rows.number(row, &format!("{name}_error")));
            assert!(error < 1e-10, "{name} at w = {w}: off by {error:e}");
        }
    }
    assert!(worst <= 3.0 && rows.rows.len() < 200, "{worst} times the stated error, {} points", rows.rows.len());
}

#[test]
#[ignore = "full tier: engine"]
fn parameters_follow_the_one_that_is_varied() {
    let source = std::fs::read_to_string("tests/steady/duffing-slider.toml").expect("a scene");
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("follows.toml");
    std::fs::write(&path, source.replace(r#"k3 = { value = 1.0, unit = "N/m^3","#, "k3 = { value = 'k/1^2',"))
        .expect("written");
    let scene = path.to_str().expect("a path");
    let (_, rows) = branch(&[scene, "--vary", "k=2:3"]);
    let motion = steady(&[scene, "--set", "k=3"]);
    for name in ["x", "x_dot"] {
        let found = rows.number(rows.last(), &format!("start_{name}"));
        assert!((found - number(&motion["start"][name])).abs() < 1e-11, "{name}: {found} {}", motion["start"]);
    }
    // One that is set does not follow.
    let (_, rows) = branch(&[scene, "--set", "k3=2", "--vary", "k=2:3"]);
    let motion = steady(&[scene, "--set", "k3=2", "--set", "k=3"]);
    let found = rows.number(rows.last(), "start_x");
    assert!((found - number(&motion["start"]["x"])).abs() < 1e-11, "{found} {}", motion["start"]);
}

/// The speed of a machine over its flywheel, at both ends.
#[test]
fn a_branch_ends_where_a_search_would() {
    let (found, rows) = branch(&["shaper", "--vary", "J2=30:60"]);
    assert_eq!((&found["end"], &found["special"]), (&Value::from("reached"), &serde_json::json!([])));
    for (row, value) in [(0, "J2=30"), (rows.last(), "J2=60")] {
        let motion = steady(&["shaper", "--set", value]);
        assert!((rows.number(row, "period") - number(&motion["period"])).abs() < 1e-10);
        let fluctuation = number(&motion["columns"]["phi2_dot"]["fluctuation"]);
        assert!((rows.number(row, "phi2_dot_fluctuation") - fluctuation).abs() < 1e-9);
    }
    // Nothing chooses its speed.
    let failed = error(&["quick-return", "--vary", "J2=10:20"]);
    assert!(failed.contains("is one of a family of motions at this value of the parameter"), "{failed}");
}

/// The condition of a linear oscillator has a closed form: the velocity is `F w / sqrt((k - m w^2)^2 + (c w)^2)`.
#[test]
#[ignore = "full tier: engine"]
fn a_parameter_is_solved_for() {
    let scene = "tests/steady/duffing-slider.toml";
    let motion = steady(&[scene, "--set", "k3=0", "--set", "w=2", "--solve", "c", "--for", "max(x_dot) = 0.15"]);
    let expected = ((0.3 * 2.0 / 0.15_f64).powi(2) - 9.0).sqrt() / 2.0;
    within(&motion["solved"]["value"], &motion["solved"]["error"], expected, 1e-9);
    assert!((number(&motion["columns"]["x_dot"]["max"]) - 0.15).abs() < 1e-11);
    // Without friction and loss the speed is at most 0.2.
    let failed = error(&[scene, "--set", "k3=0", "--set", "w=2", "--solve", "c", "--for", "max(x_dot) = 0.25"]);
    assert!(failed.contains("no value of `c` was found with max(x_dot) = 0.25. Nearest is c = "), "{failed}");
}

#[test]
fn a_flywheel_is_solved_for() {
    let motion = steady(&["shaper", "--solve", "J2", "--for", "fluctuation(phi2_dot) = 0.1"]);
    let value = number(&motion["solved"]["value"]);
    let again = steady(&["shaper", "--set", &format!("J2={value}")]);
    let fluctuation = number(&again["columns"]["phi2_dot"]["fluctuation"]);
    assert!((fluctuation - 0.1).abs() < 1e-10 && value > 100.0, "{value}: {fluctuation}");
    for (condition, words) in [
        ("fluct(phi2_dot) = 0.02", "there is no quantity `fluct`"),
        ("fluctuation(phi2) = 0.02", "there is no rate or output `phi2`"),
        ("fluctuation(phi2_dot)", "there is no `=`"),
        ("phi2_dot = 3", "left of `=` stands no `QUANTITY(NAME)`"),
        ("work(x6) = 1", "`x6` has no work that is known"),
        ("mean(phi2_dot) = 1 kg", "--for"),
        ("work(P_cutting) = -1200", "work(P_cutting) does not depend on `J2`"),
    ] {
        let error = error(&["shaper", "--solve", "J2", "--for", condition]);
        assert!(error.contains(words), "{condition}: {error}");
    }
}

/// The rate of the crank after 2000 turns from elsewhere, and the multiplier by differences of one turn.
#[test]
fn a_motor_settles_where_it_is_found_at_once() {
    let motion = steady(&["shaper"]);
    let rate = number(&motion["start"]["phi2_dot"]);
    assert!((rate - 9.446_409_781_847_5).abs() < 1e-11, "{rate}");
    let mechanism = mechanism("shaper", &[]);
    let after_turn = |rate: f64| {
        let mut start = Start::new(&*mechanism);
        start.qd[0] = rate;
        let settings = MethodSettings::new(DOP853, 1e-13);
        let event = crate::common::event(crate::common::model("shaper"), "phi2 >= 2*pi");
        let request = Request { settings, start: Some(start), end: Some(End::Event(&event)), ..Request::default() };
        let outcome = simulate(&*mechanism, &request, &mut ()).expect("it begins");
        assert!(outcome.status.is_done());
        outcome.qd[0]
    };
    assert!((after_turn(rate) - rate).abs() < 1e-11);
    let h = 1e-3;
    let slope = |h: f64| (after_turn(rate + h) - after_turn(rate - h)) / (2.0 * h);
    // Richardson's extrapolation of central differences.
    let expected = (4.0 * slope(h) - slope(2.0 * h)) / 3.0;
    multipliers_of_slope(&motion, expected);
    // The tool takes the integral of its force along the stroke: 2000 N over 0.6 m with ramps of 0.02 m at both ends.
    // The motor also serves the friction of the ram and the damper of the bearing.
    let work = |name: &str| number(&motion["columns"][name]["work"]);
    let [motor, cutting, friction] = ["P_motor", "P_cutting", "P_friction"].map(work);
    assert!((cutting + 1200.0).abs() < 1e-9 && (motor + cutting + friction - 105.83).abs() < 0.01, "{motor} {cutting}");
    let [balance, buffer] = ["P_balance", "P_buffer"].map(work);
    assert!(balance.abs() < 1e-7 && buffer.abs() < 1e-7, "{balance} {buffer}");
}

/// Difference quotients hold nine digits.
fn multipliers_of_slope(motion: &Value, expected: f64) {
    let found = &motion["multipliers"][0];
    assert!((number(&found["re"]) - expected).abs() < 1e-8 && number(&found["error"]) < 1e-9, "{found} {expected}");
}

#[test]
fn a_mechanism_without_losses_has_many_motions() {
    let motion = steady(&["quick-return", "--settle", "0"]);
    assert_eq!(motion["stability"], "one_of_many");
    within(&motion["multipliers"][0]["re"], &motion["multipliers"][0]["error"], 1.0, 1e-9);
    // Half of the time of two turns with 40 digits (`tests/reference/quick-return-states.csv`).
    within(&motion["period"], &motion["period_error"], 0.877_997_139_511_224_4, 1e-11);
    // It swings between limit positions, through turns of none of its angles.
    let motion = steady(&["four-bar"]);
    assert_eq!((&motion["stability"], &motion["turns"]["q1"]), (&Value::from("one_of_many"), &Value::from(0.0)));
}

#[test]
fn a_drive_prescribes_the_motion() {
    let motion = steady(&["quick-return-driven"]);
    assert_eq!((number(&motion["period"]), &motion["stability"]), (0.8, &Value::from("no_deviation")));
    assert_eq!(motion["turns"]["phi2"], 1.0);
    let torque = &motion["columns"]["torque"];
    assert!(
        number(&torque["mean"]).abs() <= 3.0 * number(&torque["mean_error"]) && number(&torque["mean_error"]) < 1e-8
    );
}

#[test]
fn the_period_is_an_ordinary_run() {
    let run = run(&["shaper", "--rows", "90"]);
    assert!(run.output.status.success(), "{}", run.stderr());
    let summary = run.summary();
    assert_eq!((&summary["status"], &summary["rows"]), (&Value::from("completed"), &Value::from(91)));
    let motion = run.json("steady.json");
    // The end of the period is its start, a turn later.
    let end = number(&summary["end_state"]["phi2_dot"]);
    assert!((end - number(&motion["start"]["phi2_dot"])).abs() < 1e-10);
    assert!((number(&summary["end_state"]["phi2"]) - std::f64::consts::TAU).abs() < 1e-10);
    assert!(run.path("figures/rates.svg").exists() && run.path("trajectory.csv").exists());
}

#[test]
fn where_there_is_no_steady_motion_it_is_said() {
    for (arguments, words) in [
        (&["slider-crank"][..], "leads to a state of rest"),
        (&["double-pendulum"], "no periodic motion was found. Nearest is a="),
        (&["pendulum"], "on another branch"),
        (&["quick-return", "--period", "1"], "no load or drive of scene `quick-return` depends on time"),
        (&["quick-return-driven", "--phase", "phi2"], "`--phase`: loads or drives depend on time"),
        (&["quick-return", "--phase", "phi4"], "gives no coordinate `phi4` at its start"),
        (&["quick-return", "--method", "rk4"], "`--method rk4` has fixed steps"),
        (&["quick-return-driven", "--period", "0"], "must be above zero"),
        (&["shaper", "--vary", "J2"], "`--vary J2` has no `=`"),
        (&["shaper", "--vary", "J2=1"], "`--vary J2=1` has no `:`"),
        (&["shaper", "--vary", "J2=1:1"], "varies nothing"),
        (&["shaper", "--vary", "J3=1:2"], "has no parameter `J3`"),
        (&["shaper", "--vary", "J2=1:2", "--set", "J2=1"], "`--set` and `--vary` both give `J2`"),
        (&["quick-return-driven", "--period", "0.3"], "on another branch"),
    ] {
        let error = error(arguments);
        assert!(error.contains(words), "{arguments:?}: {error}");
    }
    let motion = steady(&["pendulum", "--cycles", "2"]);
    assert_eq!(motion["repetitions"], 1);
}
