//! Runs of every scene with random parameters, ends, methods, steps and tolerances: what a run says of its error holds.
//!
//! `QRM_RUNS=10000 QRM_SEED=1 cargo test --release --test random_runs -- --nocapture` makes more of them, others with
//! another seed, and prints what they are like.

use std::{fmt, io};

use fastrand::Rng;
use qrm_core::{Mechanism, Model, ParameterOverrides};
use qrm_sim::batch::{LaneCount, SweepRequest, sweep};
use qrm_sim::integrate::{DOP853, METHODS, MethodSettings, method_named};
use qrm_sim::run::{End, Observer, Outcome, Request, Row, StartError, Status, simulate};

/// How often an error may be larger than what is said of it.
const FACTOR: f64 = 3.0;
/// The tolerance of the runs that others are compared with.
const REFERENCE: f64 = 1e-13;

/// Keeps coordinates.
#[derive(Default)]
struct Rows(Vec<Vec<f64>>);

impl Observer for Rows {
    fn row(&mut self, row: &Row) -> io::Result<()> {
        self.0.push(row.q.to_vec());
        Ok(())
    }
}

/// A run to be made.
struct Case {
    scene: &'static str,
    parameters: Vec<(&'static str, f64)>,
    settings: MethodSettings,
    step: f64,
    end: f64,
}

impl fmt::Display for Case {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let Self { scene, parameters, settings, step, end } = self;
        write!(f, "run {scene} --method {} --step {step:e} --end-time {end}", settings.method.name)?;
        if let Some(tolerance) = settings.tolerance() {
            write!(f, " --tolerance {tolerance:e}")?;
        }
        parameters.iter().try_for_each(|(name, value)| write!(f, " --set {name}={value}"))
    }
}

impl Case {
    fn random(random: &mut Rng) -> Self {
        let models = qrm_model::MODELS;
        let model = models[random.usize(..models.len())];
        let own = model.mechanism(&|_| None);
        let spread = [0.01, 0.1, 0.5][random.usize(..3)];
        let names = model.description.parameters.iter().map(|parameter| parameter.name);
        let factor = |random: &mut Rng| (spread * (2.0 * random.f64() - 1.0)).exp();
        let mut parameters: Vec<_> = names.zip(own.parameters()).map(|(name, value)| (name, *value)).collect();
        parameters.retain(|_| random.bool());
        parameters.iter_mut().for_each(|(_, value)| *value *= factor(random));
        let methods: Vec<_> =
            METHODS.iter().filter(|method| !method.needs_linearization || own.has_linearization()).collect();
        let method = methods[random.usize(..methods.len())];
        let tolerance = 10.0_f64.powf(-3.0 - 9.0 * random.f64());
        let schedule = own.schedule();
        let step = schedule.step * 2.0_f64.powf(5.0 * random.f64() - 2.0);
        let end = schedule.end_time * random.f64().max(20.0 * step / schedule.end_time).min(1.0);
        Self { scene: model.description.name, parameters, settings: MethodSettings::new(method, tolerance), step, end }
    }

    fn mechanism(&self) -> Box<dyn Mechanism> {
        let replace = |name: &str| self.parameters.iter().find(|(other, _)| *other == name).map(|(_, value)| *value);
        model(self.scene).mechanism(&replace)
    }

    fn run(&self, settings: MethodSettings) -> Option<(Outcome, Vec<Vec<f64>>)> {
        let mut rows = Rows::default();
        let request = Request {
            settings,
            step: Some(self.step),
            end: Some(End::Time(self.end)),
            estimate_error: true,
            ..Request::default()
        };
        let outcome = simulate(&*self.mechanism(), &request, &mut rows).ok()?;
        Some((outcome, rows.0))
    }

    /// A copy of the case with other parameters.
    fn with(&self, parameters: &[(&'static str, f64)]) -> Self {
        Self { parameters: parameters.to_vec(), ..*self }
    }

    /// The end of a run that is as accurate as doubles are, its rows, and what it says of its own error.
    fn reference(&self) -> Option<(Outcome, Vec<Vec<f64>>, f64)> {
        let method = if self.mechanism().has_linearization() { "auto" } else { "dop853" };
        let (outcome, rows) = self.run(MethodSettings::new(method_named(method)?, REFERENCE))?;
        let known = outcome.estimated_error()?;
        outcome.status.is_done().then_some((outcome, rows, known))
    }

    /// The largest error of a coordinate in any row, and what the run says it is; `None` if the run is refused, or no
    /// other one is more accurate.
    fn errors(&self, counts: &mut Counts) -> Option<(f64, f64)> {
        let Some((outcome, rows)) = self.run(self.settings) else {
            counts.not_begun += 1;
            return None;
        };
        let description = model(self.scene).description;
        if !outcome.status.is_done() || !outcome.rejection_reasons(description).is_empty() {
            counts.refused += 1;
            return None;
        }
        let stated = outcome.estimated_error()?;
        let Some((_, exact_rows, known)) = self.reference() else {
            counts.unknown += 1;
            return None;
        };
        let error = rows.iter().zip(&exact_rows).map(|(a, b)| distance(a, b)).fold(0.0, f64::max);
        // Rounding errors are not told from others.
        let size = rows.iter().flatten().fold(1.0_f64, |size, q| size.max(q.abs()));
        let rounding = 1e-12 * size;
        if known > 0.3 * stated.max(rounding) && error > FACTOR * stated {
            counts.unknown += 1;
            return None;
        }
        counts.compared += 1;
        Some((error, stated.max(rounding)))
    }
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

#[derive(Debug, Default)]
struct Counts {
    not_begun: usize,
    refused: usize,
    unknown: usize,
    compared: usize,
}

fn model(scene: &str) -> &'static Model {
    qrm_model::MODELS.iter().find(|model| model.description.name == scene).expect("a scene")
}

fn number(variable: &str, otherwise: u64) -> u64 {
    std::env::var(variable).map_or(otherwise, |text| text.parse().expect("a number"))
}

/// The results of the runs of one thread.
#[derive(Default)]
struct Found {
    counts: Counts,
    ratios: Vec<f64>,
    wrong: Vec<(u64, String)>,
}

fn look(seed: u64, numbers: impl Iterator<Item = u64>) -> Found {
    let mut found = Found::default();
    for number in numbers {
        let case = Case::random(&mut Rng::with_seed(seed.wrapping_mul(1_000_003).wrapping_add(number)));
        let Some((error, stated)) = case.errors(&mut found.counts) else { continue };
        found.ratios.push(error / stated);
        if error > FACTOR * stated {
            found.wrong.push((number, format!("{number}: {error:.1e} instead of {stated:.1e}: {case}")));
        }
    }
    found
}

#[test]
#[ignore = "full tier: compiled"]
fn no_run_is_wrong_in_silence() {
    let (seed, runs) = (number("QRM_SEED", 1), number("QRM_RUNS", 100));
    let threads = std::thread::available_parallelism().map_or(1, usize::from) as u64;
    let all: Vec<Found> = std::thread::scope(|scope| {
        let begun: Vec<_> = (0..threads)
            .map(|thread| scope.spawn(move || look(seed, (thread..runs).step_by(threads as usize))))
            .collect();
        begun.into_iter().map(|thread| thread.join().expect("no panic")).collect()
    });
    let sum = |part: fn(&Counts) -> usize| all.iter().map(|found| part(&found.counts)).sum::<usize>();
    let counts = Counts {
        not_begun: sum(|counts| counts.not_begun),
        refused: sum(|counts| counts.refused),
        unknown: sum(|counts| counts.unknown),
        compared: sum(|counts| counts.compared),
    };
    let mut ratios: Vec<f64> = all.iter().flat_map(|found| &found.ratios).copied().collect();
    ratios.sort_by(f64::total_cmp);
    let at = |part: f64| ratios.get((part * ratios.len() as f64) as usize).copied().unwrap_or(0.0);
    println!("{counts:?}; true over stated: median {:.2}, 90 % {:.2}, 99 % {:.2}", at(0.5), at(0.9), at(0.99));
    assert!(counts.compared > counts.unknown, "{counts:?}");
    let mut wrong: Vec<_> = all.into_iter().flat_map(|found| found.wrong).collect();
    wrong.sort();
    let wrong: Vec<String> = wrong.into_iter().map(|(_, text)| text).collect();
    assert!(wrong.is_empty(), "{} of {runs}:\n{}", wrong.len(), wrong.join("\n"));
}

#[test]
#[ignore = "full tier: compiled"]
fn designs_in_lanes_are_what_runs_make_of_them() {
    let (seed, sweeps) = (number("QRM_SEED", 1), number("QRM_RUNS", 100).div_ceil(20));
    let mut done = 0;
    for number in 0..sweeps {
        let random = &mut Rng::with_seed(seed.wrapping_mul(2_000_003).wrapping_add(number));
        // Scene, step and end of the first case; parameters of twelve.
        let first = Case::random(random);
        let model = model(first.scene);
        let others = (0..12).map(|_| {
            loop {
                let case = Case::random(random);
                if case.scene == first.scene {
                    return case.parameters;
                }
            }
        });
        let parameters: Vec<Vec<(&'static str, f64)>> = others.collect();
        let replace = |parameters: &[(&str, f64)], name: &str| {
            parameters.iter().find(|(other, _)| *other == name).map(|(_, value)| *value)
        };
        let replacements: Vec<_> = parameters.iter().map(|p| move |name: &str| replace(p, name)).collect();
        let designs: Vec<ParameterOverrides> =
            replacements.iter().map(|replace| replace as ParameterOverrides).collect();
        let settings = MethodSettings::new(DOP853, 10.0_f64.powf(-4.0 - 8.0 * random.f64()));
        let end = Some(End::Time(first.end));
        let request = SweepRequest { settings, step: Some(first.step), end, ..SweepRequest::default() };
        let in_lanes = sweep(model, &designs, &request, LaneCount::Most);
        let alone = sweep(model, &designs, &request, LaneCount::One);
        for ((lanes, alone), parameters) in in_lanes.iter().zip(&alone).zip(&parameters) {
            let case = format!("{} by {:e} to {} {parameters:?}", first.scene, settings.tolerance, first.end);
            let ended = |status: &Result<Status, StartError>| status.as_ref().map(Status::is_done).ok();
            assert_eq!(ended(&lanes.status), ended(&alone.status), "{case}: {:?} {:?}", lanes.status, alone.status);
            // Lanes know the errors and the energy at the end; a run knows the corrections and every row.
            assert!(
                lanes.rejection_reasons.is_empty() || !alone.rejection_reasons.is_empty(),
                "{case}: {:?}",
                lanes.rejection_reasons
            );
            let (Some(stated), true) =
                (alone.estimated_error, alone.rejection_reasons.is_empty() && lanes.rejection_reasons.is_empty())
            else {
                continue;
            };
            done += 1;
            let in_lanes = lanes.estimated_error.expect("an estimate");
            let (difference, allowed) = (distance(&lanes.q, &alone.q), FACTOR * (stated + in_lanes).max(1e-12));
            assert!(difference <= allowed, "{case}: {difference:e} beside {stated:e} and {in_lanes:e}");
            let Some((exact, _, known)) = first.with(parameters).reference() else { continue };
            let error = distance(&lanes.q, &exact.q);
            let allowed = FACTOR * in_lanes.max(1e-12);
            assert!(error <= allowed || known > 0.3 * in_lanes, "{case}: {error:e} instead of {in_lanes:e}");
        }
    }
    assert!(done as u64 > 6 * sweeps, "{done}");
}
