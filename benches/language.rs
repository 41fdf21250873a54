//! Two crank revolutions by the steps that are generated in C, against a program in C that does the same by hand: the
//! same compiler, the same flags, in turn.
//!
//! `cargo bench --bench language`, where there is a C compiler.

#[allow(dead_code, reason = "another bench uses the rest")]
mod measure;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

use qrm_core::Model;
use qrm_language::Code;
use qrm_model::quick_return::QuickReturn;
use qrm_scene::resolve;

/// Whole runs of which a program gives the median.
const RUNS: &str = "60";
const FLAGS: [&str; 2] = ["-O3", "-march=native"];

fn main() -> ExitCode {
    let model = Model::from_generated::<QuickReturn, 3, 2>();
    let source = model.description.source;
    let (scene, _) = match resolve::read("scenes/quick-return.toml", source) {
        Ok(read) => read,
        Err(e) => {
            eprintln!("{e}");
            return ExitCode::FAILURE;
        }
    };
    let code = Code { path: "scenes/quick-return.toml", scene: &scene, source, tape: model.named_tape() };
    let files = match qrm_language::c(&code.program()) {
        Ok(files) => files,
        Err(e) => {
            eprintln!("error: {e}");
            return ExitCode::FAILURE;
        }
    };
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"));
    let benches = Path::new(env!("CARGO_MANIFEST_DIR")).join("benches");
    let written = files.iter().all(|file| fs::write(folder.join(&file.name), &file.text).is_ok());
    let generated = [benches.join("language/motion.c"), folder.join("quick_return.c")];
    let by_hand = [benches.join("hand_written.c")];
    println!("{:10} {:>24} {:>24} {:>24}", "", "ns a step, generated", "ns a step, by hand", "ratio");
    for compiler in ["gcc", "clang"] {
        let programs = [compiled(compiler, "motion", &generated), compiled(compiler, "by_hand", &by_hand)];
        let [Some(generated), Some(by_hand)] = programs else {
            println!("{compiler:10} skipped: it is not there");
            continue;
        };
        let times = measure::in_turn(2, |i| median([&generated, &by_hand][i]).unwrap_or(f64::NAN));
        if !written || times.iter().any(|times| times.0.iter().any(|time| time.is_nan())) {
            eprintln!("error: a program did not print `ns_per_step best B median M`");
            return ExitCode::FAILURE;
        }
        let ratio = times[0].over(&times[1]);
        println!("{compiler:10} {:>24} {:>24} {:>24}", times[0].show(1), times[1].show(1), ratio.show(3));
    }
    println!("medians of {} rounds in turn, with the smallest and the largest", measure::ROUNDS);
    ExitCode::SUCCESS
}

/// A program from these sources; `None` without the compiler.
fn compiled(compiler: &str, name: &str, sources: &[PathBuf]) -> Option<PathBuf> {
    let program = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}-{compiler}"));
    let mut command = Command::new(compiler);
    command.args(FLAGS).arg("-I").arg(env!("CARGO_TARGET_TMPDIR")).args(sources).arg("-o").arg(&program).arg("-lm");
    command.status().is_ok_and(|status| status.success()).then_some(program)
}

/// The median that a program prints.
fn median(program: &Path) -> Option<f64> {
    let output = Command::new(program).arg(RUNS).output().ok()?;
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    text.split_whitespace().skip_while(|word| *word != "median").nth(1)?.parse().ok()
}
