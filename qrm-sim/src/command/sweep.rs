//! `qrm sweep` and `qrm merge`

mod axes;
mod journal;
mod row;
mod stop;

use std::collections::BTreeMap;
use std::io::IsTerminal;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc;

use indicatif::{ProgressBar, ProgressStyle};
use qrm_core::Description;
use qrm_scene::evaluate::{constant, parameter_values};
use qrm_scene::resolve;
use qrm_scene::scene::Scene as SceneText;

use super::arguments::{LanesName, MergeArguments, SweepArguments};
use super::progress::{Progress, interrupted};
use super::{Failure, settings, units};
use crate::scenes::{Replace, Scene, Scenes};
use crate::sweep::{Finished, SweepEnd, SweepRequest};
use crate::unit::digest;
use axes::Axes;
use journal::Journal;
use row::Columns;
use stop::Stop;

/// How many designs a core takes at once.
const BLOCK: usize = 256;

/// Runs a scene with every combination of parameter values.
pub(super) fn sweep(scenes: &Scenes, arguments: &SweepArguments) -> Result<(), Failure> {
    let plan = Plan::new(scenes, arguments)?;
    let (mut journal, done) = Journal::open(&plan.out, &plan.title(arguments), &plan.columns.header(), plan.range.0)?;
    let first = plan.range.0 + done;
    if done > 0 {
        super::say(&format!("goes on after {done} designs of an interrupted sweep"));
    }
    // Catches the wish to end from now on.
    let _watch = Progress::new();
    let bar = bar(plan.range.1 - plan.range.0, done)?;
    let next = AtomicUsize::new(first);
    let mut written = Ok(first);
    std::thread::scope(|scope| {
        let (sender, receiver) = mpsc::sync_channel(4 * plan.threads);
        for _ in 0..plan.threads {
            let (sender, next, plan) = (sender.clone(), &next, &plan);
            scope.spawn(move || {
                while !interrupted() {
                    let begin = next.fetch_add(BLOCK, Ordering::Relaxed);
                    let end = plan.range.1.min(begin.saturating_add(BLOCK));
                    if begin >= end || sender.send((begin, plan.rows(begin, end))).is_err() {
                        break;
                    }
                }
            });
        }
        drop(sender);
        // Blocks come as they are ready; rows are written in the order of the designs.
        let mut waiting = BTreeMap::new();
        for (begin, rows) in receiver {
            waiting.insert(begin, rows);
            while let Ok(at) = written
                && let Some(rows) = waiting.remove(&at)
            {
                let count = rows.len();
                written = journal.write(&rows).map(|()| at + count);
                bar.inc(count as u64);
            }
            if written.is_err() {
                next.store(plan.range.1, Ordering::Relaxed);
            }
        }
    });
    bar.finish_and_clear();
    let written = written?;
    if written < plan.range.1 {
        return Err(Failure::Run(format!(
            "error: interrupted after {} of {} designs, which stand in {}\n  = help: the same command goes on from there",
            written - plan.range.0,
            plan.range.1 - plan.range.0,
            journal.path().display()
        )));
    }
    let counts = journal.counts();
    journal.finish(&plan.out)?;
    let units = units::write(&plan.out, &plan.columns.header(), &plan.scene.description()).map_err(Failure::Run)?;
    super::say(&format!(
        "{}: {} designs, {} done, {} failed\n\nwrote {} (units in {})",
        plan.scene.description().name,
        counts.0 + counts.1,
        counts.0,
        counts.1,
        plan.out.display(),
        units.file_name().unwrap_or_default().display()
    ));
    if counts.0 == 0 && counts.1 > 0 {
        return Err(Failure::Run("error: no design came to its end; the column `reason` says why".to_owned()));
    }
    Ok(())
}

/// Joins the parts of a sweep that were computed apart.
pub(super) fn merge(arguments: &MergeArguments) -> Result<(), Failure> {
    journal::ending(&arguments.out)?;
    let rows = journal::join(&arguments.parts, &arguments.out)?;
    super::say(&format!("wrote {} ({rows} designs)", arguments.out.display()));
    Ok(())
}

/// What is to be done.
struct Plan<'s> {
    scene: &'s dyn Scene,
    text: SceneText,
    set: BTreeMap<String, f64>,
    axes: Axes,
    /// The first design of this part, and the first beyond it.
    range: (usize, usize),
    step: Option<f64>,
    end_time: Option<f64>,
    stop: Option<Stop>,
    extremes: bool,
    estimate_error: bool,
    width: crate::sweep::Width,
    threads: usize,
    columns: Columns,
    out: PathBuf,
}

impl<'s> Plan<'s> {
    fn new(scenes: &'s Scenes, arguments: &SweepArguments) -> Result<Self, Failure> {
        let scene = settings::scene(scenes, &arguments.scene.scene)?;
        let description = scene.description();
        let set = settings::parameters(&description, &arguments.scene.set)?;
        let axes = Axes::new(&description, &arguments.vary)?;
        if let Some(name) = axes.names().find(|name| set.contains_key(*name)) {
            return Err(Failure::Use(format!(
                "error: `{name}` is both set and varied\n  = help: leave `--set {name}` or `--vary {name}` away"
            )));
        }
        let range = match &arguments.shard {
            Some(shard) => axes::shard(shard, axes.count())?,
            None => (0, axes.count()),
        };
        let option =
            |name: &str, value: &Option<String>| value.as_ref().map(|v| settings::positive(name, v)).transpose();
        let path = format!("scenes/{}.toml", description.name);
        let text = resolve::read_with(&path, description.source, &|name| set.get(name).copied());
        let (text, _) = text.map_err(|report| Failure::Use(report.to_string()))?;
        let stop = arguments.scene.until.as_deref().map(|until| Stop::new(&text, until)).transpose()?;
        let out = arguments.out.clone().unwrap_or_else(|| settings::folder(&description, None).join("sweep.csv"));
        journal::ending(&out)?;
        let threads = match arguments.threads {
            Some(threads) => threads as usize,
            None => std::thread::available_parallelism().map_or(1, std::num::NonZero::get),
        };
        Ok(Self {
            columns: Columns::new(description, &axes, arguments),
            step: option("--step", &arguments.scene.step)?,
            end_time: option("--end-time", &arguments.scene.end_time)?,
            extremes: !arguments.no_extremes,
            estimate_error: !arguments.no_error_estimate,
            width: arguments.lanes.width(),
            scene,
            text,
            set,
            axes,
            range,
            stop,
            threads,
            out,
        })
    }

    /// What tells one sweep from another.
    fn title(&self, arguments: &SweepArguments) -> String {
        let SweepArguments { scene, vary, shard, no_extremes, no_error_estimate, lanes, .. } = arguments;
        // Four lanes and eight give the same digits.
        let is_single = matches!(lanes, LanesName::One);
        let said = format!("{scene:?} {vary:?} {shard:?} {no_extremes} {no_error_estimate} {is_single}");
        let Description { name, source, .. } = self.scene.description();
        format!("# {name} {} {:016x}", env!("CARGO_PKG_VERSION"), digest(source.bytes().chain(said.bytes())))
    }

    /// The rows of some designs.
    fn rows(&self, begin: usize, end: usize) -> Vec<row::Line> {
        let values: Vec<Vec<f64>> = (begin..end).map(|design| self.axes.values(design)).collect();
        let replacing = |values: &Vec<f64>| {
            let values = values.clone();
            move |name: &str| self.axes.value(&values, name).or_else(|| self.set.get(name).copied())
        };
        let replacements: Vec<_> = values.iter().map(replacing).collect();
        let designs: Vec<Replace> = replacements.iter().map(|replace| replace as Replace).collect();
        let refused: Vec<Option<String>> = designs.iter().map(|replace| self.refused(replace)).collect();
        let kept = |i: &usize| refused[*i].is_none();
        let designs: Vec<Replace> = (0..designs.len()).filter(kept).map(|i| designs[i]).collect();
        let stops = self.stop.as_ref().map(|stop| stop.of_designs(&designs));
        let condition = |design: usize, t: f64, q: &[f64], qd: &[f64]| {
            stops.as_ref().map_or(0.0, |stops| stops.value(design, t, q, qd))
        };
        let until = match (self.end_time, &stops) {
            (Some(t), _) => Some(SweepEnd::Time(t)),
            (None, Some(_)) => Some(SweepEnd::Condition(&condition)),
            (None, None) => None,
        };
        let request =
            SweepRequest { step: self.step, end: until, extremes: self.extremes, estimate_error: self.estimate_error };
        let finished: Vec<Finished> = self.scene.sweep(&designs, &request, self.width);
        let mut finished = finished.iter();
        let line = |((design, values), refused): ((usize, &Vec<f64>), &Option<String>)| match refused {
            Some(reason) => Some(self.columns.refused(design, values, reason)),
            None => Some(self.columns.line(design, values, finished.next()?)),
        };
        (begin..end).zip(&values).zip(&refused).filter_map(line).collect()
    }

    /// Why a design is none that can be run.
    fn refused(&self, replace: Replace) -> Option<String> {
        let parameters = parameter_values(&self.text, replace);
        let parts = self
            .text
            .bodies
            .iter()
            .flat_map(|body| [(&body.name, "mass", &body.mass), (&body.name, "inertia", &body.inertia)]);
        let mut values =
            parts.filter_map(|(name, what, value)| Some((name, what, constant(value.as_ref()?, &parameters))));
        let (name, what, value) = values.find(|(_, _, value)| !(*value >= 0.0 && value.is_finite()))?;
        let wrong = if value < 0.0 { "a negative" } else { "no finite" };
        Some(format!("body `{name}` has {wrong} {what}: {value}"))
    }
}

fn bar(count: usize, done: usize) -> Result<ProgressBar, Failure> {
    if !std::io::stderr().is_terminal() {
        return Ok(ProgressBar::hidden());
    }
    let style = ProgressStyle::with_template("{bar:40} {pos} of {len} designs, {per_sec}, {eta} left")
        .map_err(|e| Failure::Run(format!("error: {e}")))?;
    Ok(ProgressBar::new(count as u64).with_style(style).with_position(done as u64))
}

/// The folder of a file, made if it is not there.
fn make_folder(path: &Path) -> Result<(), Failure> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    folder.map_or(Ok(()), std::fs::create_dir_all).map_err(|e| Failure::Use(super::unwritable(path, &e)))
}
