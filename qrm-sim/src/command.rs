//! The command `qrm`.

mod account;
mod accuracy;
mod animate;
mod check;
mod code;
mod condition;
mod derive;
mod digest;
mod late;
mod list;
mod progress;
mod recorder;
mod report;
mod run;
mod settings;
mod setup;
mod words;

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering};

use clap::{Args, Parser, Subcommand, ValueEnum};

use crate::projection::{Projection, Tolerance};
use crate::scenes::Scenes;
use crate::whole::write_whole;

/// Simulates mechanisms with closed loops from generated equations of motion.
///
/// Without a command, runs the scene `quick-return`.
#[derive(Parser)]
#[command(name = "qrm", version)]
struct Arguments {
    #[command(subcommand)]
    command: Option<Task>,
}

#[derive(Subcommand)]
enum Task {
    /// Run a scene: trajectory.csv, summary.json and figures
    Run(Box<RunArguments>),
    /// Run a scene and show it moving: animation.html and animation.gif
    Animate(Box<AnimateArguments>),
    /// Run a scene and put all that is known of it on one page: report.html
    Report(Box<ReportArguments>),
    /// Measure run time and error of every method: accuracy.csv and accuracy.svg
    Accuracy(Box<AccuracyArguments>),
    /// Check a mechanism: strokes, locks, forces at rest, energy, recurrence
    Check(Box<CheckArguments>),
    /// Print the generated code of a scene
    Code(CodeArguments),
    /// Write the derivation of a scene's equations: derivation.md
    Derive(DeriveArguments),
    /// List the scenes and their parameters
    List,
}

/// Which scene, with which parameters.
#[derive(Args)]
struct SceneArguments {
    /// Name of the scene; `qrm list` shows them
    #[arg(default_value = "quick-return")]
    scene: String,
    /// Give a parameter another value, such as `O2A=0.25` or `w0=3*pi`
    #[arg(long = "set", value_name = "NAME=VALUE", allow_hyphen_values = true)]
    set: Vec<String>,
    /// Step of the integration in seconds; of the rows, if the method chooses its steps [default: the scene's]
    #[arg(long, value_name = "H", allow_hyphen_values = true)]
    step: Option<String>,
    /// End at this time in seconds, whatever the scene says
    #[arg(long, value_name = "T", conflicts_with = "until", allow_hyphen_values = true)]
    end_time: Option<String>,
    /// End when a condition becomes true, such as `phi2 >= 2*pi`; at the scene's latest end at the latest
    #[arg(long, value_name = "EXPR", allow_hyphen_values = true)]
    until: Option<String>,
}

/// How it is run.
#[derive(Args)]
struct MethodArguments {
    /// Integration method
    #[arg(long, value_enum, default_value_t = MethodName::Rk4)]
    method: MethodName,
    /// Largest error of a step of a method that chooses its steps, in the unit of each coordinate and rate
    /// [default: 1e-9]
    #[arg(long, value_name = "TOLERANCE", allow_hyphen_values = true)]
    tolerance: Option<String>,
    /// What is smallest in the correction after each step: nothing is corrected, the change of the coordinates, or
    /// the mass-weighted change
    #[arg(long, value_enum, default_value_t = ProjectionName::Mass)]
    projection: ProjectionName,
    /// Largest residual of a constraint that needs no further correction
    #[arg(long, value_name = "TOLERANCE", allow_hyphen_values = true)]
    closure_tolerance: Option<String>,
    /// Most corrections of position after a step
    #[arg(long, value_name = "N", default_value_t = 10)]
    closure_iterations: u32,
}

impl Default for MethodArguments {
    fn default() -> Self {
        Self {
            method: MethodName::Rk4,
            tolerance: None,
            projection: ProjectionName::Mass,
            closure_tolerance: None,
            closure_iterations: Tolerance::default().iterations,
        }
    }
}

#[derive(Parser)]
struct RunArguments {
    #[command(flatten)]
    scene: SceneArguments,
    #[command(flatten)]
    method: MethodArguments,
    /// Write every Nth row only; the last row is always written
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u64).range(1..))]
    every: u64,
    /// Skip the second run, at twice the step, that estimates the error
    #[arg(long)]
    no_error_estimate: bool,
    /// Draw no figures
    #[arg(long)]
    no_figures: bool,
    /// Folder for the files [default: out/SCENE]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

#[derive(Args)]
struct AnimateArguments {
    #[command(flatten)]
    scene: SceneArguments,
    #[command(flatten)]
    method: MethodArguments,
    /// Make no GIF, only the page
    #[arg(long)]
    no_gif: bool,
    /// Folder for the files [default: out/SCENE]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

#[derive(Args)]
struct ReportArguments {
    #[command(flatten)]
    scene: SceneArguments,
    #[command(flatten)]
    method: MethodArguments,
    /// Folder for the file [default: out/SCENE]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

#[derive(Args)]
struct CheckArguments {
    #[command(flatten)]
    scene: SceneArguments,
    #[command(flatten)]
    method: MethodArguments,
    /// Only say what balances the loads at rest, at a position such as `phi2=45deg`; may be repeated
    #[arg(long = "static", value_name = "NAME=VALUE", allow_hyphen_values = true)]
    at_rest: Vec<String>,
}

#[derive(Args)]
struct AccuracyArguments {
    #[command(flatten)]
    scene: SceneArguments,
    /// Compare at this time in seconds; may be repeated [default: eight times up to the end]
    #[arg(long, value_name = "T", allow_hyphen_values = true)]
    at: Vec<String>,
    /// What to compare with [default: the first of these that there is]
    #[arg(long, value_enum)]
    reference: Option<ReferenceName>,
    /// Begin no further measurement after this time, such as `30s`
    #[arg(long, value_name = "TIME", default_value = "30s", allow_hyphen_values = true)]
    budget: String,
    /// Folder for the files [default: out/SCENE]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

#[derive(Args)]
struct CodeArguments {
    /// Name of the scene; `qrm list` shows them
    #[arg(default_value = "quick-return")]
    scene: String,
    /// A function such as `com_jacobian`, or its symbol: `T`, `C_q`, `Mbar`
    function: Option<String>,
}

#[derive(Args)]
struct DeriveArguments {
    /// Name of the scene; `qrm list` shows them
    #[arg(default_value = "quick-return")]
    scene: String,
    /// Folder for the file [default: out/SCENE]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

#[derive(Clone, Copy, ValueEnum)]
enum MethodName {
    /// Classical Runge-Kutta, order 4, fixed step
    Rk4,
    /// Dormand-Prince pair of order 5, steps chosen by --tolerance
    Dopri5,
    /// Dormand-Prince pair of order 8, steps chosen by --tolerance
    Dop853,
    /// The assignment's script: RK4 with Euclidean projection, what it derives from the states late or differenced
    Document,
}

impl MethodName {
    fn name(self) -> &'static str {
        match self {
            Self::Rk4 => "rk4",
            Self::Dopri5 => "dopri5",
            Self::Dop853 => "dop853",
            Self::Document => "document",
        }
    }
}

/// Where exact values may come from.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum ReferenceName {
    /// The energy integral of a conservative motion with one freedom that does not turn back
    Energy,
    /// Values in the scene's [reference], if no parameter is changed
    Scene,
    /// The method of order 8 at two tight tolerances
    Run,
}

#[derive(Clone, Copy, ValueEnum)]
enum ProjectionName {
    None,
    Euclidean,
    Mass,
}

impl ProjectionName {
    fn projection(self) -> Projection {
        match self {
            Self::None => Projection::None,
            Self::Euclidean => Projection::Euclidean,
            Self::Mass => Projection::Mass,
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Euclidean => "euclidean",
            Self::Mass => "mass",
        }
    }
}

/// How a command ended without reaching its goal.
enum Failure {
    /// The run itself failed; its files tell how far it got. Exit status 1.
    Run(String),
    /// The command or the scene is wrong. Exit status 2.
    Use(String),
}

/// Runs the command with the scenes it was built with.
pub fn main(scenes: &Scenes) -> ExitCode {
    let default = || Task::Run(Box::new(RunArguments::parse_from(["qrm"])));
    let result = match Arguments::parse().command.unwrap_or_else(default) {
        Task::Run(arguments) => run::run(scenes, &arguments),
        Task::Animate(arguments) => animate::animate(scenes, &arguments),
        Task::Report(arguments) => report::report(scenes, &arguments),
        Task::Accuracy(arguments) => accuracy::accuracy(scenes, &arguments),
        Task::Check(arguments) => check::check(scenes, &arguments),
        Task::Code(arguments) => code::code(scenes, &arguments),
        Task::Derive(arguments) => derive::derive(scenes, &arguments),
        Task::List => {
            say(&list::list(scenes));
            Ok(())
        }
    };
    let (message, status) = match result {
        Ok(()) if UNSAID.load(Ordering::Relaxed) => ("error: cannot write to the standard output".to_owned(), 1),
        Ok(()) => return ExitCode::SUCCESS,
        Err(Failure::Run(message)) => (message, 1),
        Err(Failure::Use(message)) => (message, 2),
    };
    let _ = writeln!(std::io::stderr(), "{message}");
    ExitCode::from(status)
}

/// Writes a file of a command, in a folder that is made if it is not there.
fn write(path: &Path, bytes: &[u8]) -> std::io::Result<()> {
    path.parent().map_or(Ok(()), std::fs::create_dir_all)?;
    write_whole(path, bytes)
}

/// What is said when a file cannot be written.
fn unwritable(path: &Path, e: &std::io::Error) -> String {
    format!("error: cannot write {}: {e}\n  = help: choose another folder with --out DIR", path.display())
}

/// Prints to standard output, to which nobody may be listening any more.
fn say(text: &str) {
    let mut out = std::io::stdout();
    if let Err(e) = writeln!(out, "{text}").and_then(|()| out.flush())
        && e.kind() != std::io::ErrorKind::BrokenPipe
    {
        UNSAID.store(true, Ordering::Relaxed);
    }
}

/// Set when something could not be printed.
static UNSAID: AtomicBool = AtomicBool::new(false);
