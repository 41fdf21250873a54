//! `qrm sweep`

mod axes;
mod journal;
mod part;
mod rows;
mod self_check;
mod table;

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc;

use clap::{Args, ValueEnum};
use qrm_core::{Description, Model, Replace, digest};
use qrm_scene::evaluate::{constant, parameter_values};
use qrm_scene::time_scales::time_scales;
use qrm_sim::batch::{DesignResult, LaneCount, SweepEnd, SweepRequest, sweep};
use qrm_sim::columns::Column;
use qrm_sim::integrate::{DOP853, MethodSettings};

use crate::columns::write_units;
use crate::error::Error;
use crate::format::counted;
use crate::options::{MethodOptions, SceneOptions, default_folder};
use crate::output::print;
use crate::progress::{DesignProgress, interrupted, watch_interrupts};
use crate::resolution;
use crate::setup::Setup;
use axes::Axes;
use journal::Journal;
use part::Part;
pub(super) use part::join;
use rows::{Field, Row};
use table::Format;

#[derive(Args)]
pub(crate) struct Options {
    #[command(flatten)]
    scene: SceneOptions,
    #[command(flatten)]
    how: MethodOptions,
    /// Vary a parameter: `NAME=FROM:TO:COUNT` or `NAME=VALUE,VALUE,...`; may be repeated, for every combination
    #[arg(long, value_name = "NAME=VALUES", required = true, allow_hyphen_values = true)]
    vary: Vec<String>,
    /// Compute one part of the designs only, such as `2/8`; `qrm merge` joins the parts
    #[arg(long, value_name = "K/N")]
    shard: Option<String>,
    /// Compute no outputs, and leave out their smallest and largest values in the rows
    #[arg(long)]
    no_extremes: bool,
    /// Skip the second motion, by other steps, that estimates the error of each design
    #[arg(long)]
    no_error_estimate: bool,
    /// How many cores to use [default: all]
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    #[arg(value_parser = clap::value_parser!(u32).range(1..=4096))]
    threads: Option<u32>,
    /// How many designs a core makes at once
    #[arg(long, value_enum, default_value_t = Lanes::Most)]
    lanes: Lanes,
    /// The table, ending in `.csv` or `.parquet` [default: out/SCENE/sweep.csv]
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Lanes {
    /// As many as the processor has lanes for
    Most,
    /// Four at most
    Four,
    /// One
    One,
}

impl Lanes {
    fn count(self) -> LaneCount {
        match self {
            Self::Most => LaneCount::Most,
            Self::Four => LaneCount::Four,
            Self::One => LaneCount::One,
        }
    }
}

/// The number of designs that a core takes at once.
const BLOCK: usize = 256;

/// Runs a scene with every combination of parameter values.
pub(crate) fn run(models: &'static [Model], options: &Options) -> Result<(), Error> {
    let plan = Plan::new(models, options)?;
    let (begin, end) = plan.range;
    let (mut journal, done) = Journal::open(&plan.out, &plan.title(), &plan.columns)?;
    if done > 0 {
        print(&format!("goes on after {} of an interrupted sweep", counted(done as u64, "design")));
    }
    watch_interrupts();
    let written = plan.run(&mut journal, done)?;
    if written < end {
        let (count, all) = (written - begin, counted((end - begin) as u64, "design"));
        let path = journal.path().display();
        return Err(Error::run(format!("interrupted after {count} of {all}, which stand in {path}"))
            .help("the same command goes on from there"));
    }
    let (done, failed) = journal.counts();
    journal.finish(&plan.out)?;
    if options.shard.is_some() {
        Part::save(&plan.identity(), plan.axes.count(), plan.range, &plan.columns, &plan.out)?;
    }
    let units = write_units(&plan.out, &plan.columns).map_err(Error::while_running)?;
    let checked = self_check::compare(&plan);
    print(&format!(
        "{}: {}, {done} done, {failed} failed{}\n\nwrote {} (units in {})",
        plan.setup.description.name,
        counted((done + failed) as u64, "design"),
        checked.as_ref().map(ToString::to_string).unwrap_or_default(),
        plan.out.display(),
        units.file_name().unwrap_or_default().display()
    ));
    checked.map_err(self_check::Difference::error)?;
    if done == 0 && failed > 0 {
        return Err(Error::run("no design came to its end; the column `reason` says why"));
    }
    Ok(())
}

/// A design of a sweep and its end.
struct Design {
    /// The values of the parameters that are varied.
    values: Vec<f64>,
    /// The values of all parameters.
    parameters: Vec<f64>,
    /// Its end, or why it cannot be run.
    result: Result<DesignResult, String>,
}

/// A sweep that is to be made.
struct Plan<'s> {
    options: &'s Options,
    setup: Setup,
    axes: Axes,
    /// The first design of this part, and the first beyond it.
    range: (usize, usize),
    threads: usize,
    columns: Vec<Column<Field>>,
    out: PathBuf,
}

impl<'s> Plan<'s> {
    fn new(models: &'static [Model], options: &'s Options) -> Result<Self, Error> {
        let how = MethodOptions { method: options.how.method.or(Some(DOP853)), ..options.how.clone() };
        let setup = Setup::new(models, &options.scene, &how)?;
        if setup.own_step.is_some() && setup.settings.method.is_adaptive() {
            return Err(Error::usage("`--step` needs a method of fixed steps, as a sweep writes no rows")
                .help("add `--method rk4`, or choose `--tolerance` instead"));
        }
        let axes = Axes::new(setup.description, &options.vary)?;
        if let Some(name) = axes.names().find(|name| setup.set.contains_key(*name)) {
            return Err(Error::usage(format!("`{name}` is both set and varied"))
                .help(format!("omit `--set {name}` or `--vary {name}`")));
        }
        let range = match &options.shard {
            Some(shard) => axes::shard(shard, axes.count())?,
            None => (0, axes.count()),
        };
        let out = options.out.clone().unwrap_or_else(|| default_folder(&setup.path).join("sweep.csv"));
        let format = Format::of(&out)?;
        if options.shard.is_some() && format != Format::Csv {
            return Err(Error::usage("a part of a sweep is written as CSV")
                .help("let `--out` end in `.csv`; `qrm merge OUT.parquet PART...` writes Parquet"));
        }
        let threads = match options.threads {
            Some(threads) => threads as usize,
            None => std::thread::available_parallelism().map_or(1, std::num::NonZero::get),
        };
        let columns = rows::columns(&setup, &axes, !options.no_extremes);
        Ok(Self { options, columns, setup, axes, range, threads, out })
    }

    /// A line that differs between sweeps, and is the same for the parts of one.
    fn identity(&self) -> String {
        let Options { scene, how, vary, no_extremes, no_error_estimate, lanes, .. } = self.options;
        // Four lanes and eight give the same digits.
        let is_single = *lanes == Lanes::One;
        let MethodOptions { method: _, tolerance, max_step, projection, closure_tolerance, closure_iterations } = how;
        let name = self.setup.settings.method.name;
        let how = (name, tolerance, max_step, projection, closure_tolerance, closure_iterations);
        let asked = format!("{scene:?} {how:?} {vary:?} {no_extremes} {no_error_estimate} {is_single}");
        let Description { name, source, .. } = self.setup.description;
        format!("{name} {} {:016x}", env!("CARGO_PKG_VERSION"), digest(source.bytes().chain(asked.bytes())))
    }

    /// A line that differs between tables of sweeps.
    fn title(&self) -> String {
        let (begin, end) = self.range;
        format!("{}, designs {begin} to {end}", self.identity())
    }

    /// Runs all designs but those that are done; returns the first that was not written.
    fn run(&self, journal: &mut Journal, done: usize) -> Result<usize, Error> {
        let (begin, end) = self.range;
        let progress = DesignProgress::new(end - begin, done);
        let next = AtomicUsize::new(begin + done);
        let mut written = Ok(begin + done);
        std::thread::scope(|scope| {
            let (sender, receiver) = mpsc::sync_channel(4 * self.threads);
            for _ in 0..self.threads {
                let (sender, next) = (sender.clone(), &next);
                scope.spawn(move || {
                    while !interrupted() {
                        let from = next.fetch_add(BLOCK, Ordering::Relaxed);
                        let to = end.min(from.saturating_add(BLOCK));
                        if from >= to || sender.send((from, self.rows(from, to))).is_err() {
                            break;
                        }
                    }
                });
            }
            drop(sender);
            // Blocks come as they are ready; rows are written in the order of the designs.
            let mut waiting = BTreeMap::new();
            for (from, rows) in receiver {
                waiting.insert(from, rows);
                while let Ok(at) = written
                    && let Some(rows) = waiting.remove(&at)
                {
                    let count = rows.len();
                    written = journal.write(&rows).map(|()| at + count);
                    progress.add(count);
                }
                if written.is_err() {
                    next.store(end, Ordering::Relaxed);
                }
            }
        });
        written
    }

    /// The rows of some designs.
    fn rows(&self, begin: usize, end: usize) -> Vec<Row> {
        let numbers: Vec<usize> = (begin..end).collect();
        let row = |(number, design): (&usize, Design)| match &design.result {
            Err(reason) => rows::refused(&self.columns, *number, &design.values, reason),
            Ok(result) => {
                let passed_over = self.passed_over(&design.parameters, result.end_time);
                rows::row(&self.columns, &self.setup, *number, &design.values, result, passed_over)
            }
        };
        let designs = self.designs(&numbers, self.setup.settings, self.options.lanes.count());
        numbers.iter().zip(designs).map(row).collect()
    }

    /// Runs the designs of some numbers.
    fn designs(&self, numbers: &[usize], settings: MethodSettings, lanes: LaneCount) -> Vec<Design> {
        let values: Vec<Vec<f64>> = numbers.iter().map(|number| self.axes.values(*number)).collect();
        let own = self.setup.replace();
        let replacing = |values: &Vec<f64>| {
            let (values, own) = (values.clone(), &own);
            move |name: &str| self.axes.value(&values, name).or_else(|| own(name))
        };
        let replacements: Vec<_> = values.iter().map(replacing).collect();
        let replacements: Vec<Replace> = replacements.iter().map(|replace| replace as Replace).collect();
        let parameters: Vec<Vec<f64>> =
            replacements.iter().map(|replace| parameter_values(&self.setup.scene, replace)).collect();
        let refused: Vec<Option<String>> = parameters.iter().map(|parameters| self.refused(parameters)).collect();
        let kept: Vec<usize> = (0..numbers.len()).filter(|i| refused[*i].is_none()).collect();
        let designs: Vec<Replace> = kept.iter().map(|i| replacements[*i]).collect();
        let until = |design: usize, t: f64, q: &[f64], qd: &[f64]| {
            let condition = self.setup.condition.as_ref();
            condition.map_or(0.0, |condition| condition.value(&parameters[kept[design]], t, q, qd))
        };
        let stop = match (self.setup.end_time, &self.setup.condition) {
            (Some(t), _) => Some(SweepEnd::Time(t)),
            (None, Some(_)) => Some(SweepEnd::Condition(&until)),
            (None, None) => None,
        };
        let step_bounds = |design: usize| self.setup.step_bounds(&parameters[kept[design]]);
        let request = SweepRequest {
            settings,
            step_bounds: Some(&step_bounds),
            step: self.setup.own_step,
            end: stop,
            extremes: !self.options.no_extremes,
            estimate_error: !self.options.no_error_estimate,
        };
        let mut results = sweep(self.setup.model, &designs, &request, lanes).into_iter();
        let all = values.into_iter().zip(parameters).zip(refused);
        let design = |((values, parameters), refused): ((Vec<f64>, Vec<f64>), Option<String>)| {
            let result = refused.map_or_else(|| results.next().ok_or_else(String::new), Err);
            Design { values, parameters, result }
        };
        all.map(design).collect()
    }

    /// The reason why the steps of a design pass over a change of a load with time.
    fn passed_over(&self, parameters: &[f64], end_time: f64) -> Option<String> {
        if self.setup.settings.method.is_adaptive() {
            return None;
        }
        let scene = &self.setup.scene;
        let step = self.setup.own_step.unwrap_or_else(|| constant(&scene.run.step, parameters));
        resolution::passed_over(&time_scales(scene, parameters), step, end_time)
    }

    /// The reason why a design cannot be run.
    fn refused(&self, parameters: &[f64]) -> Option<String> {
        let parts = self
            .setup
            .scene
            .bodies
            .iter()
            .flat_map(|body| [(&body.name, "mass", &body.mass), (&body.name, "inertia", &body.inertia)]);
        let mut values =
            parts.filter_map(|(name, what, value)| Some((name, what, constant(value.as_ref()?, parameters))));
        let (name, what, value) = values.find(|(_, _, value)| !(*value >= 0.0 && value.is_finite()))?;
        let wrong = if value < 0.0 { "a negative" } else { "no finite" };
        Some(format!("body `{name}` has {wrong} {what}: {value}"))
    }
}
