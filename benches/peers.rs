//! Error against run time of our methods on the problems of `benches/peers`, for the figure beside its peers.
//!
//! `cargo bench --bench peers` writes `benches/peers/ours.csv`; `benches/peers/run` measures the peers and draws both.

use std::error::Error;
use std::path::Path;
use std::time::Instant;

use qrm_core::{Model, ParameterOverrides};
use qrm_sim::batch::{LaneCount, SweepRequest, sweep};
use qrm_sim::integrate::{AUTO, DOP853, METHODS, Method, MethodSettings};
use qrm_sim::run::{End, Request, simulate};

/// Seconds for one row of the table.
const BUDGET: f64 = 0.3;
const FEWEST: usize = 7;
const MOST: usize = 400;
/// A sweep takes the designs of a problem so often: what it costs to begin one is shared by many designs.
const ROUNDS: usize = 32;

struct Problem {
    name: String,
    end_time: f64,
    /// The first one is that of the scene.
    designs: Vec<Exact>,
}

/// The exact end of a design.
struct Exact {
    parameters: Vec<(String, f64)>,
    coordinates: Vec<f64>,
}

/// A row: microseconds of each repetition, and the error; `None` where a method gave up.
type Measured = Option<(Vec<f64>, f64)>;

fn main() -> Result<(), Box<dyn Error>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/peers");
    let mut table = csv::Writer::from_path(folder.join("ours.csv"))?;
    let head = "problem kind tool version method options tolerance microseconds spread error preparation_seconds";
    table.write_record(head.split(' '))?;
    let mut write = |problem: &str, kind: &str, (method, options): (&str, &str), tolerance: f64, measured: Measured| {
        let Some((mut times, error)) = measured else { return Ok(()) };
        times.sort_by(f64::total_cmp);
        let quarter = |k: usize| times[k * (times.len() - 1) / 4];
        let spread = (quarter(3) - quarter(1)) / quarter(2);
        let numbers = [tolerance, times[0], spread, error].map(|number| format!("{number:.2e}"));
        let [tolerance, time, spread, error] = &numbers;
        let version = env!("CARGO_PKG_VERSION");
        table.write_record([problem, kind, "qrm", version, method, options, tolerance, time, spread, error, ""])
    };
    for Problem { name: problem, end_time, designs } in problems(&folder.join("exact.csv"))? {
        let Some(model) = qrm_model::MODELS.iter().find(|model| model.description.name == problem) else { continue };
        let step = model.mechanism(&|_| None).schedule().step;
        // `auto` is `dop853` where nothing is stiff.
        for method in METHODS.into_iter().filter(|method| *method != AUTO) {
            for k in 0..24 {
                let size = if method.is_adaptive() {
                    10.0_f64.powf(-3.0 - 0.5 * f64::from(k))
                } else {
                    8.0 * step * 0.5_f64.powi(k)
                };
                if !method.is_adaptive() && (k > 10 || size < 1e-6 * end_time) {
                    break;
                }
                let measured = one_run(model, method, (size, end_time), &designs[0]);
                write(&problem, "run", (method.name, ""), size, measured)?;
            }
        }
        if designs.len() > 1 {
            for (extremes, estimate_error, options) in
                [(false, false, ""), (true, true, "with extremes and error estimates")]
            {
                for k in 0..15 {
                    let tolerance = 10.0_f64.powf(-7.5 - 0.5 * f64::from(k));
                    let measured = one_sweep(model, (tolerance, end_time), (extremes, estimate_error), &designs[1..]);
                    write(&problem, "sweep", (DOP853.name, options), tolerance, measured)?;
                }
            }
        }
    }
    table.flush()?;
    Ok(())
}

fn problems(path: &Path) -> Result<Vec<Problem>, Box<dyn Error>> {
    let mut found: Vec<Problem> = Vec::new();
    for record in csv::Reader::from_path(path)?.records() {
        let record = record?;
        let parameter = |text: &str| -> Result<(String, f64), Box<dyn Error>> {
            let (name, value) = text.split_once('=').ok_or("a parameter without a value")?;
            Ok((name.to_owned(), value.parse()?))
        };
        let design = Exact {
            parameters: record[2].split_whitespace().map(parameter).collect::<Result<_, _>>()?,
            coordinates: record[3].split_whitespace().map(str::parse).collect::<Result<_, _>>()?,
        };
        match found.last_mut().filter(|problem| problem.name == record[0]) {
            Some(problem) => problem.designs.push(design),
            None => {
                found.push(Problem { name: record[0].to_owned(), end_time: record[1].parse()?, designs: vec![design] });
            }
        }
    }
    Ok(found)
}

/// Runs without rows inside and without error estimate; `size` is the tolerance, or the step.
fn one_run(model: &Model, method: &'static Method, (size, end_time): (f64, f64), exact: &Exact) -> Measured {
    let (settings, step) = if method.is_adaptive() {
        (MethodSettings::new(method, size), end_time)
    } else {
        (MethodSettings { method, ..MethodSettings::default() }, size)
    };
    let mechanism = model.mechanism(&|_| None);
    let end = || Some(End::Time(end_time));
    let request = || Request { settings, step: Some(step), end: end(), ..Request::default() };
    repeat(|| {
        let outcome = simulate(&*mechanism, &request(), &mut ()).ok().filter(|outcome| outcome.status.is_done())?;
        Some((outcome.integration.as_secs_f64(), distance(&outcome.q, &exact.coordinates)))
    })
}

fn one_sweep(
    model: &Model,
    (tolerance, end_time): (f64, f64),
    (extremes, estimate_error): (bool, bool),
    designs: &[Exact],
) -> Measured {
    let value = |exact: &Exact, name: &str| exact.parameters.iter().find(|(own, _)| own == name).map(|(_, v)| *v);
    let designs = || (0..ROUNDS).flat_map(|_| designs);
    let replacements: Vec<_> = designs().map(|exact| move |name: &str| value(exact, name)).collect();
    let replacements: Vec<ParameterOverrides> =
        replacements.iter().map(|replace| replace as ParameterOverrides).collect();
    let settings = MethodSettings::new(DOP853, tolerance);
    let request =
        SweepRequest { settings, end: Some(End::Time(end_time)), extremes, estimate_error, ..SweepRequest::default() };
    repeat(|| {
        let begun = Instant::now();
        let results = sweep(model, &replacements, &request, LaneCount::Most);
        let seconds = begun.elapsed().as_secs_f64() / replacements.len() as f64;
        if !results.iter().all(|result| result.status.as_ref().is_ok_and(|status| status.is_done())) {
            return None;
        }
        let errors = results.iter().zip(designs()).map(|(result, exact)| distance(&result.q, &exact.coordinates));
        Some((seconds, errors.fold(0.0, f64::max)))
    })
}

/// Measures until the budget is spent; times in microseconds.
fn repeat(mut measure: impl FnMut() -> Option<(f64, f64)>) -> Measured {
    let (mut times, mut error) = (Vec::new(), 0.0);
    let begun = Instant::now();
    while times.len() < FEWEST || times.len() < MOST && begun.elapsed().as_secs_f64() < BUDGET {
        let (seconds, found) = measure()?;
        error = found;
        times.push(1e6 * seconds);
        if begun.elapsed().as_secs_f64() > 10.0 * BUDGET {
            break;
        }
    }
    Some((times, error))
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}
