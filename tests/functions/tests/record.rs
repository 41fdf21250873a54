//! The results of every scene stay what they were: runs by each method, designs in lanes, sensitivities,
//! motions whose parameters change, positions at rest.
//!
//! The record in `record/` says nothing about right or wrong; other tests do. It shows what a change of the code
//! changes that no accuracy test sees: numbers of steps, estimates, extremes between rows, statistics.
//!
//! `QRM_REFRESH=1 cargo test --release --package qrm-functions --test integration record` writes it anew: read the
//! difference before keeping it.

use std::fmt::{Debug, Write};
use std::io;
use std::path::PathBuf;
use std::time::Duration;

use qrm_core::{Model, ParameterOverrides, Schedule, Tape};
use qrm_scene::formula_tape::event_tape;
use qrm_scene::resolve::{read_condition, read_with};
use qrm_sim::analysis::{
    EnergyIntegral, SensitivityRequest, exact_states, reference_states, revolution, sensitivity, spectrum,
    static_equilibrium,
};
use qrm_sim::batch::{LaneCount, SweepRequest, sweep};
use qrm_sim::integrate::{METHODS, MethodSettings};
use qrm_sim::position::{Start, assemble};
use qrm_sim::run::{End, Extremes, Observer, Request, Row, Simulation, simulate};
use qrm_sim::solve::Projection;
use qrm_sim::state::State;

use crate::processor::has_lanes_of_eight;

const REFRESH: &str = "QRM_REFRESH=1 cargo test --release --package qrm-functions --test integration record";

/// Numbers are equal up to this part of the larger one: another order of additions, or another processor.
const RELATIVE: f64 = 1e-6;
/// Numbers below this are rounding errors.
const ROUNDING: f64 = 1e-11;

/// Steps of the scene in a run.
const STEPS: f64 = 400.0;
const TOLERANCE: f64 = 1e-7;

#[test]
fn results_are_those_on_record() {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("record");
    let mut changed = String::new();
    let models = qrm_model::MODELS.iter();
    let models = models.chain(qrm_functions::MODELS);
    for model in models {
        let name = model.description.name;
        if name == "rubbing" && !has_lanes_of_eight() {
            continue;
        }
        let found = record(model);
        let path = folder.join(format!("{name}.txt"));
        if std::env::var_os("QRM_REFRESH").is_some() {
            std::fs::create_dir_all(&folder).and_then(|()| std::fs::write(&path, &found)).expect("it can be written");
        }
        let before = std::fs::read_to_string(&path).unwrap_or_default();
        let (mut old, mut new) = (before.lines(), found.lines());
        loop {
            match (old.next(), new.next()) {
                (None, None) => break,
                (old, new) => {
                    let (old, new) = (old.unwrap_or_default(), new.unwrap_or_default());
                    if !is_same(old, new) {
                        writeln!(changed, "{name}\n- {old}\n+ {new}").expect("it is a string");
                    }
                }
            }
        }
    }
    assert!(changed.is_empty(), "other results than before; if that is meant: {REFRESH}\n{changed}");
}

/// Scenes with other parameters: near a singular position, through a change point, to where they lock, with a mass
/// matrix that is singular; and one for longer.
const HARD: [(&str, &[(&str, f64)]); 9] = [
    ("quick-return-loaded", &[("O2A", 0.295), ("BC", 1.2)]),
    ("quick-return-loaded", &[("O2A", 0.3099)]),
    ("quick-return-loaded", &[("BC", 0.7)]),
    ("quick-return-loaded", &[("J2", 0.0)]),
    ("quick-return", &[("O2A", 0.45)]),
    ("four-bar", &[("l3", 0.2302)]),
    ("shaper", &[("O2A", 0.29)]),
    ("slider-crank", &[("a", 0.97)]),
    ("pulse", &[]),
];

/// The results of a scene, one in a line.
fn record(model: &Model) -> String {
    let mut lines = String::new();
    runs(model, &|_| None, STEPS, &mut lines);
    for (_, parameters) in HARD.iter().filter(|(scene, _)| *scene == model.description.name) {
        writeln!(lines, "\n{parameters:?}").expect("it is a string");
        let replace = |name: &str| parameters.iter().find(|(other, _)| *other == name).map(|(_, value)| *value);
        runs(model, &replace, 4.0 * STEPS, &mut lines);
    }
    conditions(model, &mut lines);
    designs(model, &mut lines);
    derivatives(model, &mut lines);
    changes(model, &mut lines);
    positions(model, &mut lines);
    lines
}

/// Adds a line, its numbers to eight digits.
fn add(lines: &mut String, what: &str, value: &dyn Debug) {
    let text = format!("{value:?}");
    let digits = |c: char| c.is_ascii_alphanumeric() || ".+-_".contains(c);
    lines.push_str(what);
    lines.push_str(": ");
    let mut rest = &*text;
    while !rest.is_empty() {
        let between = rest.find(digits).unwrap_or(rest.len());
        lines.push_str(&rest[..between]);
        rest = &rest[between..];
        let end = rest.find(|c| !digits(c)).unwrap_or(rest.len());
        match rest[..end].parse::<f64>() {
            Ok(number) if rest[..end].contains(['.', 'e']) => write!(lines, "{number:.7e}").expect("it is a string"),
            _ => lines.push_str(&rest[..end]),
        }
        rest = &rest[end..];
    }
    lines.push('\n');
}

/// A value of each column, and the extremes of the outputs.
#[derive(Debug, Default)]
struct Rows {
    /// Rows after which the run is interrupted; no interruption if zero.
    most: u64,
    count: u64,
    sums: Vec<f64>,
    extremes: Vec<Extremes>,
}

impl Observer for Rows {
    fn row(&mut self, row: &Row) -> io::Result<()> {
        self.count += 1;
        self.sums.resize(row.qdd.len() + row.multipliers.len() + row.outputs.len(), 0.0);
        // Weights that differ from row to row, so that no two errors cancel.
        let weight = (0.1 * row.index as f64).cos();
        for (sum, value) in self.sums.iter_mut().zip(row.qdd.iter().chain(row.multipliers).chain(row.outputs)) {
            *sum += weight * value;
        }
        Ok(())
    }

    fn keep_running(&mut self, _t: f64, _end_time: f64) -> io::Result<bool> {
        Ok(self.most == 0 || self.count < self.most)
    }

    fn wants_extremes(&self) -> bool {
        true
    }

    fn extremes(&mut self, extremes: &[Extremes]) {
        self.extremes = extremes.to_vec();
    }
}

/// The event of a condition on the names of a scene.
fn event(model: &Model, condition: &str) -> Tape {
    let (scene, _) = read_with("scene.toml", model.description.source, &|_| None).expect("a scene");
    event_tape(&scene, &read_condition(&scene, condition).expect("a condition"), model.named_tape())
}

fn runs(model: &Model, replace: ParameterOverrides, steps: f64, lines: &mut String) {
    let mechanism = model.mechanism(replace);
    let schedule = mechanism.schedule();
    let end = schedule.end_time.min(steps * schedule.step);
    let q = assemble(&*mechanism, Start::new(&*mechanism)).map(|(q, _)| q).unwrap_or_default();
    // Half of the way of the first coordinate.
    let (to, way) = middle(model, replace, steps);
    let first = model.description.coordinates[0].name;
    let passes = format!("{way:?}*({first} - ({to:?}))");
    let until = event(model, &format!("2*max(sign({passes}), 0) - 1 >= 0"));
    let passes = event(model, &format!("{passes} >= 0"));
    let mut one = |name: String, settings: MethodSettings, step: Option<f64>, end: End| {
        let mut rows = Rows::default();
        let request = Request { settings, step, end: Some(end), estimate_error: true, ..Request::default() };
        match simulate(&*mechanism, &request, &mut rows) {
            Ok(mut outcome) => {
                outcome.integration = Duration::ZERO;
                // Rounding chooses which residual is the largest.
                outcome.residual_position.0 = 0;
                outcome.residual_velocity.0 = 0;
                let rejection_reasons = outcome.rejection_reasons(model.description);
                add(lines, &name, &(outcome, rejection_reasons, rows.count, &rows.sums));
                add(lines, &format!("{name}, extremes"), &rows.extremes);
            }
            Err(reason) => add(lines, &name, &reason),
        }
    };
    for method in METHODS {
        let settings = MethodSettings::new(method, TOLERANCE);
        one(format!("run by {}", method.name), settings, None, End::Time(end));
        let to = if q.is_empty() { End::Time(end) } else { End::Event(&passes) };
        one(format!("run by {} to a condition", method.name), settings, None, to);
        if method.is_adaptive() {
            let long = Some(10.0 * schedule.step);
            one(format!("run by {} with few rows", method.name), settings, long, End::Time(0.77 * end));
        }
    }
    let mut rows = Rows { most: 1, ..Rows::default() };
    let request = Request { settings: MethodSettings::default(), estimate_error: true, ..Request::default() };
    let interrupted = simulate(&*mechanism, &request, &mut rows).map(|outcome| (outcome.status, outcome.end_time));
    let settings = MethodSettings { projection: Projection::Euclidean, ..MethodSettings::default() };
    one("run by rk4, euclidean".to_owned(), settings, Some(0.9 * schedule.step), End::Event(&until));
    add(lines, "interrupted", &(interrupted, rows.count));
}

/// The first coordinate at 0.6 of the end, and the direction in which it gets there.
fn middle(model: &Model, replace: ParameterOverrides, steps: f64) -> (f64, f64) {
    let mechanism = model.mechanism(replace);
    let schedule = mechanism.schedule();
    let end = 0.6037 * schedule.end_time.min(steps * schedule.step);
    let request = Request { end: Some(End::Time(end)), ..Request::default() };
    let to = simulate(&*mechanism, &request, &mut ()).map_or(0.0, |outcome| outcome.q[0]);
    let start = assemble(&*mechanism, Start::new(&*mechanism)).map_or(0.0, |(q, _)| q[0]);
    (to, (to - start).signum())
}

/// Ends by conditions that become true for less than a step, touch zero, are not numbers, or never become true.
fn conditions(model: &Model, lines: &mut String) {
    let mechanism = model.mechanism(&|_| None);
    let Schedule { step, end_time } = mechanism.schedule();
    let end = end_time.min(STEPS * step);
    let at = 0.4021 * end;
    let first = model.description.coordinates[0].name;
    let conditions = [
        format!("{:?} - abs(t - {at:?}) >= 0", 0.1 * step),
        format!("0.01 - ((t - {at:?})/{step:?})^2 >= 0"),
        format!("1e-6 - (1 - cos(t/{end:?} - 0.93))*(t - {at:?})/{end:?} >= 0"),
        format!("-1 - sqrt({at:?} - t) >= 0"),
        format!("-1 - (t - {at:?})^2 - {first}^2 >= 0"),
    ];
    let conditions = conditions.map(|condition| event(model, &condition));
    for method in METHODS {
        for (number, condition) in conditions.iter().enumerate() {
            for rows in [1.0, 7.0] {
                let settings = MethodSettings::new(method, TOLERANCE);
                let end = Some(End::Event(condition));
                let request = Request { settings, step: Some(rows * step), end, ..Request::default() };
                let found = simulate(&*mechanism, &request, &mut ());
                let found = found.map(|outcome| (outcome.status, outcome.end_time));
                add(lines, &format!("condition {number} by {}", method.name), &found);
            }
        }
    }
}

/// The parameters that are written as numbers.
fn numbers(model: &Model) -> impl DoubleEndedIterator<Item = (&'static str, f64)> {
    let parameters = model.description.parameters.iter();
    parameters.filter_map(|parameter| Some((parameter.name, parameter.formula.parse().ok()?)))
}

type Change = Box<dyn Fn(&str) -> Option<f64>>;

fn designs(model: &Model, lines: &mut String) {
    let schedule = model.mechanism(&|_| None).schedule();
    let end = schedule.end_time.min(STEPS * schedule.step);
    let Some((name, value)) = numbers(model).next() else { return };
    let replaces: Vec<Change> = (0..9)
        .map(|i| {
            let value = value * (1.0 + 0.01 * f64::from(i));
            Box::new(move |other: &str| (other == name).then_some(value)) as _
        })
        .collect();
    let replaces: Vec<ParameterOverrides> = replaces.iter().map(|replace| &**replace).collect();
    let (to, way) = middle(model, &|_| None, STEPS);
    let condition = event(model, &format!("{way:?}*({} - ({to:?})) >= 0", model.description.coordinates[0].name));
    for (lanes, count) in [(LaneCount::Most, 9), (LaneCount::Four, 2), (LaneCount::One, 1)] {
        for end in [End::Time(end), End::Event(&condition)] {
            let request = SweepRequest { end: Some(end), ..SweepRequest::default() };
            for result in sweep(model, &replaces[..count], &request, lanes) {
                add(lines, &format!("design, {lanes:?}"), &result);
            }
        }
    }
}

fn derivatives(model: &Model, lines: &mut String) {
    let schedule = model.mechanism(&|_| None).schedule();
    let end = schedule.end_time.min(0.5 * STEPS * schedule.step);
    let by: Vec<&str> = numbers(model).take(3).map(|(name, _)| name).collect();
    let (to, way) = middle(model, &|_| None, STEPS);
    let condition = event(model, &format!("({} - ({to:?}))*({way:?}) >= 0", model.description.coordinates[0].name));
    for (by, end) in [(&[][..], End::Time(end)), (&by, End::Time(end)), (&by, End::Event(&condition))] {
        let request = SensitivityRequest { by, end: Some(end), ..SensitivityRequest::default() };
        add(lines, "derivatives", &sensitivity(model, &|_| None, &request));
    }
}

/// A motion watched, with another parameter on the way.
fn changes(model: &Model, lines: &mut String) {
    let schedule = model.mechanism(&|_| None).schedule();
    let end = schedule.end_time.min(0.5 * STEPS * schedule.step);
    // With long steps and loose tolerances the estimates are reasons for rejection_reasons, and can be read.
    let all = METHODS.into_iter().flat_map(|method| [(method, 1.0, TOLERANCE), (method, 25.0, 1e-3)]);
    for (method, longer, tolerance) in all {
        let settings = MethodSettings::new(method, tolerance);
        let begun =
            Simulation::new(model, &|_| None, settings, Some(longer * schedule.step)).and_then(Simulation::watched);
        let Ok(mut simulation) = begun else {
            add(lines, "no motion", &begun.err().map(|error| error.reason));
            continue;
        };
        // The nearest time before that counts as the same.
        assert!(simulation.clone().advance(-1e-9 * longer * schedule.step).is_ok());
        for part in [0.31, 0.62, 1.0] {
            let result = simulation.advance(part * end).cloned();
            add(lines, &format!("motion by {}", method.name), &result);
            add(lines, "watched", &(simulation.rejection_reasons(), simulation.outputs(), simulation.residuals()));
            let last = numbers(model).next_back();
            let change = |name: &str| last.filter(|last| last.0 == name).map(|last| last.1 * (1.0 + 0.1 * part));
            let nowhere =
                [0.5 * part * end, f64::NAN, 1e30].map(|t| simulation.advance(t).err().map(|error| error.reason));
            add(lines, "no such time", &nowhere);
            if let Err(reason) = simulation.replace(&change) {
                add(lines, "not replaced", &reason.reason);
            }
        }
        let State { t, q, qd, .. } = simulation.now().clone();
        if let Err(reason) = simulation.place(2.0 * t, &q, &qd) {
            add(lines, "not placed", &reason.reason);
        }
        let placed = simulation.advance_trusted(2.0 * t + 0.1 * end).map_err(|error| error.reason);
        add(lines, "placed", &placed);
    }
}

fn positions(model: &Model, lines: &mut String) {
    let mechanism = model.mechanism(&|_| None);
    if let Ok((q, qd)) = assemble(&*mechanism, Start::new(&*mechanism)) {
        add(lines, "spectrum", &spectrum(&*mechanism, 0.0, &q, &qd));
    }
    let start = Start::new(&*mechanism);
    if let Some(first) = start.given.iter().position(|given| *given) {
        for way in [0.0, 0.2, -0.7, 3.0, -20.0] {
            let wanted = [(first, start.q[first] + way)];
            add(lines, &format!("equilibrium {way} farther"), &static_equilibrium(&*mechanism, &wanted, &|_, _| 0.0));
        }
    }
    match revolution(&*mechanism, &|_, _| 0.0) {
        Ok(found) => {
            add(lines, "revolution", &(found.start, found.direction, found.range, found.change_points, found.returns));
            for series in found.outputs.iter().chain([&found.balance, &found.inertia]) {
                add(lines, "course", &(series, series.is_periodic()));
            }
        }
        Err(reason) => add(lines, "no revolution", &reason),
    }
    let until = 0.2 * mechanism.schedule().end_time;
    let times = [0.01, 0.02].map(|part| part * until);
    let references = reference_states(model, &|_| None, &times, 1e-18);
    add(
        lines,
        "reference",
        &references.map(|states| states.into_iter().map(|state| state.rounded).collect::<Vec<_>>()),
    );
    match EnergyIntegral::new(&*mechanism, until, 200.0) {
        Ok(integral) => add(lines, "energy integral", &(integral.state(0.5 * until), integral.state(1.5 * until))),
        Err(reason) => add(lines, "no energy integral", &reason),
    }
    add(lines, "exact", &exact_states(&*mechanism, &times, 50.0));
}

/// Whether two lines say the same, numbers up to rounding.
fn is_same(old: &str, new: &str) -> bool {
    let (old, new): (Vec<&str>, Vec<&str>) = (pieces(old), pieces(new));
    old.len() == new.len()
        && old.iter().zip(new).all(|(old, new)| {
            *old == new
                || match (old.parse::<f64>(), new.parse::<f64>()) {
                    (Ok(old), Ok(new)) => (old - new).abs() <= ROUNDING.max(RELATIVE * old.abs().max(new.abs())),
                    _ => false,
                }
        })
}

/// The numbers of a line and what stands between them.
fn pieces(line: &str) -> Vec<&str> {
    line.split([' ', ',', '(', ')', '[', ']', '{', '}']).filter(|piece| !piece.is_empty()).collect()
}
