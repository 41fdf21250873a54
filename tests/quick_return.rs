//! The default run against exact values.

use qrm_sim::position::{Start, assemble_from_guesses};

use crate::common::{Table, mechanism, near, run};

const COORDINATES: [&str; 3] = ["phi2", "phi4", "phi5"];

#[test]
fn states_at_half_a_second() {
    let run = run(&["--end-time", "0.5"]);
    assert_eq!(run.status(), 0, "{}", run.stderr());
    let (got, exact) = (run.trajectory(), Table::reference("quick-return-states.csv"));
    let row = (0..exact.rows.len()).find(|&row| exact.number(row, "t") == 0.5).expect("a row at 0.5 s");
    let last = got.last();
    near("t", got.number(last, "t"), 0.5, 0.0);
    for name in COORDINATES {
        near(name, got.number(last, name), exact.number(row, name), 1e-11);
        let rate = format!("{name}_dot");
        near(&rate, got.number(last, &rate), exact.number(row, &rate), 2e-10);
        let acceleration = format!("{name}_ddot");
        near(&acceleration, got.number(last, &acceleration), exact.number(row, &acceleration), 1e-8);
    }
    for force in ["N3", "N6"] {
        near(force, got.number(last, force), exact.number(row, force), 1e-6);
    }
    near("lambda_slot", got.number(last, "lambda_slot"), exact.number(row, "lambda1"), 1e-6);
    near("lambda_guide", got.number(last, "lambda_guide"), exact.number(row, "lambda2"), 1e-6);
    for output in ["x6", "x6_dot", "x6_ddot", "v_slide"] {
        near(output, got.number(last, output), exact.number(row, output), 1e-9);
    }
}

#[test]
fn every_row_belongs_to_its_own_time() {
    // Accelerations and forces of a row are those of its corrected state, not means over a step.
    let exact = Table::reference("quick-return-states.csv");
    let run = run(&["--end-time", "1.0"]);
    let got = run.trajectory();
    let mut compared = 0;
    for row in 0..exact.rows.len() {
        let t = exact.number(row, "t");
        let Some(at) = (0..got.rows.len()).find(|&r| (got.number(r, "t") - t).abs() < 1e-9) else { continue };
        near("x6_ddot", got.number(at, "x6_ddot"), exact.number(row, "x6_ddot"), 1e-8);
        near("N3", got.number(at, "N3"), exact.number(row, "N3"), 1e-5);
        near("phi4_ddot", got.number(at, "phi4_ddot"), exact.number(row, "phi4_ddot"), 1e-8);
        compared += 1;
    }
    assert_eq!(compared, 6);
}

#[test]
fn two_revolutions_end_where_they_should() {
    let run = run(&[]);
    assert_eq!(run.status(), 0, "{}", run.stderr());
    let summary = run.summary();
    assert_eq!(summary["status"], "stopped");
    near("end time", summary["end_time"].as_f64().expect("a number"), 1.755_994_279_022_448_8, 1e-9);
    near("phi2", summary["end_state"]["phi2"].as_f64().expect("a number"), 4.0 * std::f64::consts::PI, 1e-14);
    assert!(summary["energy_drift"].as_f64().expect("a number") <= 2e-6, "{}", summary["energy_drift"]);
    assert!(summary["max_residual_position"].as_f64().expect("a number") <= 1e-12);
    assert!(summary["max_residual_velocity"].as_f64().expect("a number") <= 1e-10);
    let trajectory = run.trajectory();
    assert_eq!(trajectory.rows.len(), 1757);
    for row in 0..trajectory.rows.len() {
        near("energy", trajectory.number(row, "energy"), 3_258.037_491_040_094_7, 2e-6);
    }
    // The motion recurs.
    for name in ["phi4", "phi5", "phi2_dot", "phi4_dot", "phi5_dot"] {
        near(name, trajectory.number(trajectory.last(), name), trajectory.number(0, name), 2e-8);
    }
}

#[test]
fn extremes_of_every_quantity() {
    let names = [
        ("phi2d", "phi2_dot"),
        ("phi4d", "phi4_dot"),
        ("phi5d", "phi5_dot"),
        ("phi2dd", "phi2_ddot"),
        ("phi4dd", "phi4_ddot"),
        ("phi5dd", "phi5_ddot"),
        ("phi4", "phi4"),
        ("phi5", "phi5"),
        ("v_slide", "v_slide"),
        ("x6", "x6"),
        ("x6d", "x6_dot"),
        ("x6dd", "x6_ddot"),
        ("lambda1", "lambda_slot"),
        ("lambda2", "lambda_guide"),
        ("N3", "N3"),
        ("N6", "N6"),
    ];
    let exact = Table::reference("quick-return-extremes.csv");
    // Rows that are far apart do not hide what is between them: there the ends of steps tell, as far as they show it.
    for (arguments, accuracy) in [
        (&[][..], 1e-4),
        (&["--method", "dop853", "--step", "0.25"], 1e-3),
        (&["--method", "dopri5", "--step", "10"], 1e-3),
    ] {
        let summary = run(arguments).summary();
        let mut compared = 0;
        for row in 0..exact.rows.len() {
            let Some((_, column)) = names.iter().find(|(name, _)| *name == exact.text(row, "quantity")) else {
                continue;
            };
            let (which, value) = (exact.text(row, "which"), exact.number(row, "value"));
            let got = summary["extremes"][column][which].as_f64().expect("an extreme");
            near(&format!("{which} of {column}, {arguments:?}"), got, value, accuracy * value.abs());
            compared += 1;
        }
        assert_eq!(compared, 2 * names.len());
    }
}

/// Largest error of the coordinates at 0.5 s.
fn error(step: &str) -> f64 {
    let exact = Table::reference("quick-return-states.csv");
    let row = (0..exact.rows.len()).find(|&row| exact.number(row, "t") == 0.5).expect("a row at 0.5 s");
    let summary = run(&["--end-time", "0.5", "--step", step, "--no-error-estimate"]).summary();
    let off = |name: &&str| (summary["end_state"][name].as_f64().expect("a number") - exact.number(row, name)).abs();
    COORDINATES.iter().map(off).fold(0.0, f64::max)
}

#[test]
fn the_error_falls_with_the_fourth_power_of_the_step() {
    let errors = ["4e-3", "2e-3", "1e-3", "5e-4"].map(error);
    for pair in errors.windows(2) {
        let ratio = pair[0] / pair[1];
        assert!((13.0..=18.0).contains(&ratio), "{errors:?}: {ratio}");
    }
}

#[test]
fn the_projections_differ_as_they_should() {
    let drift = |projection: &str| {
        let summary = run(&["--projection", projection]).summary();
        (
            summary["energy_drift"].as_f64().expect("a number"),
            summary["max_residual_position"].as_f64().expect("a number"),
        )
    };
    let [none, euclidean, mass] = ["none", "euclidean", "mass"].map(drift);
    assert!(none.1 > 1e-11 && euclidean.1 < 1e-14 && mass.1 < 1e-14, "{none:?} {euclidean:?} {mass:?}");
    assert!(mass.0 < euclidean.0, "{euclidean:?} {mass:?}");
}

#[test]
fn both_scenes_give_the_same_motion() {
    let plain = run(&["quick-return", "--end-time", "0.3"]).trajectory();
    let loaded = run(&["quick-return-loaded", "--end-time", "0.3"]).trajectory();
    assert_eq!(plain.columns, loaded.columns);
    for column in &plain.columns {
        let (a, b) = (plain.number(plain.last(), column), loaded.number(loaded.last(), column));
        near(column, a, b, 1e-11 * a.abs().max(1.0));
    }
}

#[test]
#[ignore = "full tier: engine"]
fn stiff_and_extreme_variants() {
    // At a step of 1e-4 s each variant is as near to the exact state as plain RK4 with Euclidean projection gets, or
    // the run says that it broke off, where that method gives nothing.
    let cases = Table::reference("quick-return-extreme-cases.csv");
    for row in 0..cases.rows.len() {
        let parameters = cases.text(row, "params");
        let sets: Vec<&str> = parameters.split(' ').flat_map(|set| ["--set", set]).collect();
        let end = cases.text(row, "t_end");
        let mut arguments = vec![
            "quick-return-loaded",
            "--end-time",
            end,
            "--step",
            "1e-4",
            "--every",
            "100000",
            "--no-error-estimate",
        ];
        arguments.extend(sets);
        let run = run(&arguments);
        let summary = run.summary();
        let expected = cases.number(row, "rk4gn_err_h1e-4");
        if expected.is_nan() {
            assert_eq!((run.status(), &summary["status"]), (1, &"failed".into()), "{parameters}");
            assert!(run.stderr().contains("could not be closed again"), "{parameters}: {}", run.stderr());
            continue;
        }
        assert_eq!(run.status(), 0, "{parameters}: {}", run.stderr());
        for name in COORDINATES {
            let off = summary["end_state"][name].as_f64().expect("a number") - cases.number(row, name);
            let off = off - std::f64::consts::TAU * (off / std::f64::consts::TAU).round();
            // Tens of thousands of steps leave rounding errors of this size.
            assert!(off.abs() <= (2.5 * expected).max(5e-13), "{parameters}: {name} is off by {off:e}");
        }
        let near_singular = summary["warnings"].to_string().contains("rounding errors kept constraint `slot` open");
        assert_eq!(near_singular, parameters.contains("O2A=0.299997"), "{parameters}: {}", summary["warnings"]);
        let trajectory = run.trajectory();
        let position = (2.5 * expected).max(5e-13);
        // Rates of up to 100 rad/s; springs and masses of up to 1e9 turn an error of position into one of force.
        let outputs = [
            ("x6", position),
            ("x6_dot", 1e3 * position),
            ("x6_ddot", 1e6 * position),
            ("N3", 1e9 * position),
            ("N6", 1e9 * position),
        ];
        for (name, allowed) in outputs {
            let (got, exact) = (trajectory.number(trajectory.last(), name), cases.number(row, name));
            near(&format!("{parameters}: {name}"), got, exact, allowed);
        }
    }
}

#[test]
fn rates_that_the_constraints_cannot_meet_are_refused() {
    let mechanism = mechanism("quick-return", &[]);
    let mut start = Start::new(&*mechanism);
    assemble_from_guesses(&*mechanism, &start).expect("the scene's own start");
    // The rocker follows the crank: it cannot stand still.
    start.given_rates.fill(true);
    start.qd[1..].fill(0.0);
    let refused = assemble_from_guesses(&*mechanism, &start).expect_err("contradicting rates");
    assert!(refused.rates && refused.residual > 0.1 && refused.residual.is_finite(), "{refused:?}");
    assert_eq!(mechanism.description().constraints[refused.constraint].name, "slot");
}
