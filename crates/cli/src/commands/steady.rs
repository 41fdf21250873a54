//! `qrm steady`

mod branch;
mod branch_report;
mod branch_table;
mod columns;
mod condition;
mod failure;
mod period;
mod report;
mod solve;

use std::path::Path;

use clap::Args;
use qrm_core::Model;
use qrm_scene::names::suggestion;
use qrm_sim::analysis::{SteadyMotion, SteadyRequest, steady_motion};
use qrm_sim::integrate::AUTO;

use crate::error::Error;
use crate::options::{MethodOptions, OutFolder, PlotOptions, SceneName, SceneOptions, StartOptions, optional_positive};
use crate::output::{check_target, print, save_json};
use crate::plots::Plots;
use crate::progress::{interrupted, watch_interrupts};
use crate::run_files::{FinishedRun, RunFiles};
use crate::setup::Setup;
use branch::Vary;
pub(crate) use report::SteadyReport;
use solve::Solved;

#[derive(Args)]
pub(crate) struct Options {
    #[command(flatten)]
    name: SceneName,
    /// Give a parameter another value, such as `O2A=0.25` or `w0=3*pi`
    #[arg(long = "set", value_name = "NAME=VALUE", allow_hyphen_values = true)]
    set: Vec<String>,
    #[command(flatten)]
    start: StartOptions,
    #[command(flatten)]
    search: SearchOptions,
    /// Follow the motion over a parameter, around folds, such as `w=0.5:2`: branch.csv, branch.json and branch.svg
    #[arg(long, value_name = "NAME=FROM:TO", allow_hyphen_values = true)]
    #[arg(conflicts_with_all = ["rows", "no_figures", "plot"])]
    vary: Option<String>,
    /// Most points of a branch
    #[arg(long, value_name = "N", default_value_t = 1000, requires = "vary")]
    #[arg(value_parser = clap::value_parser!(u32).range(2..=1_000_000))]
    points: u32,
    #[command(flatten)]
    method: MethodOptions,
    /// Draw no figures
    #[arg(long, conflicts_with = "plot")]
    no_figures: bool,
    #[command(flatten)]
    plots: PlotOptions,
    #[command(flatten)]
    out: OutFolder,
}

/// The motion that is sought.
#[derive(Args, Clone, Debug)]
pub(crate) struct SearchOptions {
    /// Period of the loads and drives in seconds [default: that of the sines in their formulae]; a motion that does not
    /// depend on time has its own
    #[arg(long, value_name = "T", allow_hyphen_values = true)]
    pub(crate) period: Option<String>,
    /// Coordinate whose turns or oscillations are the cycles of a motion with a period of its own [default: the first
    /// one that the scene gives at its start]
    #[arg(long, value_name = "NAME")]
    pub(crate) phase: Option<String>,
    /// Number of cycles in the period that is sought
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub(crate) cycles: u32,
    /// Number of periods of the ordinary motion before the search; with 0 it begins at the start
    #[arg(long, value_name = "N", default_value_t = 30, value_parser = clap::value_parser!(u32).range(..=1_000_000))]
    pub(crate) settle: u32,
    /// Find the value of a parameter with which the motion meets the condition of `--for`
    #[arg(long, value_name = "NAME", requires = "condition", conflicts_with = "vary")]
    pub(crate) solve: Option<String>,
    /// Condition on a rate or an output, such as `fluctuation(phi_dot) = 0.02`; others are mean, min, max and work
    #[arg(long = "for", value_name = "CONDITION", requires = "solve")]
    pub(crate) condition: Option<String>,
    /// Number of rows in the period
    #[arg(long, value_name = "N", default_value_t = 720, value_parser = clap::value_parser!(u32).range(4..=1_000_000))]
    pub(crate) rows: u32,
}

/// The default tolerance.
const TOLERANCE: &str = "1e-12";

/// Finds the steady motion of a scene, prints it and writes its files.
pub(crate) fn run(models: &'static [Model], options: &Options) -> Result<(), Error> {
    let how = method_options(&options.method)?;
    let scene =
        SceneOptions { name: options.name.clone(), set: options.set.clone(), step: None, end_time: None, until: None };
    let (vary, setup) = match &options.vary {
        Some(vary) => {
            let (vary, setup) = Vary::setup(models, vary, &scene, &how)?;
            (Some(vary), setup)
        }
        None => (None, Setup::new(models, &scene, &how)?),
    };
    let setup = setup.starting_from(&options.start)?;
    let folder = options.out.subfolder(&setup.path, "steady");
    watch_interrupts();
    if let Some(vary) = vary {
        let request = options.search.request(&setup)?;
        return branch::run(setup, &vary, request, options.points as usize, &folder);
    }
    one(setup, options, &folder)
}

/// The method and tolerance of a search.
///
/// # Errors
/// The method has fixed steps.
pub(crate) fn method_options(options: &MethodOptions) -> Result<MethodOptions, Error> {
    let method = options.method.unwrap_or(AUTO);
    if !method.is_adaptive() {
        let name = method.name;
        return Err(Error::usage(format!("`--method {name}` has fixed steps, and the period is not known before"))
            .help("leave `--method` out, or choose `dop853`"));
    }
    let tolerance = options.tolerance.clone().unwrap_or_else(|| TOLERANCE.to_owned());
    Ok(MethodOptions { method: Some(method), tolerance: Some(tolerance), ..options.clone() })
}

impl SearchOptions {
    /// The request for a motion of a scene.
    ///
    /// # Errors
    /// The scene does not suit the options.
    fn request(&self, setup: &Setup) -> Result<SteadyRequest<'static>, Error> {
        setup.refuse_redundant(&setup.first_state()?[0])?;
        let period = self.period(setup)?;
        let phase = match (period, &self.phase) {
            (None, name) => Some(phase(setup, name.as_deref())?),
            (Some(_), None) => None,
            (Some(_), Some(_)) => {
                return Err(Error::usage(
                    "`--phase`: loads or drives depend on time, and their period is that of the motion",
                )
                .help("leave it out; `--period` and `--cycles` choose another period"));
            }
        };
        Ok(SteadyRequest {
            settings: setup.settings,
            start: Some(setup.start()),
            period,
            phase,
            cycles: self.cycles,
            settle: self.settle,
            keep_running: Some(&|_, _| !interrupted()),
        })
    }

    /// The period that the motion must have; `None` if it has its own.
    fn period(&self, setup: &Setup) -> Result<Option<f64>, Error> {
        period::period(setup, optional_positive("--period", self.period.as_ref(), "s")?)
    }

    /// Finds the motion of a scene, and makes the run of the scene one over its period.
    ///
    /// # Errors
    /// No steady motion exists, or the search does not find it.
    pub(crate) fn find(&self, setup: &mut Setup) -> Result<FoundMotion, Error> {
        let mut request = self.request(setup)?;
        let solved = match self.solve.as_ref().zip(self.condition.as_ref()) {
            Some((name, condition)) => {
                let (solved, start) = Solved::new(setup, &request, name, condition)?;
                (request.start, request.settle) = (Some(start), 0);
                request.period = self.period(setup)?;
                Some(solved)
            }
            None => None,
        };
        let motion = steady_motion(&*setup.mechanism(), setup.model.tape(), &request);
        let motion = motion.map_err(|reason| failure::error(setup, self.cycles, reason))?;
        let step = motion.period / f64::from(self.rows);
        setup.run_over([motion.start.clone(), motion.other_start.clone()], motion.period, step);
        Ok(FoundMotion { motion, phase: request.phase, cycles: self.cycles, settled: self.settle, solved })
    }
}

/// A motion that was found.
pub(crate) struct FoundMotion {
    motion: SteadyMotion,
    /// The coordinate that tells cycles, where the period is that of the motion.
    phase: Option<usize>,
    cycles: u32,
    /// The periods of the ordinary motion before the search.
    settled: u32,
    solved: Option<Solved>,
}

/// Finds one steady motion, prints it and writes its files.
fn one(mut setup: Setup, options: &Options, folder: &Path) -> Result<(), Error> {
    let files = RunFiles { folder, every: 1, has_figures: !options.no_figures, parquet: false };
    files.check_targets()?;
    let path = folder.join("steady.json");
    check_target(&path)?;
    // Mistakes in plots are found before the search.
    Plots::new(&setup, &options.plots)?;
    let found = options.search.find(&mut setup)?;
    let plots = Plots::new(&setup, &options.plots)?;
    let finished = files.run(&setup, true, plots)?;
    let report = SteadyReport::new(&setup, found, &finished.recording, &finished.outcome);
    let FinishedRun { report: of_run, mut problems, .. } = finished;
    let saved = [save_json(&folder.join("summary.json"), &of_run), save_json(&path, &report)];
    print(&report.text(&of_run, folder));
    problems.extend(saved.into_iter().filter_map(Result::err));
    Error::all(problems)
}

/// The coordinate whose cycles are counted.
fn phase(setup: &Setup, name: Option<&str>) -> Result<usize, Error> {
    let (coordinates, given) = (setup.description.coordinates, setup.start().given);
    let names = || (0..given.len()).filter(|&i| given[i]).map(|i| coordinates[i].name);
    let scene = setup.description.name;
    match name {
        Some(name) if names().any(|given| given == name) => {
            Ok(coordinates.iter().position(|coordinate| coordinate.name == name).unwrap_or(0))
        }
        Some(name) => {
            let help =
                suggestion(name, names(), || format!("given at the start: {}", names().collect::<Vec<_>>().join(", ")));
            Err(Error::usage(format!("`--phase {name}`: scene `{scene}` gives no coordinate `{name}` at its start"))
                .help(help))
        }
        None => given.iter().position(|given| *given).ok_or_else(|| {
            Error::usage(format!("scene `{scene}` gives no coordinate at its start that could tell a cycle"))
                .help("give one under [initial]")
        }),
    }
}
