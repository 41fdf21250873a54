//! `qrm sweep`

mod axes;
mod designs;
mod journal;
mod part;
mod rows;
pub(crate) mod self_check;
mod table;
mod values;

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use qrm_core::{Description, Model, digest};
use qrm_sim::batch::LaneCount;

use crate::columns::write_units;
use crate::error::{Error, Message};
use crate::format::counted;
use crate::gpu::Processor;
use crate::options::{MethodOptions, SceneOptions, default_folder};
use crate::output::print;
use crate::progress::{Progress, watch_interrupts};
use crate::setup::Setup;
pub(crate) use axes::Axes;
pub use designs::THREADS;
pub(crate) use designs::{Designs, by_lanes, threads};
use journal::Journal;
use part::Part;
pub(super) use part::join;
use rows::Block;
pub(crate) use rows::{Cell, Field, Row};
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
    #[arg(value_parser = clap::value_parser!(u32).range(THREADS))]
    threads: Option<u32>,
    /// How many designs a core makes at once
    #[arg(long, value_enum, default_value_t = Lanes::Most)]
    lanes: Lanes,
    /// The processor that runs the designs
    #[arg(long, value_enum, default_value_t)]
    device: Processor,
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

/// Runs a scene with every combination of parameter values.
pub(crate) fn run(models: &'static [Model], options: &Options) -> Result<(), Error> {
    let plan = Plan::new(models, options)?;
    let (begin, end) = plan.range;
    let columns = plan.designs.columns();
    let (mut journal, done) = Journal::open(&plan.out, &plan.title(), &columns)?;
    if done > 0 {
        print(&format!("continues after {} of an interrupted sweep", counted(done as u64, "design")));
    }
    watch_interrupts();
    let (written, warned) = plan.run(&mut journal, done)?;
    if written < end {
        let (count, all) = (written - begin, counted((end - begin) as u64, "design"));
        let path = journal.path().display();
        return Err(Error::run(format!("interrupted after {count} of {all}, which stand in {path}"))
            .help("the same command continues from there"));
    }
    let (done, failed) = journal.counts();
    journal.finish(&plan.out)?;
    if options.shard.is_some() {
        Part::save(&plan.identity(), plan.designs.count(), plan.range, &columns, &plan.out)?;
    }
    let units = write_units(&plan.out, &columns).map_err(Error::while_running)?;
    let checked = self_check::compare(&plan.designs, plan.range);
    let gpu_failure =
        plan.designs.gpu_failure().map(|failure| format!("\n\n{}", failure.warning())).unwrap_or_default();
    print(&format!(
        "{}: {}, {done} done, {failed} failed{}{}{}\n\nwrote {} (units in {})",
        plan.designs.setup.description.name,
        counted((done + failed) as u64, "design"),
        plan.designs.on_gpu("design").map(|on| format!(", {on}")).unwrap_or_default(),
        checked.as_ref().map(ToString::to_string).unwrap_or_default(),
        warned.text() + &gpu_failure,
        plan.out.display(),
        units.file_name().unwrap_or_default().display()
    ));
    checked.map_err(self_check::Difference::error)?;
    if done == 0 && failed > 0 {
        return Err(Error::run("no design came to its end; the column `reason` says why"));
    }
    Ok(())
}

/// A planned sweep.
struct Plan<'s> {
    options: &'s Options,
    designs: Designs,
    /// The first design of this part, and the first one after it.
    range: (usize, usize),
    threads: usize,
    out: PathBuf,
}

impl<'s> Plan<'s> {
    fn new(models: &'static [Model], options: &'s Options) -> Result<Self, Error> {
        let setup = Setup::without_rewrites(options.scene.name.find(models)?, &options.scene, &by_lanes(&options.how))?;
        let axes = Axes::new(setup.description, &options.vary)?;
        let range = match &options.shard {
            Some(shard) => axes::shard(shard, axes.count())?,
            None => (0, axes.count()),
        };
        let out = options.out.clone().unwrap_or_else(|| default_folder(&setup.path).join("sweep.csv"));
        let format = Format::from_path(&out)?;
        if options.shard.is_some() && format != Format::Csv {
            return Err(Error::usage("a part of a sweep is written as CSV")
                .help("let `--out` end in `.csv`; `qrm merge OUT.parquet PART...` writes Parquet"));
        }
        format.require()?;
        if options.device == Processor::Gpu && options.lanes != Lanes::Most {
            return Err(Error::usage("`--lanes` is for the cores").help("leave it out, or `--device gpu`"));
        }
        let threads = threads(options.threads);
        let designs = Designs::new(setup, axes)?.on(options.device, (range.1 - range.0, threads))?;
        designs.setup.print_notes();
        let designs = Designs {
            has_extremes: !options.no_extremes,
            estimate_error: !options.no_error_estimate,
            lanes: options.lanes.count(),
            ..designs
        };
        Ok(Self { options, designs, range, threads, out })
    }

    /// A line that identifies a sweep; its parts share it.
    fn identity(&self) -> String {
        let Options { scene, how, vary, no_extremes, no_error_estimate, lanes, device, .. } = self.options;
        // Four lanes and eight give identical results.
        let is_single = *lanes == Lanes::One;
        let MethodOptions { method: _, tolerance, max_step, projection, closure_tolerance, closure_iterations } = how;
        let name = self.designs.setup.settings.method.name;
        let how = (name, tolerance, max_step, projection, closure_tolerance, closure_iterations);
        let asked = format!("{scene:?} {how:?} {vary:?} {no_extremes} {no_error_estimate} {is_single} {device:?}");
        let Description { name, source, .. } = self.designs.setup.description;
        format!("{name} {} {:016x}", env!("CARGO_PKG_VERSION"), digest(source.bytes().chain(asked.bytes())))
    }

    /// A line that identifies the table of a sweep.
    fn title(&self) -> String {
        let (begin, end) = self.range;
        format!("{}, designs {begin} to {end}", self.identity())
    }

    /// Runs all remaining designs; returns the first that was not written, and the warnings.
    fn run(&self, journal: &mut Journal, done: usize) -> Result<(usize, Warned), Error> {
        let (begin, end) = self.range;
        let progress = Progress::designs(end - begin, done);
        let (mut warned, mut design) = (Warned::default(), begin + done);
        let written = self.designs.run((begin + done, end), self.threads, Block::from, |block| {
            journal.write(&block)?;
            let count = block.done + block.failed;
            progress.add(count);
            block.warnings.into_iter().for_each(|(place, warnings)| warned.take(design + place, warnings));
            design += count;
            Ok(())
        })?;
        Ok((written, warned))
    }
}

/// The designs whose runs have warnings.
#[derive(Default)]
struct Warned {
    count: u64,
    /// The first of them, and its warnings.
    first: Option<(usize, Vec<Message>)>,
}

impl Warned {
    /// Takes the warnings of a design; there is at least one.
    fn take(&mut self, design: usize, warnings: Vec<Message>) {
        self.count += 1;
        self.first.get_or_insert((design, warnings));
    }

    /// The number of these designs, and the warnings of the first.
    fn text(&self) -> String {
        let Some((design, warnings)) = &self.first else { return String::new() };
        let count = counted(self.count, "design");
        let of = |warning: &Message| {
            let text = format!("in {count}, first in design {design}: {}", warning.text);
            format!("\n\n{}", Message { text, help: warning.help.clone() }.warning())
        };
        warnings.iter().map(of).collect()
    }
}
