//! Estimated errors of all columns, against references in double-double numbers.

use std::collections::BTreeMap;
use std::fs;
use std::io;
use std::path::PathBuf;

use qrm_core::{Mechanism, Model};
use qrm_sim::analysis::{ReferenceState, StateAt, reference_states};
use qrm_sim::columns::{Kind, columns, numbers};
use qrm_sim::integrate::{METHODS, Method, MethodSettings};
use qrm_sim::run::{End, ErrorEstimates, Extremes, Observer, Request, Row, simulate};
use qrm_sim::state::State;

use crate::common;
use crate::common::derived;

/// Rows by which errors are known, in the longest steps; fewer where a reference would take too long.
const ROWS: [usize; 3] = [150, 37, 9];
/// Lengths of steps against those of the scene.
const STEPS: [f64; 6] = [2.0, 1.0, 0.5, 0.25, 0.125, 0.0625];
/// Tolerances of methods that choose their steps.
const TOLERANCES: [f64; 6] = [1e-4, 1e-6, 1e-8, 1e-10, 1e-11, 1e-12];
/// Errors that are this small against columns of the same kind are rounding errors, which the reference has too.
const ROUNDING: f64 = 3e-14;
/// The largest part of a column that an error may be unnoticed.
const UNNOTICED: f64 = 2e-12;

/// The numbers of rows.
type Numbers = Vec<Vec<f64>>;

/// Keeps rows.
#[derive(Default)]
struct Rows(Numbers);

impl Observer for Rows {
    fn row(&mut self, row: &Row) -> io::Result<()> {
        self.0.push(row.columns.to_vec());
        Ok(())
    }
}

/// The rows of a run with its estimates; `None` if it does not trust itself.
fn run(
    mechanism: &dyn Mechanism,
    settings: MethodSettings,
    [step, end]: [f64; 2],
) -> Option<(Numbers, ErrorEstimates)> {
    let end = Some(End::Time(end));
    let request = Request { settings, step: Some(step), end, estimate_error: true, ..Request::default() };
    let mut rows = Rows::default();
    let outcome = simulate(mechanism, &request, &mut rows).ok()?;
    let is_trusted = outcome.status.is_done() && outcome.rejection_reasons(mechanism.description()).is_empty();
    if is_trusted { Some((rows.0, outcome.errors?)) } else { None }
}

/// The rows of the reference at some times.
fn reference(model: &Model, mechanism: &dyn Mechanism, times: &[f64]) -> Option<Numbers> {
    let states = reference_states(model, &|_| None, times, 1e-20).ok()?;
    let rows = states.into_iter().map(|ReferenceState { rounded, .. }| {
        let StateAt { t, q, qd, qdd, multipliers, .. } = rounded;
        numbers(mechanism, &State { t, q, qd, qdd, multipliers, corrections: 0 })
    });
    Some(rows.collect())
}

/// The scenes that are not compiled.
fn others() -> Vec<Model> {
    let scenes = ["scenes/linkages", "scenes/recipes"].map(|folder| fs::read_dir(folder).expect("scenes"));
    let mut paths: Vec<PathBuf> = scenes.into_iter().flatten().map(|entry| entry.expect("a scene").path()).collect();
    paths.sort();
    paths.iter().map(|path| derived(path)).collect()
}

/// Whether quantities are computed from each other.
fn is_same_kind(a: Kind, b: Kind) -> bool {
    a == b || !matches!(a, Kind::Output(_)) && std::mem::discriminant(&a) == std::mem::discriminant(&b)
}

fn name_of(kind: Kind) -> &'static str {
    match kind {
        Kind::Coordinate(_) => "coordinate",
        Kind::Rate(_) => "rate",
        Kind::Acceleration(_) => "acceleration",
        Kind::Multiplier(_) => "multiplier",
        Kind::Output(_) => "output",
        _ => "energy",
    }
}

/// True errors against estimates, by method and kind, with what they are.
#[derive(Default)]
struct Ratios(BTreeMap<(&'static str, &'static str), Vec<(f64, String)>>);

impl Ratios {
    /// Compares all columns of a run with the reference, whose rows are every so many of the run.
    fn add(
        &mut self,
        model: &Model,
        method: &Method,
        (rows, estimates): &(Numbers, ErrorEstimates),
        every: usize,
        exact: &Numbers,
    ) {
        let columns = columns(model.description);
        for (place, column) in columns.iter().enumerate() {
            let Some(estimate) = estimates.column(column.kind) else { continue };
            let alike: Vec<usize> =
                (0..columns.len()).filter(|&i| is_same_kind(columns[i].kind, column.kind)).collect();
            let size = exact.iter().flat_map(|row| alike.iter().map(|&i| row[i].abs())).fold(0.0, f64::max);
            let differences =
                rows.iter().step_by(every).zip(exact).map(|(own, exact)| (own[place] - exact[place]).abs());
            let error = differences.fold(0.0, f64::max);
            let noise = ROUNDING * size;
            let mut ratio = error.max(noise) / estimate.largest.max(noise);
            if error < UNNOTICED * size {
                ratio = ratio.min(9.0);
            }
            // What is zero everywhere has no error.
            if ratio.is_finite() {
                let (scene, estimated) = (model.description.name, estimate.largest);
                let what = format!("{} of {scene}: true {error:.1e}, estimated {estimated:.1e}", column.name);
                self.0.entry((method.name, name_of(column.kind))).or_default().push((ratio, what));
            }
        }
    }
}

impl Ratios {
    /// Compares extremes with those of a reference that knows its errors.
    fn add_extremes(
        &mut self,
        model: &Model,
        method: &Method,
        (own, estimates): &(Vec<Extremes>, ErrorEstimates),
        (exact, known): &(&Vec<Extremes>, &ErrorEstimates),
    ) {
        let columns = columns(model.description);
        for ((column, own), exact) in columns.iter().zip(own).zip(*exact) {
            let errors = estimates.extremes(column.kind, own).zip(known.extremes(column.kind, exact));
            let Some((estimated, known)) = errors else { continue };
            let size = exact.minimum.0.abs().max(exact.maximum.0.abs());
            let pairs = [(own.minimum.0, exact.minimum.0), (own.maximum.0, exact.maximum.0)];
            for ((own, exact), (estimated, known)) in pairs.into_iter().zip(estimated.into_iter().zip(known)) {
                let noise = (1e-12 * size).max(3.0 * known);
                let ratio = (own - exact).abs().max(noise) / estimated.max(noise);
                if ratio.is_finite() {
                    let what =
                        format!("{} of {} by {}: {own} for {exact}", column.name, model.description.name, method.name);
                    self.0.entry((method.name, name_of(column.kind))).or_default().push((ratio, what));
                }
            }
        }
    }

    /// Prints how true errors are against estimates, and the worst of them (with `--nocapture`). This part of the
    /// estimates holds within a factor of 3. Returns the part of the errors that are beyond 10 times their estimate.
    fn report(&self, good: f64) -> f64 {
        for ((method, kind), list) in &self.0 {
            println!(
                "{method:8} {kind:13} {:5}: {:.1} % within a factor of 3",
                list.len(),
                100.0 * within(list.iter())
            );
        }
        let mut all: Vec<&(f64, String)> = self.0.values().flatten().collect();
        all.sort_by(|a, b| b.0.total_cmp(&a.0));
        for (ratio, what) in [&all[..10], &all[all.len() - 10..]].concat() {
            println!("{ratio:.1e}  {what}");
        }
        let part = within(all.iter().copied());
        println!("{}: {:.1} % within a factor of 3", all.len(), 100.0 * part);
        assert!(all.len() > 10_000 && part >= good, "{part} of {}", all.len());
        let silent = all.iter().filter(|(ratio, _)| *ratio > 10.0).count() as f64 / all.len() as f64;
        println!("beyond 10 times their estimate: {:.3} %", 100.0 * silent);
        silent
    }
}

fn within<'r>(ratios: impl Iterator<Item = &'r (f64, String)> + Clone) -> f64 {
    let good = ratios.clone().filter(|(ratio, _)| (1.0 / 3.0..=3.0).contains(ratio)).count();
    good as f64 / ratios.count() as f64
}

#[test]
#[ignore = "full tier: engine"]
fn estimates_hold_for_every_column() {
    let mut ratios = Ratios::default();
    for model in qrm_model::MODELS.iter().chain(&others()) {
        let mechanism = model.mechanism(&|_| None);
        let schedule = mechanism.schedule();
        let step = STEPS[0] * schedule.step;
        let most = (schedule.end_time / step) as usize;
        let times: Vec<f64> = (0..=most).map(|row| step * row as f64).collect();
        let found = ROWS.into_iter().find_map(|rows| reference(model, &*mechanism, &times[..=rows.min(most)]));
        let exact = found.unwrap_or_else(|| panic!("{} has no reference", model.description.name));
        let end = times[exact.len() - 1];
        for method in METHODS.iter().filter(|method| !method.needs_linearization || mechanism.has_linearization()) {
            for level in 0..STEPS.len() {
                let settings = MethodSettings::new(method, TOLERANCES[level]);
                let (step, every) =
                    if method.is_adaptive() { (step, 1) } else { (STEPS[level] * schedule.step, 1 << level) };
                if let Some(run) = run(&*mechanism, settings, [step, end]) {
                    ratios.add(model, method, &run, every, &exact);
                }
            }
        }
    }
    assert_eq!(ratios.report(0.95), 0.0);
}

/// Keeps the extremes of columns.
#[derive(Default)]
struct ExtremesOf(Vec<Extremes>);

impl Observer for ExtremesOf {
    fn row(&mut self, _: &Row) -> io::Result<()> {
        Ok(())
    }

    fn wants_extremes(&self) -> bool {
        true
    }

    fn extremes(&mut self, extremes: &[Extremes]) {
        self.0 = extremes.to_vec();
    }
}

#[test]
#[ignore = "full tier: engine"]
fn estimates_hold_for_extremes() {
    let dop853 = METHODS.iter().find(|method| method.name == "dop853").expect("a method");
    let mut ratios = Ratios::default();
    for model in qrm_model::MODELS.iter().chain(&others()) {
        let mechanism = model.mechanism(&|_| None);
        let schedule = mechanism.schedule();
        let step = STEPS[0] * schedule.step;
        let end = step * (ROWS[0] as f64).min((schedule.end_time / step).floor());
        let run = |method: &'static Method, tolerance: f64, step: f64| {
            let settings = MethodSettings::new(method, tolerance);
            let (step, end) = (Some(step), Some(End::Time(end)));
            let request = Request { settings, step, end, estimate_error: true, ..Request::default() };
            let mut extremes = ExtremesOf::default();
            let outcome = simulate(&*mechanism, &request, &mut extremes).ok()?;
            let is_trusted = outcome.status.is_done() && outcome.rejection_reasons(mechanism.description()).is_empty();
            if is_trusted { Some((extremes.0, outcome.errors?)) } else { None }
        };
        // Extremes of a reference take more rows than double-double numbers can be computed in.
        let Some((exact, known)) = run(dop853, 1e-13, step / 64.0) else {
            assert_eq!(model.description.name, "governor");
            continue;
        };
        for method in METHODS.iter().filter(|method| !method.needs_linearization || mechanism.has_linearization()) {
            for level in 0..STEPS.len() {
                let step = if method.is_adaptive() { step } else { STEPS[level] * schedule.step };
                if let Some(own) = run(method, TOLERANCES[level], step) {
                    ratios.add_extremes(model, method, &own, &(&exact, &known));
                }
            }
        }
    }
    let silent = ratios.report(0.95);
    assert!(silent < 0.001, "{silent}");
}

/// Two masses, held together so stiffly that steps by a tolerance pass over their oscillation.
const STIFF: &str = r#"
name = "two"
coordinates = [{ name = "x", unit = "m" }, { name = "y", unit = "m" }]
[points]
P = ['x', '0']
Q = ['y', '0']
[bodies]
b = { mass = '1', com = "P" }
c = { mass = '0.1', com = "Q" }
[loads]
s = { along = 'x', spring = '4' }
k = { along = 'y - x', spring = '1e6', damper = '1e3' }
f = { force = ['sin(7*t) + sin(3*t)', '0'], at = "Q" }
[initial]
given = { x = 0.2, x_dot = 0.1, y = 0.2, y_dot = 0.1 }
[outputs]
F = { value = '1e6*(y - x) + 1e3*(y_dot - x_dot)' }
[run]
step = 5e-2
end_time = 10
stiff = true
"#;

#[test]
#[ignore = "full tier: engine"]
fn extremes_between_rows_know_how_wrong_they_are() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("two.toml");
    fs::write(&path, STIFF).expect("a scene");
    let model = derived(&path);
    let mechanism = model.mechanism(&|_| None);
    let run = |name: &str, tolerance: f64| {
        let method = METHODS.iter().find(|method| method.name == name).expect("a method");
        let settings = MethodSettings::new(method, tolerance);
        let request = Request { settings, estimate_error: true, ..Request::default() };
        let mut extremes = ExtremesOf::default();
        let outcome = simulate(&*mechanism, &request, &mut extremes).expect("the run starts");
        (extremes.0, outcome.errors.expect("estimates"))
    };
    let (exact, _) = run("auto", 1e-12);
    let mut worst = 0.0_f64;
    for (method, tolerance) in [("gauss", 1e-5), ("rodas", 1e-5), ("auto", 1e-6), ("auto", 1e-7)] {
        let (own, estimates) = run(method, tolerance);
        for ((column, own), exact) in columns(model.description).iter().zip(&own).zip(&exact) {
            let Some(estimated) = estimates.extremes(column.kind, own) else { continue };
            let errors = [own.minimum.0 - exact.minimum.0, own.maximum.0 - exact.maximum.0];
            for (error, estimated) in errors.into_iter().zip(estimated) {
                // An extreme in the first row is exact.
                let ratio = error.abs() / estimated.max(1e-12 * (1.0 + own.maximum.0.abs()));
                assert!(ratio < 10.0, "{} by {method}: {error:e}, estimated {estimated:e}", column.name);
                worst = worst.max(error.abs());
            }
        }
    }
    assert!(worst > 1.0, "no method was wrong: {worst}");
}

#[test]
fn the_time_of_a_condition_has_its_error() {
    let mechanism = common::mechanism("quick-return", &[]);
    let end_time = |method: &str, tolerance: f64, step: Option<f64>| {
        let method = METHODS.iter().find(|other| other.name == method).expect("a method");
        let settings = MethodSettings::new(method, tolerance);
        let request = Request { settings, step, estimate_error: true, ..Request::default() };
        let outcome = simulate(&*mechanism, &request, &mut ()).expect("the run starts");
        (outcome.end_time, outcome.errors.and_then(|errors| errors.end_time()).expect("a condition ends the run"))
    };
    let (exact, _) = end_time("dop853", 1e-13, None);
    let steps = [8e-3, 4e-3, 2e-3, 1e-3, 5e-4].map(|step| ("rk4", 0.0, Some(step)));
    let tolerances = [1e-4, 1e-6, 1e-8].map(|tolerance| ("dop853", tolerance, None));
    for (method, tolerance, step) in steps.into_iter().chain(tolerances) {
        let (t, estimated) = end_time(method, tolerance, step);
        let ratio = (t - exact).abs() / estimated;
        assert!((1.0 / 3.0..=3.0).contains(&ratio), "{method} {tolerance} {step:?}: {ratio}, estimated {estimated:e}");
    }
}
