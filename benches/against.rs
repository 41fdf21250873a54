//! The integration of two crank revolutions against another program that does the same, measured in turn.
//!
//! `cargo bench --bench against -- PROGRAM [ARGUMENTS]`, where PROGRAM prints `ns_per_step best B median M ...`.
//! Without a program our own time is printed alone.

use std::hint::black_box;
use std::process::{Command, ExitCode};

use qrm_model::quick_return::QuickReturn;
use qrm_sim::simulate::{Request, simulate};

const ROUNDS: usize = 15;
const RUNS: usize = 200;

/// Median time of a step over whole runs, in nanoseconds.
fn ours() -> f64 {
    let mechanism = QuickReturn::default();
    let request = Request { method: Default::default(), step: None, end: None, estimate_error: false };
    let run = |_| {
        let outcome = simulate(black_box(&mechanism), &request, &mut ());
        outcome.map_or(f64::NAN, |o| o.integration.as_secs_f64() * 1e9 / o.counts.accepted as f64)
    };
    median((0..RUNS).map(run).collect())
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
    let (mut own, mut ratios) = (Vec::new(), Vec::new());
    for _ in 0..ROUNDS {
        let time = ours();
        own.push(time);
        if program.is_empty() {
            continue;
        }
        match theirs(&program) {
            Some(other) => ratios.push(time / other),
            None => {
                eprintln!("error: {} did not print `ns_per_step best B median M`", program[0]);
                return ExitCode::FAILURE;
            }
        }
    }
    own.sort_by(f64::total_cmp);
    println!(
        "ours: {:.0} ns a step (median of {ROUNDS} rounds; {:.0} to {:.0})",
        median(own.clone()),
        own[0],
        own[ROUNDS - 1]
    );
    if !ratios.is_empty() {
        ratios.sort_by(f64::total_cmp);
        println!("ratio: {:.2} (median; {:.2} to {:.2})", median(ratios.clone()), ratios[0], ratios[ROUNDS - 1]);
    }
    ExitCode::SUCCESS
}
