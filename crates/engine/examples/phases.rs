//! Prints the run times of the generator's phases for one scene, the size of its code, and the accuracy of its kernel.
//!
//! `cargo run --release --manifest-path crates/engine/Cargo.toml --target-dir target/engine --example phases SCENE.toml
//! [FORM] [FILE]`
//!
//! `FORM`: `cheapest` (the default), `null-space`, `range-space` or `sparse`.
//! `FILE` receives the code.

use std::error::Error;
use std::time::{Duration, Instant};

use qrm_codegen::kernel::ImpossibleForm;
use qrm_codegen::{derivation, functions, verify};
use qrm_language::{Code, rust};
use qrm_scene::scene::EliminationForm;
use qrm_scene::{resolve, source};

/// The number of random states for the accuracy.
const STATES: usize = 100;

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).ok_or("give the path of a scene")?;
    let form = match std::env::args().nth(2).as_deref() {
        None | Some("cheapest") => None,
        Some(name) => {
            let form = EliminationForm::ALL.into_iter().find(|form| form.name() == name);
            Some(form.ok_or_else(|| format!("`{name}` is no form of a kernel"))?)
        }
    };
    let text = source::read_text(path.as_ref()).map_err(|report| report.to_string())?;
    let (scene, reading) = timed(|| resolve::read(&path, &text));
    let (scene, _) = scene.map_err(|report| report.to_string())?;
    let (equations, deriving) = timed(|| qrm_engine::derive(&[&scene], &|_| ()));
    let equations = equations?.remove(0);
    let (made, making) = timed(|| {
        let tape = functions::tape_of_form(&scene, &equations, form)?;
        let placed = tape.placed();
        Ok::<_, ImpossibleForm>((tape, placed))
    });
    let (tape, placed) = made?;
    let (verified, verifying) = timed(|| verify::verify(&scene, &equations, &tape, &placed));
    verified?;
    let ((code, derivation), writing) = timed(|| {
        let code = rust::text(&Code { path: &path, scene: &scene, source: &text, tape: &tape });
        (code, derivation::markdown(&scene, &equations, &text))
    });
    println!("scene         {}", scene.name);
    println!("coordinates   {}", scene.coordinates.len());
    println!("constraints   {}", scene.constraints.len());
    let phases = [("read", reading), ("derive", deriving), ("tape", making), ("verify", verifying), ("write", writing)];
    for (what, time) in phases {
        println!("{what:13} {:.3} s", time.as_secs_f64());
    }
    println!("code          {} lines, {} kB", code.lines().count(), code.len() / 1000);
    println!("derivation    {} lines, {} kB", derivation.lines().count(), derivation.len() / 1000);
    let bytes = tape.to_bytes();
    let operations = placed.constants.len() + placed.functions().map(|f| f.operations.len()).sum::<usize>();
    println!("tape          {operations} operations, {} kB, {} places", bytes.len() / 1000, placed.places());
    for function in &tape.functions {
        println!("{:13} {} operations", function.name, tape.operations(function).sum());
    }
    println!("kernel        {} operations", tape.solution.sum());
    let mut accuracy = verify::accuracy(&scene, &tape, STATES);
    accuracy.sort_by(|a, b| a.error.total_cmp(&b.error));
    let growth = accuracy.iter().map(|at| at.growth_factor).fold(0.0, f64::max);
    if let [.., worst] = &accuracy[..] {
        let median = accuracy[accuracy.len() / 2].error;
        println!(
            "accelerations {median:.1e} median error, {:.1e} at most; growth factor {growth:.0} at most",
            worst.error
        );
    }
    if let Some(path) = std::env::args().nth(3) {
        std::fs::write(&path, code)?;
        std::fs::write(format!("{path}.md"), derivation)?;
    }
    Ok(())
}

fn timed<T>(work: impl FnOnce() -> T) -> (T, Duration) {
    let begun = Instant::now();
    let result = work();
    (result, begun.elapsed())
}
