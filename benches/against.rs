//! The integration of two crank revolutions, in one run and in sweeps of many designs on one core, against a program in
//! C that does the same by hand; and the commands `qrm run` and `qrm sweep`, as whole processes, against these parts.
//!
//! `cargo bench --bench against`; the C program is compiled where there is a C compiler. `-- PROGRAM [ARGUMENTS]` takes
//! another program instead, which prints `ns_per_step best B median M ...`.

mod measure;
#[allow(dead_code, unused_imports, reason = "another bench uses the rest")]
mod twin;

use std::fs;
use std::hint::black_box;
use std::path::Path;
use std::process::{Command, ExitCode};
use std::time::Instant;

use qrm_core::{Mechanism, Model, ParameterOverrides};
use qrm_model::quick_return::QuickReturn;
use qrm_sim::batch::{LaneCount, SweepRequest, sweep};
use qrm_sim::integrate::{DOP853, MethodSettings};
use qrm_sim::run::{Request, simulate};

use twin::{ByDualNumbers, ByHand, HandWritten, Twin};

const RUNS: usize = 200;
const DESIGNS: usize = 256;

/// A function that measures a run (nanoseconds, steps) so many times, or a sweep (microseconds, designs).
type Measure = fn(usize) -> (f64, f64);

/// The mechanism with its generated kernel.
static GENERATED: Model = Model::from_generated::<QuickReturn, 3, 2>();
/// The mechanism with a kernel by hand.
static BY_HAND: Model = Model::from_generated::<HandWritten, 3, 2>();

const RUN: [(&str, Measure); 5] = [
    ("one run, generated kernel", |n| one(&*GENERATED.mechanism(&|_| None), n)),
    ("one run, kernel by hand", |n| one(&*BY_HAND.mechanism(&|_| None), n)),
    ("one run, plain generated functions", |n| one(&Twin::<QuickReturn>::new(), n)),
    ("one run, plain functions by hand", |n| one(&Twin::<ByHand>::new(), n)),
    ("one run, dual numbers at run time", |n| one(&Twin::<ByDualNumbers>::new(), n)),
];

const SWEEP: [(&str, Measure); 8] = [
    ("sweep to 1e-9, most lanes, end states", |_| designs(LaneCount::Most, 1e-9, false, false)),
    ("sweep to 1e-9, four lanes, end states", |_| designs(LaneCount::Four, 1e-9, false, false)),
    ("sweep to 1e-12, most lanes, end states", |_| designs(LaneCount::Most, 1e-12, false, false)),
    ("sweep to 1e-12, four lanes, end states", |_| designs(LaneCount::Four, 1e-12, false, false)),
    ("sweep to 1e-9, most lanes, with extremes", |_| designs(LaneCount::Most, 1e-9, true, false)),
    ("sweep to 1e-9, most lanes, with error estimates", |_| designs(LaneCount::Most, 1e-9, false, true)),
    ("sweep to 1e-9, most lanes, with both", |_| designs(LaneCount::Most, 1e-9, true, true)),
    ("sweep to 1e-9, four lanes, with both", |_| designs(LaneCount::Four, 1e-9, true, true)),
];

/// Commands: the measured part that each belongs to, its arguments, and the number of designs; none for the time of a
/// step that the command itself prints.
const COMMANDS: [(&str, &str, &[&str], Option<usize>); 3] = [
    (
        "`qrm run`, 200 000 steps, as it prints",
        RUN[0].0,
        &["run", "quick-return", "--step", "8.8e-6", "--every", "1000000", "--no-error-estimate", "--no-figures"],
        None,
    ),
    (
        "`qrm sweep`, 65 536 designs, end states",
        "sweep to 1e-9, most lanes, end states",
        &["sweep", "quick-return", "--vary", "O2A=0.15:0.25:65536", "--no-extremes", "--no-error-estimate"],
        Some(65536),
    ),
    (
        "`qrm sweep`, 16 384 designs, with both",
        "sweep to 1e-9, most lanes, with both",
        &["sweep", "quick-return", "--vary", "O2A=0.15:0.25:16384"],
        Some(16384),
    ),
];

/// The time of a command on one core: nanoseconds a step, or microseconds a design.
fn command((_, _, arguments, designs): (&str, &str, &[&str], Option<usize>)) -> Option<f64> {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("command");
    let mut command = Command::new(env!("CARGO_BIN_EXE_qrm"));
    command.args(arguments).arg("--out");
    let Some(designs) = designs else {
        let output = command.arg(folder).output().ok().filter(|output| output.status.success())?;
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        let words: Vec<&str> = text.split_whitespace().collect();
        return words.windows(3).find(|words| words[1..] == ["ns", "a"])?[0].parse().ok();
    };
    // A sweep that was interrupted would go on.
    let _ = fs::remove_file(folder.with_extension("csv.under-way"));
    command.arg(folder.with_extension("csv")).args(["--threads", "1"]);
    let begun = Instant::now();
    command.output().ok().filter(|output| output.status.success())?;
    Some(begun.elapsed().as_secs_f64() * 1e6 / designs as f64)
}

/// The median of whole runs.
fn one(mechanism: &dyn Mechanism, runs: usize) -> (f64, f64) {
    let request = Request::default();
    let mut times = Vec::new();
    let mut steps = 0.0;
    for _ in 0..runs {
        let Ok(outcome) = simulate(black_box(mechanism), &request, &mut ()) else { return (f64::NAN, f64::NAN) };
        times.push(outcome.integration.as_secs_f64() * 1e9);
        steps = outcome.counts.accepted as f64;
    }
    times.sort_by(f64::total_cmp);
    (times[runs / 2], steps)
}

/// A whole sweep to a true error of the end, and the number of designs.
fn designs(lanes: LaneCount, tolerance: f64, extremes: bool, estimate_error: bool) -> (f64, f64) {
    let settings = MethodSettings::new(DOP853, tolerance);
    let crank = |i: usize| 0.15 + 0.1 * i as f64 / DESIGNS as f64;
    let replacements: Vec<_> = (0..DESIGNS).map(|i| move |name: &str| (name == "O2A").then_some(crank(i))).collect();
    let designs: Vec<ParameterOverrides> = replacements.iter().map(|replace| replace as ParameterOverrides).collect();
    let request = SweepRequest { settings, extremes, estimate_error, ..SweepRequest::default() };
    let begun = Instant::now();
    let finished = sweep(&GENERATED, black_box(&designs), &request, lanes);
    (begun.elapsed().as_secs_f64() * 1e6, black_box(finished).len() as f64)
}

/// The program by hand, compiled; `None` without a C compiler.
fn compiled() -> Option<Vec<String>> {
    let program = Path::new(env!("CARGO_TARGET_TMPDIR")).join("hand_written");
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/hand_written.c");
    let made =
        Command::new("cc").args(["-O3", "-march=native"]).arg(source).arg("-o").arg(&program).arg("-lm").status();
    made.is_ok_and(|status| status.success()).then(|| vec![program.to_string_lossy().into_owned(), "60".to_owned()])
}

fn theirs(program: &[String]) -> Option<f64> {
    let output = Command::new(&program[0]).args(&program[1..]).output().ok()?;
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    text.split_whitespace().skip_while(|word| *word != "median").nth(1)?.parse().ok()
}

fn main() -> ExitCode {
    if let Some((thing, runs)) = measure::counted() {
        RUN[thing].1(runs as usize);
        return ExitCode::SUCCESS;
    }
    let given: Vec<String> = std::env::args().skip(1).filter(|argument| argument != "--bench").collect();
    let program = if given.is_empty() { compiled() } else { Some(given) };
    let ours: Vec<(&str, Measure)> = RUN.into_iter().chain(SWEEP).collect();
    let first = ours.len() + COMMANDS.len();
    let count = first + usize::from(program.is_some());
    let times = measure::in_turn(count, |i| match (ours.get(i), COMMANDS.get(i.wrapping_sub(ours.len())), &program) {
        (Some((_, measure)), ..) => {
            let (time, steps) = measure(RUNS);
            time / steps
        }
        (_, Some(of_command), _) => command(*of_command).unwrap_or(f64::NAN),
        (.., Some(program)) => theirs(program).unwrap_or(f64::NAN),
        (.., None) => f64::NAN,
    });
    let other = program.is_some().then(|| &times[first]);
    if other.is_some_and(|other| other.0.iter().any(|time| time.is_nan())) {
        eprintln!("error: the other program did not print `ns_per_step best B median M`");
        return ExitCode::FAILURE;
    }
    println!("{:52} {:>22}  {:>24} {:>13}", "", "ns a step", "of C by hand", "instructions");
    let (runs, sweeps) = times[..ours.len()].split_at(RUN.len());
    for (i, ((what, run), time)) in RUN.iter().zip(runs).enumerate() {
        let ratio = other.map_or_else(String::new, |other| time.over(other).show(3));
        let counted = measure::instructions(i, 2).map(|count| (count, run(1).1));
        let counted = counted.map_or_else(String::new, |(count, steps)| format!("{:.0}", count / steps));
        println!("{what:52} {:>22}  {ratio:>24} {counted:>13}", time.show(1));
    }
    if let Some(other) = other {
        println!("{:52} {:>22}", "C by hand", other.show(1));
    }
    println!("\n{:52} {:>22}", "", "us a design");
    for ((what, _), time) in SWEEP.iter().zip(sweeps) {
        println!("{what:52} {:>22}", time.show(2));
    }
    println!("\n{:52} {:>22}  {:>24}", "whole commands on one core", "ns a step, us a design", "of the bench's");
    for ((what, part, ..), time) in COMMANDS.iter().zip(&times[ours.len()..]) {
        let part = ours.iter().position(|(name, _)| name == part).unwrap_or_default();
        println!("{what:52} {:>22}  {:>24}", time.show(1), time.over(&times[part]).show(3));
    }
    println!("medians of {} rounds in turn, with the smallest and the largest", measure::ROUNDS);
    ExitCode::SUCCESS
}
