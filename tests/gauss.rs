//! The Gauss method against exact ends, other methods and itself.

use std::path::Path;

use qrm_core::{Convergence, GaussEnd, GaussRequest, Mechanism, Model, StateRef, Width};
use qrm_sim::integrate::{DOP853, GAUSS, MethodSettings};
use qrm_sim::position::{Start, assemble};
use qrm_sim::run::{End, Observer, Outcome, Request, Row, simulate};

fn model(name: &str) -> &'static Model {
    qrm_model::MODELS.iter().find(|model| model.description.name == name).expect("a scene of the repository")
}

fn mechanism(name: &str) -> Box<dyn Mechanism> {
    model(name).mechanism(&|_| None)
}

/// Scene, end time and coordinates there, from the table that the benchmarks of other programs use.
fn exact_ends() -> Vec<(String, f64, Vec<f64>)> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/peers/exact.csv");
    let mut ends: Vec<(String, f64, Vec<f64>)> = Vec::new();
    for record in csv::Reader::from_path(path).expect("the table").records() {
        let record = record.expect("a row");
        if ends.last().is_none_or(|(name, ..)| *name != record[0]) {
            let numbers = record[3].split_whitespace().map(|number| number.parse().expect("a number"));
            ends.push((record[0].to_owned(), record[1].parse().expect("a time"), numbers.collect()));
        }
    }
    ends
}

fn run(name: &str, settings: MethodSettings, step: Option<f64>, end: Option<End>, rows: &mut dyn Observer) -> Outcome {
    let request = Request { settings, step, end, ..Request::default() };
    let outcome = simulate(&*mechanism(name), &request, rows).expect("a start");
    assert!(outcome.status.is_done(), "{name}: {outcome:?}");
    outcome
}

fn apart(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

fn has_vectors() -> bool {
    mechanism("pendulum").gauss_steps(Width::Four).is_some()
}

#[test]
fn errors_at_the_end_are_those_asked_for() {
    let ends = exact_ends();
    assert_eq!(ends.len(), 6);
    for (name, end_time, exact) in ends {
        for tolerance in [1e-6, 1e-8, 1e-10, 1e-12] {
            let end = Some(End::Time(end_time));
            let outcome = run(&name, MethodSettings::new(GAUSS, tolerance), Some(end_time), end, &mut ());
            let error = apart(&outcome.q, &exact);
            assert!(error < 4.0 * tolerance, "{name}: {error:e} for {tolerance:e}");
            let (replaced, steps) = (outcome.counts.fallback, outcome.counts.accepted);
            // A position may not suit the kernel.
            let is_expected = if has_vectors() { replaced <= steps / 50 } else { replaced == steps };
            assert!(is_expected, "{name} for {tolerance:e}: {replaced} of {steps}");
        }
    }
}

#[test]
fn small_motions_are_as_accurate_as_large_ones() {
    for start in [1e-2, 1e-4, 1e-6] {
        let mechanism = model("double-pendulum").mechanism(&|name| (name == "a0").then_some(start));
        let end = |method, tolerance| {
            let settings = MethodSettings::new(method, tolerance);
            let request = Request { settings, step: Some(10.0), end: Some(End::Time(10.0)), ..Request::default() };
            simulate(&*mechanism, &request, &mut ()).expect("a start").q
        };
        let exact = end(DOP853, 1e-15);
        for tolerance in [1e-8, 1e-10, 1e-12] {
            let error = apart(&end(GAUSS, tolerance), &exact);
            assert!(error < 4.0 * tolerance, "{start:e} rad: {error:e} for {tolerance:e}");
        }
    }
}

/// Coordinates, rates and accelerations of every row.
#[derive(Default)]
struct Rows(Vec<Vec<f64>>);

impl Observer for Rows {
    fn row(&mut self, row: &Row) -> std::io::Result<()> {
        self.0.push([&[row.t], row.q, row.qd, row.qdd].concat());
        Ok(())
    }
}

#[test]
fn rows_inside_steps_are_as_accurate_as_their_ends() {
    for (name, allowed) in [("quick-return", 1e-8), ("andrews", 1e-4), ("quick-return-driven", 1e-8)] {
        let rows = |settings| {
            let mut rows = Rows::default();
            let outcome = run(name, settings, None, None, &mut rows);
            (rows.0, outcome)
        };
        let (exact, _) = rows(MethodSettings::new(DOP853, 1e-13));
        let (found, outcome) = rows(MethodSettings::new(GAUSS, 1e-11));
        assert!(found.len() as u64 > 10 * outcome.counts.accepted && found.len() == exact.len());
        let n = (found[0].len() - 1) / 3;
        for (found, exact) in found.iter().zip(&exact) {
            let [of_q, of_rest] = [1..n + 1, n + 1..3 * n + 1].map(|part| apart(&found[part.clone()], &exact[part]));
            assert!(of_q < 1e-10 && of_rest < allowed, "{name} at {}: {of_q:e}, {of_rest:e}", found[0]);
        }
    }
}

#[test]
fn conditions_end_a_run_where_other_methods_say() {
    let end = |method, tolerance| run("quick-return", MethodSettings::new(method, tolerance), None, None, &mut ());
    let (exact, found) = (end(DOP853, 1e-13), end(GAUSS, 1e-10));
    assert!((exact.end_time - found.end_time).abs() < 1e-10, "{} {}", exact.end_time, found.end_time);
    assert!(apart(&exact.q, &found.q) < 1e-10);
}

#[test]
fn the_work_of_a_drive_is_integrated_by_the_nodes() {
    let mechanism = mechanism("quick-return-driven");
    let end = mechanism.schedule().end_time;
    let settings = MethodSettings::new(GAUSS, 1e-11);
    let request = Request { settings, step: Some(end), end: Some(End::Time(end)), ..Request::default() };
    let outcome = simulate(&*mechanism, &request, &mut ()).expect("a start");
    let off = outcome.energy_imbalance / outcome.largest_energy;
    assert!(outcome.energy_drift.is_none() && off < 1e-11, "{off:e}, {outcome:?}");
}

#[test]
fn vectors_of_four_and_eight_make_the_same_steps() {
    for name in ["quick-return", "andrews", "double-pendulum"] {
        let mechanism = mechanism(name);
        let (q, qd) = assemble(&*mechanism, Start::new(&*mechanism)).expect("a start");
        let (mut qdd, mut multipliers) = (q.clone(), vec![0.0; mechanism.description().constraints.len()]);
        assert!(mechanism.accelerations(0.0, &q, &qd, &mut qdd, &mut multipliers));
        let from = StateRef { t: 0.0, q: &q, qd: &qd, qdd: &qdd, multipliers: &multipliers };
        let step = |width| {
            let mut steps = mechanism.gauss_steps(width)?;
            let (mut q, mut qd) = (q.clone(), qd.clone());
            let mut extrapolated = [vec![0.0; q.len()], vec![0.0; q.len()]];
            let request = GaussRequest { h: mechanism.schedule().step, tolerance: 1e-13, is_within_last_step: false };
            let mut step = |request: &GaussRequest| {
                let extrapolated = extrapolated.each_mut().map(|values| &mut values[..]);
                steps.step(request, &from, GaussEnd { q: &mut q, qd: &mut qd, extrapolated })
            };
            let whole = step(&request)?;
            assert!(whole.convergence == Convergence::Converged && whole.error < 1.0, "{name}: {whole:?}");
            let half = GaussRequest { h: 0.5 * request.h, is_within_last_step: true, ..request };
            let inside = step(&half)?;
            assert!(
                inside.convergence == Convergence::Converged && inside.iterations < whole.iterations,
                "{name}: {inside:?} {whole:?}"
            );
            // The accelerations at the beginning are those of the state there.
            assert!(apart(&extrapolated[0], &qdd) < 1e-6, "{name}: {extrapolated:?} {qdd:?}");
            Some([q, qd, extrapolated.concat()].concat())
        };
        if let (Some(four), Some(eight)) = (step(Width::Four), step(Width::Eight)) {
            assert!(apart(&four, &eight) < 1e-13, "{name}: {four:?} {eight:?}");
        }
    }
}
