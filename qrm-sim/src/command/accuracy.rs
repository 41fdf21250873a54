//! `qrm accuracy`

mod ladder;
mod picture;
mod table;
mod verdict;

use std::time::{Duration, Instant};

use qrm_view::figure::Figure;

use super::arguments::{AccuracyArguments, MethodArguments, ReferenceName};
use super::reference::Reference;
use super::setup::Setup;
use super::{Failure, settings};
use crate::scenes::Scenes;
use ladder::{Climb, Cut};

/// Measures run time and error of every method.
pub(super) fn accuracy(scenes: &Scenes, arguments: &AccuracyArguments) -> Result<(), Failure> {
    let begun = Instant::now();
    let setup = Setup::new(scenes, &arguments.scene, &MethodArguments::default())?;
    let deadline = begun + budget(&arguments.budget)?;
    let study = Study::new(&setup, &arguments.at, arguments.reference, deadline)?;
    let out = setup.folder(arguments.out.as_deref());
    let (csv, svg) = (out.join("accuracy.csv"), out.join("accuracy.svg"));
    let text = table::csv(&study.climb.rungs, &study.reference).map_err(|e| Failure::Run(format!("error: {e}")))?;
    super::save(&csv, &text)?;
    super::say(&table::printed(&setup, &study.climb.rungs, &study.reference));
    let mut verdict = String::from("Cheapest for an error of the coordinates of at most\n");
    for (goal, way) in study.verdict() {
        verdict += &format!("  {goal:>6}  {way}\n");
    }
    super::say(&verdict);
    let mut written = format!("wrote {} ({} rows)", csv.display(), study.climb.rungs.len());
    match study.figure(&setup).svg() {
        Ok(drawn) => {
            super::save(&svg, drawn.as_bytes())?;
            written += &format!("\n      {}", svg.display());
        }
        Err(reason) => written += &format!("\n\nwarning: no picture: {reason}"),
    }
    for warning in study.warnings(&arguments.budget) {
        written += &format!("\n\nwarning: {warning}");
    }
    super::say(&written);
    match study.climb.cut {
        Some(Cut::Interrupted) => Err(Failure::Run("error: interrupted: what was measured is written".to_owned())),
        _ => Ok(()),
    }
}

/// Measurements of a scene, and what they are compared with.
pub(super) struct Study {
    reference: Reference,
    climb: Climb,
}

impl Study {
    /// Measures what can be begun before the deadline.
    pub(super) fn new(
        setup: &Setup,
        at: &[String],
        reference: Option<ReferenceName>,
        deadline: Instant,
    ) -> Result<Self, Failure> {
        let reference = Reference::find(setup, at, reference)?;
        let climb = ladder::climb(setup, &reference, deadline)?;
        Ok(Self { reference, climb })
    }

    /// What errors are told by.
    pub(super) fn origin(&self) -> String {
        format!("{}, uncertain by {:.1e}", self.reference.origin, self.reference.uncertainty.position)
    }

    /// What the measurements leave in doubt.
    fn warnings(&self, budget: &str) -> Vec<String> {
        let mut warnings = Vec::new();
        if self.climb.cut == Some(Cut::Budget) {
            warnings.push(format!(
                "finer steps were not measured: there was no time left\n  = help: give more with `--budget`, which was {budget}"
            ));
        }
        warnings.extend(verdict::doubt(&self.climb.rungs, &self.reference));
        warnings
    }

    /// The cheapest way to each of some accuracies.
    pub(super) fn verdict(&self) -> Vec<(String, String)> {
        verdict::verdict(&self.climb, &self.reference)
    }

    /// The work-precision diagram.
    pub(super) fn figure(&self, setup: &Setup) -> Figure {
        picture::figure(setup, &self.climb.rungs, &self.reference)
    }
}

/// Reads `30s`, `500ms`, `2min` or a number of seconds.
fn budget(text: &str) -> Result<Duration, Failure> {
    let text = text.trim();
    let units = [("ms", 1e-3), ("min", 60.0), ("s", 1.0), ("m", 60.0), ("h", 3600.0)];
    let found = units.into_iter().find_map(|(unit, factor)| Some((text.strip_suffix(unit)?, factor)));
    let (number, factor) = found.unwrap_or((text, 1.0));
    let seconds = settings::positive("--budget", number.trim())? * factor;
    Ok(Duration::try_from_secs_f64(seconds).unwrap_or(Duration::MAX))
}
