//! The integration of two crank revolutions against another program that does the same, measured in turn: one run, and sweeps of
//! many designs on one core.
//!
//! `cargo bench --bench against -- PROGRAM [ARGUMENTS]`, where PROGRAM prints `ns_per_step best B median M ...`.
//! Without a program our own times are printed alone.

use std::hint::black_box;
use std::process::{Command, ExitCode};
use std::time::Instant;

use qrm_mechanism::{Mechanism, Plain};
use qrm_model::hand_written::HandWritten;
use qrm_model::quick_return::{Parameters, QuickReturn};
use qrm_sim::simulate::{Request, simulate};
use qrm_sim::sweep::{SweepRequest, Width, sweep};

const ROUNDS: usize = 15;
const RUNS: usize = 200;
const DESIGNS: usize = 256;

type Measure = fn() -> f64;

/// What is measured: a name, and how to get the time of a step in nanoseconds.
const OURS: [(&str, Measure); 7] = [
    ("one run, generated kernel", || one(&QuickReturn::default())),
    ("one run, plain generated functions", || one(&Plain(QuickReturn::default()))),
    ("one run, plain functions by hand", || one(&Plain(HandWritten::new(Parameters::default())))),
    ("sweep, as many lanes as there are", || many(Width::Most, false, false)),
    ("sweep, four lanes", || many(Width::Four, false)),
    ("sweep, with error estimates", || many(Width::Most, true)),
    ("sweep, four lanes, with error estimates", || many(Width::Four, true)),
];

/// Median time of a step over whole runs.
fn one(mechanism: &impl Mechanism<3, 2>) -> f64 {
    let request = Request { method: Default::default(), step: None, end: None, estimate_error: false };
    let run = |_| {
        let outcome = simulate(black_box(mechanism), &request, &mut ());
        outcome.map_or(f64::NAN, |o| o.integration.as_secs_f64() * 1e9 / o.counts.accepted as f64)
    };
    median((0..RUNS).map(run).collect())
}

/// Time of a step of a design in a sweep with the extremes of all outputs.
fn many(width: Width, extremes: bool, estimate_error: bool) -> f64 {
    let design = |i: usize| {
        let crank = 0.15 + 0.1 * i as f64 / DESIGNS as f64;
        QuickReturn::with_parameters(&|name| (name == "O2A").then_some(crank))
    };
    let designs: Vec<QuickReturn> = (0..DESIGNS).map(design).collect();
    let request = SweepRequest { step: None, end: None, extremes, estimate_error };
    let begun = Instant::now();
    let finished = sweep(black_box(&designs), &request, width);
    let steps: u64 = finished.iter().map(|finished| finished.steps).sum();
    begun.elapsed().as_secs_f64() * 1e9 / steps as f64
}

fn theirs(program: &[String]) -> Option<f64> {
    let output = Command::new(&program[0]).args(&program[1..]).output().ok()?;
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    text.split_whitespace().skip_while(|word| *word != "median").nth(1)?.parse().ok()
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

fn main() -> ExitCode {
    let program: Vec<String> = std::env::args().skip(1).filter(|argument| argument != "--bench").collect();
    let mut times = vec![Vec::new(); OURS.len()];
    let mut ratios = vec![Vec::new(); OURS.len()];
    for _ in 0..ROUNDS {
        for (i, (_, measure)) in OURS.iter().enumerate() {
            let time = measure();
            times[i].push(time);
            if program.is_empty() {
                continue;
            }
            match theirs(&program) {
                Some(other) => ratios[i].push(time / other),
                None => {
                    eprintln!("error: {} did not print `ns_per_step best B median M`", program[0]);
                    return ExitCode::FAILURE;
                }
            }
        }
    }
    println!("{:42} {:>22}  {:>25}", "", "ns a step", "of the other program's");
    for ((what, _), (times, ratios)) in OURS.iter().zip(times.into_iter().zip(ratios)) {
        println!("{what:42} {:>22}  {:>25}", spread(times, 1), spread(ratios, 3));
    }
    println!("medians of {ROUNDS} rounds in turn, with the smallest and the largest");
    ExitCode::SUCCESS
}

/// Median and range.
fn spread(mut values: Vec<f64>, digits: usize) -> String {
    if values.is_empty() {
        return String::new();
    }
    values.sort_by(f64::total_cmp);
    let [least, most] = [values[0], values[values.len() - 1]];
    format!("{:.digits$} ({least:.digits$} to {most:.digits$})", median(values))
}
