//! `qrm accuracy`

mod diagram;
mod recommendation;
mod study;
mod table;

use std::time::{Duration, Instant};

use clap::Args;
use qrm_core::Model;
use qrm_scene::names::suggestion;
use qrm_sim::columns::{Column, Kind, columns};

use crate::error::Error;
use crate::format::counted;
use crate::options::{MethodOptions, OutFolder, SceneOptions, positive};
use crate::output::{print, save, written};
use crate::reference::ReferenceKind;
use crate::setup::Setup;
pub(crate) use study::Study;

#[derive(Args)]
pub(crate) struct Options {
    #[command(flatten)]
    scene: SceneOptions,
    /// Compare at this time in seconds; may be repeated [default: eight times up to the end]
    #[arg(long, value_name = "T", allow_hyphen_values = true)]
    at: Vec<String>,
    /// Judge methods by the error of this column, such as an output, instead of the coordinates
    #[arg(long, value_name = "COLUMN")]
    of: Option<String>,
    /// What to compare with [default: the energy integral where there is one, unless a run is more certain]
    #[arg(long, value_enum)]
    reference: Option<ReferenceKind>,
    /// Begin no further measurement after this time, such as `30s`
    #[arg(long, value_name = "TIME", default_value = "30s", allow_hyphen_values = true)]
    budget: String,
    #[command(flatten)]
    out: OutFolder,
}

/// Measures run time and error of every method.
pub(crate) fn run(models: &'static [Model], options: &Options) -> Result<(), Error> {
    let begun = Instant::now();
    let setup = Setup::new(models, &options.scene, &MethodOptions::default())?;
    let deadline = begun + budget(&options.budget)?;
    let of = options.of.as_deref().map(|name| column(&setup, name)).transpose()?;
    let study = Study::new(&setup, &options.at, of, options.reference, deadline)?;
    let out = options.out.folder(&setup.path);
    let (csv, svg) = (out.join("accuracy.csv"), out.join("accuracy.svg"));
    save(&csv, &study.csv()?)?;
    print(&study.table(&setup));
    let of = study.of.as_ref().map_or("the coordinates", |column| &column.name);
    let mut recommendations = format!("Cheapest for an error of {of} of at most\n");
    for (goal, line) in study.recommendations() {
        recommendations += &format!("  {goal:>6}  {line}\n");
    }
    print(&recommendations);
    let mut files = vec![format!("{} ({})", csv.display(), counted(study.samples.len() as u64, "row"))];
    let mut warnings = String::new();
    match study.figure(&setup).svg() {
        Ok(drawn) => {
            save(&svg, drawn.as_bytes())?;
            files.push(svg.display().to_string());
        }
        Err(reason) => warnings += &format!("\n\nwarning: no picture: {reason}"),
    }
    for warning in study.warnings(&options.budget) {
        warnings += &format!("\n\n{}", warning.warning());
    }
    print(&(written(&files) + &warnings));
    if study.is_interrupted() { Err(Error::run("interrupted: what was measured is written")) } else { Ok(()) }
}

/// Finds a column of the reference by its name.
pub(crate) fn column(setup: &Setup, name: &str) -> Result<Column, Error> {
    let is_known = |column: &Column| !matches!(column.kind, Kind::Time | Kind::Residual | Kind::ResidualRate);
    let known: Vec<Column> = columns(setup.description).into_iter().filter(is_known).collect();
    if let Some(column) = known.iter().find(|column| column.name == name) {
        return Ok(column.clone());
    }
    let names = || known.iter().map(|column| column.name.as_str());
    let help = suggestion(name, names(), || format!("columns: {}", names().collect::<Vec<_>>().join(", ")));
    Err(Error::usage(format!("`--of {name}`: there is no such column")).help(help))
}

/// Longer budgets count as unlimited.
const LONGEST: Duration = Duration::from_secs(100 * 365 * 86_400);

/// Reads `30s`, `500ms`, `2min` or a number of seconds.
pub(crate) fn budget(text: &str) -> Result<Duration, Error> {
    let text = text.trim();
    let units = [("ms", 1e-3), ("min", 60.0), ("s", 1.0), ("m", 60.0), ("h", 3600.0)];
    let found = units.into_iter().find_map(|(unit, factor)| Some((text.strip_suffix(unit)?, factor)));
    let (number, factor) = found.unwrap_or((text, 1.0));
    let seconds = positive("--budget", number.trim(), "")? * factor;
    Ok(Duration::try_from_secs_f64(seconds).map_or(LONGEST, |budget| budget.min(LONGEST)))
}
