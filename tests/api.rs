//! Tests of `qrm_cli::api`, of which the Python package is made: what the command computes, without its files.

use std::cell::Cell;
use std::fs;

use qrm_cli::api::{LoadedScene, RunOptions, SensitivityOptions, SweepOptions, Values, interruptible};
use qrm_model::MODELS;
use qrm_sim::columns::state;

use crate::common::{qrm, run};

fn quick_return() -> LoadedScene {
    LoadedScene::load(MODELS, "quick-return").expect("a scene")
}

fn pair(name: &str, value: &str) -> (String, String) {
    (name.to_owned(), value.to_owned())
}

#[test]
fn a_run_has_the_rows_and_the_summary_of_the_command() {
    let expected = run(&["quick-return", "--set", "O2A=0.25", "--start", "phi2=0.5", "--every", "9", "--no-figures"]);
    let options =
        RunOptions { set: vec![pair("O2A", "1/4")], start: vec![pair("phi2", "0.5")], ..RunOptions::default() };
    let found = quick_return().run(&options, 9, true).expect("a run");
    assert!(found.problem.is_none() && found.warnings.is_empty());
    let text = fs::read_to_string(expected.path("trajectory.csv")).expect("rows");
    let mut lines = text.lines();
    let names: Vec<&str> = lines.next().expect("a header").split(',').collect();
    assert_eq!(names, found.columns.iter().map(|column| column.name.as_str()).collect::<Vec<_>>());
    let rows: Vec<f64> = lines.flat_map(|line| line.split(',')).map(|n| n.parse().expect("a number")).collect();
    assert_eq!(rows, found.values);
    let mut summary: serde_json::Value = serde_json::from_str(&found.summary).expect("JSON");
    let mut own = expected.summary();
    for summary in [&mut summary, &mut own] {
        summary["run_seconds"].take();
    }
    assert_eq!(summary, own);
}

#[test]
fn paired_designs_are_those_of_combinations() {
    let scene = quick_return();
    let vary = |o2a: &[f64], bc: &[f64]| vec![("O2A".to_owned(), o2a.to_vec()), ("BC".to_owned(), bc.to_vec())];
    let all = SweepOptions { vary: vary(&[0.2, 0.21], &[0.6, 0.1]), ..SweepOptions::default() };
    let some = SweepOptions { vary: vary(&[0.21, 0.2], &[0.6, 0.1]), is_paired: true, ..SweepOptions::default() };
    let [all, some] = [all, some].map(|options| scene.sweep(&options).expect("a table").columns);
    for ((column, all), (_, some)) in all.iter().zip(&some) {
        match (column.name.as_str(), all, some) {
            ("design", ..) => {}
            (_, Values::Whole(all), Values::Whole(some)) => assert_eq!([all[2], all[1]], some[..]),
            (_, Values::Text(all), Values::Text(some)) => assert_eq!([&all[2], &all[1]], [&some[0], &some[1]]),
            (name, Values::Number(all), Values::Number(some)) => {
                let bits = |numbers: &[f64]| numbers.iter().map(|number| number.to_bits()).collect::<Vec<_>>();
                assert_eq!(bits(&[all[2], all[1]]), bits(some), "{name}");
            }
            (name, ..) => panic!("{name} is of another kind"),
        }
    }
}

thread_local! {
    static CALLS: Cell<u32> = const { Cell::new(0) };
}

#[test]
fn work_ends_when_its_check_says_so() {
    fn third() -> bool {
        CALLS.set(CALLS.get() + 1);
        CALLS.get() >= 3
    }
    let options = RunOptions { end_time: Some("1e6".to_owned()), ..RunOptions::default() };
    let found = interruptible(third, || quick_return().run(&options, 1_000_000, false)).expect("a run");
    assert!(found.summary.contains(r#""status":"interrupted""#), "{}", found.summary);
    assert!(found.problem.is_some_and(|problem| problem.is_of_run()));
    CALLS.set(0);
    let values = (0..100_000).map(|i| 0.15 + 1e-6 * f64::from(i)).collect();
    let options = SweepOptions { vary: vec![("O2A".to_owned(), values)], ..SweepOptions::default() };
    let table = interruptible(third, || quick_return().sweep(&options)).expect("a table");
    let Values::Whole(designs) = &table.columns[0].1 else { panic!("no designs") };
    assert!(designs.len() < 100_000 && designs.iter().copied().eq(0..designs.len() as u64), "{}", designs.len());
    CALLS.set(0);
    let options = SensitivityOptions {
        run: RunOptions { end_time: Some("1e4".to_owned()), ..RunOptions::default() },
        ..SensitivityOptions::default()
    };
    let error = interruptible(third, || quick_return().sensitivity(&options)).expect_err("an interruption");
    assert!(error.to_string().contains("interrupted"), "{error}");
}

#[test]
fn a_mistake_in_a_scene_has_its_line_and_column() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("wrong.toml");
    let text = fs::read_to_string("scenes/quick-return.toml").expect("a scene").replace("BC*cos(phi5)", "BC*cos(ö)");
    fs::write(&path, &text).expect("written");
    let error = LoadedScene::load(MODELS, path.to_str().expect("a path")).expect_err("a mistake");
    let findings = error.findings();
    let [line, column] = findings[0].place.expect("a place");
    let rest: String = text.lines().nth(line - 1).expect("the line").chars().skip(column - 1).collect();
    assert!(rest.starts_with('ö'), "{line}:{column}: {error}");
    assert!(!error.is_of_run());
    // The command shows the same place.
    let shown = qrm(&["run", path.to_str().expect("a path")]).output().expect("the command starts");
    assert!(String::from_utf8_lossy(&shown.stderr).contains(&format!(":{line}:{column}")));
    // The value of an option is no scene.
    let options = RunOptions { set: vec![pair("O2A", "1 +")], ..RunOptions::default() };
    let error = quick_return().run(&options, 1, true).expect_err("no number");
    assert!(error.findings().is_empty() && error.to_string().contains("--set O2A"), "{error}");
}

#[test]
fn equations_are_those_of_the_rows() {
    let scene = LoadedScene::load(MODELS, "quick-return-loaded").expect("a scene");
    let options = RunOptions { end_time: Some("0.05".to_owned()), ..RunOptions::default() };
    let found = scene.run(&options, 10, false).expect("a run");
    for row in found.values.chunks_exact(found.columns.len()) {
        let at = state(scene.description(), row);
        let equations = scene.equations(&options, at.t, &at.q, &at.qd).expect("equations");
        let pairs =
            equations.accelerations.iter().zip(&at.qdd).chain(equations.multipliers.iter().zip(&at.multipliers));
        for (own, of_row) in pairs {
            assert!((own - of_row).abs() <= 1e-11 * of_row.abs().max(1.0), "{own} {of_row} at t = {}", at.t);
        }
    }
}
