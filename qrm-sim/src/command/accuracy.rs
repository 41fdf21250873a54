//! `qrm accuracy`

mod errors;
mod ladder;
mod picture;
mod reference;
mod table;
mod verdict;

use std::time::{Duration, Instant};

use super::arguments::{AccuracyArguments, MethodArguments};
use super::setup::Setup;
use super::{Failure, settings};
use crate::outcome::Status;
use crate::scenes::Scenes;
use reference::Reference;

/// How many times are compared where none are asked for.
const TIMES: usize = 8;

/// Measures run time and error of every method.
pub(super) fn accuracy(scenes: &Scenes, arguments: &AccuracyArguments) -> Result<(), Failure> {
    let begun = Instant::now();
    let setup = Setup::new(scenes, &arguments.scene, &MethodArguments::default())?;
    let budget = budget(&arguments.budget)?;
    let times = times(&setup, &arguments.at)?;
    let reference = Reference::find(&setup, &times, arguments.reference)?;
    let rungs = ladder::climb(&setup, &reference, begun + budget)?;
    let out = setup.folder(arguments.out.as_deref());
    let (csv, svg) = (out.join("accuracy.csv"), out.join("accuracy.svg"));
    let text = table::csv(&rungs, &reference).map_err(|e| Failure::Run(format!("error: {e}")))?;
    super::write(&csv, &text).map_err(|e| Failure::Use(super::unwritable(&csv, &e)))?;
    super::say(&table::printed(&setup, &rungs, &reference));
    super::say(&verdict::verdict(&rungs, &reference));
    let drawn = picture::figure(&setup, &rungs, &reference).svg();
    let mut written = format!("wrote {} ({} rows)", csv.display(), rungs.len());
    match drawn {
        Ok(drawn) => {
            super::write(&svg, drawn.as_bytes()).map_err(|e| Failure::Use(super::unwritable(&svg, &e)))?;
            written += &format!("\n      {}", svg.display());
        }
        Err(reason) => written += &format!("\n\nwarning: no picture: {reason}"),
    }
    super::say(&written);
    Ok(())
}

/// Reads `30s`, `2min` or a number of seconds.
fn budget(text: &str) -> Result<Duration, Failure> {
    let (number, factor) = match text.trim() {
        text if text.ends_with("min") => (text.trim_end_matches("min"), 60.0),
        text => (text.trim_end_matches('s'), 1.0),
    };
    let seconds = settings::positive("--budget", number.trim())? * factor;
    Ok(Duration::try_from_secs_f64(seconds).unwrap_or(Duration::MAX))
}

/// The times to compare at, rising: those that are asked for, or some up to the end of the scene's own run.
fn times(setup: &Setup, asked: &[String]) -> Result<Vec<f64>, Failure> {
    if !asked.is_empty() {
        let mut times = asked.iter().map(|text| settings::positive("--at", text)).collect::<Result<Vec<_>, _>>()?;
        times.sort_by(f64::total_cmp);
        times.dedup();
        return Ok(times);
    }
    let outcome = setup.simulate(false, &mut super::progress::Progress::new())?;
    let end = outcome.end_time;
    if matches!(outcome.status, Status::Interrupted) {
        return Err(Failure::Run(format!("error: interrupted at t = {end} s")));
    }
    if !(end > 0.0) {
        return Err(Failure::Run("error: the run ends where it begins: there is nothing to measure".to_owned()));
    }
    Ok((1..=TIMES).map(|i| end * i as f64 / TIMES as f64).collect())
}
