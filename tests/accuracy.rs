//! Tests of error estimates and of what is said about errors, against exact values.

use std::io;

use qrm_core::Mechanism;
use qrm_sim::analysis::{EnergyIntegral, PANELS};
use qrm_sim::integrate::{MethodSettings, RK4, method_named};
use qrm_sim::run::{End, Observer, Request, Row, simulate};
use qrm_sim::solve::Projection;

use crate::common::{Table, mechanism, near, qrm};

/// Keeps times and coordinates.
#[derive(Default)]
struct Rows(Vec<(f64, Vec<f64>)>);

impl Observer for Rows {
    fn row(&mut self, row: &Row) -> io::Result<()> {
        self.0.push((row.t, row.q.to_vec()));
        Ok(())
    }
}

/// The largest error of a coordinate in any row, and what the run says it is.
fn errors(mechanism: &dyn Mechanism, integral: &EnergyIntegral, settings: MethodSettings, step: f64) -> (f64, f64) {
    let request =
        Request { settings, step: Some(step), end: Some(End::Time(1.6)), estimate_error: true, ..Request::default() };
    let mut rows = Rows::default();
    let outcome = simulate(mechanism, &request, &mut rows).expect("the run starts");
    let error = |(t, q): &(f64, Vec<f64>)| {
        let (exact, _) = integral.state(*t).expect("within the time");
        q.iter().zip(exact).map(|(q, exact)| (q - exact).abs()).fold(0.0, f64::max)
    };
    (rows.0.iter().map(error).fold(0.0, f64::max), outcome.estimated_error().expect("an estimate"))
}

#[test]
#[ignore = "full tier: compiled"]
fn estimated_errors_are_right_within_a_factor_of_three() {
    let mechanism = mechanism("quick-return", &[]);
    let integral = EnergyIntegral::new(&*mechanism, 1.7, PANELS[0]).expect("a conservative mechanism that turns");
    let projections = [Projection::None, Projection::Euclidean, Projection::Mass];
    let fixed = projections.into_iter().flat_map(|projection| {
        let settings = MethodSettings { method: RK4, projection, ..MethodSettings::default() };
        [8e-3, 4e-3, 2e-3, 1e-3, 5e-4, 2.5e-4, 1.25e-4].map(|step| (settings, step))
    });
    let adaptive = (4..=12).flat_map(|k| {
        let tolerance = 10.0_f64.powi(-k);
        ["dopri5", "dop853"].map(|name| (MethodSettings::new(method_named(name).expect("a method"), tolerance), 1e-2))
    });
    for (settings, step) in fixed.chain(adaptive) {
        let (error, estimate) = errors(&*mechanism, &integral, settings, step);
        // Below this rounding errors rule, and no run can tell them from another's.
        let ratio = estimate / error.max(3e-13);
        let what = format!("{settings:?} at {step}: estimated {estimate:e}, true {error:e}");
        assert!((1.0 / 3.0..=3.0).contains(&ratio) || error < 3e-13 && estimate < 1e-12, "{what}");
    }
}

/// `accuracy.csv` of a run of the command, and what it printed.
fn measured(arguments: &[&str]) -> (Table, String) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let output = qrm(&["accuracy"]).args(arguments).arg("--out").arg(folder.path()).output().expect("it starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(folder.path().join("accuracy.svg").exists());
    let table = Table::read(&folder.path().join("accuracy.csv"));
    (table, String::from_utf8(output.stdout).expect("text"))
}

#[test]
fn errors_of_rk4_follow_theory() {
    let (table, said) = measured(&["--at", "0.5"]);
    let rows = |method: &str| -> Vec<usize> {
        (0..table.rows.len()).filter(|&row| table.text(row, "method") == method).collect()
    };
    let euclidean = rows("rk4, Euclidean");
    let at_1e3 =
        euclidean.iter().find(|&&row| (table.number(row, "step") - 1e-3).abs() < 1e-9).expect("a step of 1e-3");
    near("error at h = 1e-3", table.number(*at_1e3, "error_position"), 3.0e-12, 0.3 * 3.0e-12);
    let error = |row: &usize| table.text(*row, "error_position").trim_start_matches('<').parse().expect("a number");
    let floor = euclidean.iter().map(error).fold(f64::INFINITY, f64::min);
    assert!(floor < 3e-13, "{floor:e}");
    for method in ["rk4, no projection", "rk4, Euclidean", "rk4, mass metric"] {
        let line = said.lines().find(|line| line.trim_start().starts_with(method)).expect("the method is listed");
        let order: f64 = line.split_once("of order ").expect("its order").1.trim().parse().expect("a number");
        near(&format!("order of {method}"), order, 4.0, 0.1);
    }
    assert!(said.contains("the energy integral"), "{said}");
    // Projected positions are closed to rounding errors.
    assert!(rows("dop853, mass metric").iter().all(|&row| table.number(row, "residual_position") < 1e-15));
}

#[test]
#[ignore = "full tier: compiled"]
fn a_scene_without_energy_integral_is_measured_against_a_run() {
    let (table, said) = measured(&["quick-return-loaded", "--set", "cd=50", "--at", "0.3", "--at", "0.1"]);
    assert!(said.contains("against extrapolation in double-double numbers at a tolerance of 1e-22"), "{said}");
    assert!(said.contains("errors at t = 0.100000, 0.300000 s"), "{said}");
    let last = table.last();
    assert!(table.number(last, "uncertainty_position") < 1e-13, "{said}");
    let error = |row| table.text(row, "error_position").trim_start_matches('<').parse::<f64>().expect("a number");
    assert!((0..=last).all(|row| error(row) < 1e-2), "{said}");
}

#[test]
#[ignore = "full tier: compiled"]
fn methods_are_judged_by_the_column_that_is_asked_for() {
    let (table, said) = measured(&["--of", "N3", "--at", "0.5"]);
    let row = |method: &str, tolerance: f64| {
        let is_it =
            |&row: &usize| table.text(row, "method").starts_with(method) && table.number(row, "tolerance") == tolerance;
        (0..table.rows.len()).filter(|&row| !table.text(row, "tolerance").is_empty()).find(is_it).expect("measured")
    };
    // N3 is one of the reactions: their error is not smaller.
    let error = |column: &str| table.number(row("dopri5", 1e-6), column);
    assert!(
        error("error_of_column") <= error("error_force") && error("error_of_column") > 1e3 * error("error_position")
    );
    near("its estimate", error("estimated_error"), error("error_of_column"), 5.0 * error("error_of_column"));
    assert!(
        said.contains("(N3 is uncertain by ") && said.contains("Cheapest for an error of N3 of at most\n"),
        "{said}"
    );
    // Of a force of some kN, errors are asked for in N.
    assert!(said.contains("\n    1e-1  ") && said.contains("\n    1e-7  "), "{said}");
    let output = qrm(&["accuracy", "--of", "N33"]).output().expect("it starts");
    let error = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.code() == Some(2) && error.contains("did you mean `N3`?"), "{error}");
}

#[test]
#[ignore = "full tier: compiled"]
fn references_agree_with_each_other() {
    // Three ways to the exact values, none of which knows the others: errors of a coarse run must come out the same.
    let error = |reference: &str| {
        // The scene's values are at 0.5 s too.
        let at: &[&str] = if reference == "scene" { &[] } else { &["--at", "0.5"] };
        let (table, said) = measured(&[at, &["--reference", reference]].concat());
        let row = (0..table.rows.len()).find(|&row| table.text(row, "method") == "rk4, mass metric");
        assert!(said.contains("uncertain by"), "{said}");
        ["error_position", "error_rate", "error_force"]
            .map(|column| table.number(row.expect("rk4 is measured"), column))
    };
    let [energy, scene, run] = ["energy", "scene", "run"].map(error);
    for (i, expected) in energy.into_iter().enumerate() {
        near("against the scene's values", scene[i], expected, 1e-5 * expected);
        near("against a run", run[i], expected, 1e-5 * expected);
    }
}

#[test]
fn what_is_below_the_uncertainty_is_no_number() {
    let (table, said) = measured(&["--at", "0.01"]);
    let errors = || (0..table.rows.len()).map(|row| table.text(row, "error_position"));
    let floor = table.text(0, "uncertainty_position").to_owned();
    assert!(errors().any(|error| error == format!("<{floor}")), "{said}");
    assert!(
        errors().filter_map(|error| error.parse::<f64>().ok()).all(|error| error > floor.parse().expect("a number"))
    );
    assert!(said.contains(&format!(" <{:.0e} ", floor.parse::<f64>().expect("a number"))), "{said}");
}

#[test]
fn methods_are_refused_what_they_do_not_take() {
    for (arguments, said) in [
        (&["run", "--tolerance", "1e-6"][..], "`--tolerance` needs a method that chooses its steps"),
        (&["run", "--method", "dop853", "--tolerance", "0"], "`--tolerance` must be above zero"),
        (&["run", "--max-step", "0.1"], "`--max-step` needs a method that chooses its steps"),
        (&["run", "--method", "dop853", "--max-step", "-1"], "`--max-step` must be above zero"),
        (&["accuracy", "--budget", "soon"], "`--budget` needs a number"),
        (&["accuracy", "--at", "-1"], "`--at` must be above zero"),
        (&["accuracy", "--set", "O2A=0.21", "--reference", "scene"], "no values in [reference] that hold"),
        (&["accuracy", "--at", "0.3", "--reference", "scene"], "hold at their own times"),
        (&["accuracy", "--set", "w0=3", "--reference", "energy"], "the motion turns back"),
        (&["accuracy", "quick-return-loaded", "--set", "cd=5", "--reference", "energy"], "some load has no potential"),
    ] {
        let output = qrm(arguments).output().expect("the command starts");
        let error = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {error}");
        assert!(error.contains(said), "{arguments:?}: {error}");
    }
}
