//! How long the phases of the generator take for one scene, and how much code it becomes.
//!
//! `cargo run --release -p qrm-codegen --features engine --example phases SCENE.toml`

use std::error::Error;
use std::time::{Duration, Instant};

use qrm_codegen::{emit, engine, verify};
use qrm_scene::{resolve, source};

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).ok_or("give the path of a scene")?;
    let text = source::read_text(path.as_ref()).map_err(|report| report.to_string())?;
    let (scene, reading) = timed(|| resolve::read(&path, &text));
    let (scene, _) = scene.map_err(|report| report.to_string())?;
    let (equations, deriving) = timed(|| engine::derive(&[&scene]));
    let equations = equations?.remove(0);
    let (module, emitting) = timed(|| emit::module(&scene, &equations, &text));
    let (verified, verifying) = timed(|| verify::verify(&scene, &equations, &module.file));
    verified?;
    let code = prettyplease::unparse(&module.file);
    println!("scene         {}", scene.name);
    println!("coordinates   {}", scene.coordinates.len());
    println!("constraints   {}", scene.constraints.len());
    for (what, time) in [("read", reading), ("derive", deriving), ("emit", emitting), ("verify", verifying)] {
        println!("{what:13} {:.3} s", time.as_secs_f64());
    }
    println!("code          {} lines, {} kB", code.lines().count(), code.len() / 1000);
    for (function, operations) in &module.operations {
        println!("{function:13} {} operations", operations.sum());
    }
    println!("kernel        {} operations", module.solution.sum());
    if let Some(path) = std::env::args().nth(2) {
        std::fs::write(path, code)?;
    }
    Ok(())
}

fn timed<T>(work: impl FnOnce() -> T) -> (T, Duration) {
    let begun = Instant::now();
    let result = work();
    (result, begun.elapsed())
}
