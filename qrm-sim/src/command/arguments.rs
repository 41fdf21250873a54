//! What the command line can say.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueEnum};

use crate::projection::{Projection, Tolerance};
#[cfg(feature = "sweep")]
use crate::sweep::Width;

/// Simulates mechanisms with closed loops from generated equations of motion.
///
/// Without a command, runs the scene `quick-return`.
#[derive(Parser)]
#[command(name = "qrm", version)]
pub(super) struct Arguments {
    #[command(subcommand)]
    pub(super) command: Option<Task>,
}

#[derive(Subcommand)]
pub(super) enum Task {
    /// Run a scene: trajectory.csv, summary.json and figures
    Run(Box<RunArguments>),
    /// Run a scene and show it moving: animation.html and animation.gif
    #[cfg(feature = "pictures")]
    Animate(Box<AnimateArguments>),
    /// Run a scene and put all that is known of it on one page: report.html
    #[cfg(feature = "pictures")]
    Report(Box<ReportArguments>),
    /// Measure run time and error of every method: accuracy.csv and accuracy.svg
    #[cfg(feature = "pictures")]
    Accuracy(Box<AccuracyArguments>),
    /// Say how fast a mechanism reacts along its motion, how long steps may be, and what becomes of methods in extreme cases:
    /// stability.csv, stability.json, stability.svg, extremes.csv
    #[cfg(feature = "stability")]
    Stability(Box<StabilityArguments>),
    /// Derivatives of the end of a motion, and of its outputs, by parameters: sensitivity.csv
    #[cfg(feature = "sensitivity")]
    Sensitivity(Box<SensitivityArguments>),
    /// Run a scene with many combinations of parameters: one row a design, in CSV or Parquet
    #[cfg(feature = "sweep")]
    Sweep(Box<SweepArguments>),
    /// Join the parts of a sweep that was run with `--shard`
    #[cfg(feature = "sweep")]
    Merge(MergeArguments),
    /// Pack a scene for simulation tools, as a unit of FMI 3.0 for co-simulation and model exchange: SCENE.fmu
    #[cfg(feature = "fmu")]
    ExportFmu(Box<ExportFmuArguments>),
    /// Check a mechanism: strokes, locks, forces at rest, energy, recurrence
    Check(Box<CheckArguments>),
    /// Say what the generated code of a scene costs, and what was left out of it and why
    Explain(ExplainArguments),
    /// Print the generated code of a scene
    Code(CodeArguments),
    /// Write the derivation of a scene's equations: derivation.md
    Derive(DeriveArguments),
    /// List the scenes and their parameters
    List,
}

/// Which scene, with which parameters.
#[derive(Args, Clone, Debug)]
pub(super) struct SceneArguments {
    /// Name of the scene; `qrm list` shows them
    #[arg(default_value = "quick-return")]
    pub(super) scene: String,
    /// Give a parameter another value, such as `O2A=0.25` or `w0=3*pi`
    #[arg(long = "set", value_name = "NAME=VALUE", allow_hyphen_values = true)]
    pub(super) set: Vec<String>,
    /// Step of the integration in seconds; of the rows, if the method chooses its steps [default: the scene's]
    #[arg(long, value_name = "H", allow_hyphen_values = true)]
    pub(super) step: Option<String>,
    /// End at this time in seconds, whatever the scene says
    #[arg(long, value_name = "T", conflicts_with = "until", allow_hyphen_values = true)]
    pub(super) end_time: Option<String>,
    /// End when a condition becomes true, such as `phi2 >= 2*pi`; at the scene's latest end at the latest
    #[arg(long, value_name = "EXPR", allow_hyphen_values = true)]
    pub(super) until: Option<String>,
}

/// How it is run.
#[derive(Args)]
pub(super) struct MethodArguments {
    /// Integration method
    #[arg(long, value_enum, default_value_t = MethodName::Rk4)]
    pub(super) method: MethodName,
    /// Largest error of a step of a method that chooses its steps, in the unit of each coordinate and rate
    /// [default: 1e-9]
    #[arg(long, value_name = "TOLERANCE", allow_hyphen_values = true)]
    pub(super) tolerance: Option<String>,
    /// What is smallest in the correction after each step: nothing is corrected, the change of the coordinates, or
    /// the mass-weighted change [default: mass; the document's own is euclidean]
    #[arg(long, value_enum)]
    pub(super) projection: Option<ProjectionName>,
    /// Largest residual of a constraint that needs no further correction
    #[arg(long, value_name = "TOLERANCE", allow_hyphen_values = true)]
    pub(super) closure_tolerance: Option<String>,
    /// Most corrections of position after a step
    #[arg(long, value_name = "N", default_value_t = 10)]
    pub(super) closure_iterations: u32,
}

impl Default for MethodArguments {
    fn default() -> Self {
        Self {
            method: MethodName::Rk4,
            tolerance: None,
            projection: None,
            closure_tolerance: None,
            closure_iterations: Tolerance::default().iterations,
        }
    }
}

#[derive(Parser)]
pub(super) struct RunArguments {
    #[command(flatten)]
    pub(super) scene: SceneArguments,
    #[command(flatten)]
    pub(super) method: MethodArguments,
    /// Write every Nth row only; the last row is always written
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u64).range(1..))]
    pub(super) every: u64,
    /// Skip the second run, at twice the step, that estimates the error
    #[arg(long)]
    pub(super) no_error_estimate: bool,
    /// Draw no figures
    #[arg(long)]
    pub(super) no_figures: bool,
    /// Write trajectory.parquet too
    #[cfg(feature = "sweep")]
    #[arg(long)]
    pub(super) parquet: bool,
    /// Folder for the files [default: out/SCENE]
    #[arg(long, value_name = "DIR")]
    pub(super) out: Option<PathBuf>,
}

#[cfg(feature = "sensitivity")]
#[derive(Args)]
pub(super) struct SensitivityArguments {
    #[command(flatten)]
    pub(super) scene: SceneArguments,
    /// By this parameter; may be repeated [default: by all]
    #[arg(long, value_name = "NAME")]
    pub(super) by: Vec<String>,
    /// Of this output, or `end` for the state at the end; may be repeated [default: of all]
    #[arg(long, value_name = "NAME")]
    pub(super) of: Vec<String>,
    /// Skip the runs at other values and at twice the step that check the derivatives
    #[arg(long)]
    pub(super) no_check: bool,
    /// Folder for the file [default: out/SCENE]
    #[arg(long, value_name = "DIR")]
    pub(super) out: Option<PathBuf>,
}

#[cfg(feature = "fmu")]
#[derive(Args)]
pub(super) struct ExportFmuArguments {
    #[command(flatten)]
    pub(super) scene: SceneArguments,
    #[command(flatten)]
    pub(super) method: MethodArguments,
    /// Make a parameter an input that the tool can connect, such as the torque of a motor; may be repeated
    #[arg(long, value_name = "NAME")]
    pub(super) input: Vec<String>,
    /// Folder for the file [default: out/SCENE]
    #[arg(long, value_name = "DIR")]
    pub(super) out: Option<PathBuf>,
}

#[cfg(feature = "sweep")]
#[derive(Args)]
pub(super) struct SweepArguments {
    #[command(flatten)]
    pub(super) scene: SceneArguments,
    /// Vary a parameter: `NAME=FROM:TO:COUNT` or `NAME=VALUE,VALUE,...`; may be repeated, for every combination
    #[arg(long, value_name = "NAME=VALUES", required = true, allow_hyphen_values = true)]
    pub(super) vary: Vec<String>,
    /// Compute one part of the designs only, such as `2/8`; `qrm merge` joins the parts
    #[arg(long, value_name = "K/N")]
    pub(super) shard: Option<String>,
    /// Leave out the smallest and largest values of the outputs
    #[arg(long)]
    pub(super) no_extremes: bool,
    /// Skip the second motion, at twice the step, that estimates the error of each design
    #[arg(long)]
    pub(super) no_error_estimate: bool,
    /// How many cores to use [default: all]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub(super) threads: Option<u32>,
    /// How many designs a core makes at once
    #[arg(long, value_enum, default_value_t = LanesName::Most)]
    pub(super) lanes: LanesName,
    /// The table, ending in `.csv` or `.parquet` [default: out/SCENE/sweep.csv]
    #[arg(long, value_name = "FILE")]
    pub(super) out: Option<PathBuf>,
}

#[cfg(feature = "sweep")]
#[derive(Args)]
pub(super) struct MergeArguments {
    /// The table to write, ending in `.csv` or `.parquet`
    #[arg(value_name = "OUT")]
    pub(super) out: PathBuf,
    /// The parts in their order, in CSV
    #[arg(value_name = "PART", required = true)]
    pub(super) parts: Vec<PathBuf>,
}

#[cfg(feature = "sweep")]
#[derive(Clone, Copy, ValueEnum)]
pub(super) enum LanesName {
    /// As many as the processor has lanes for
    Most,
    /// Four at most
    Four,
    /// One
    One,
}

#[cfg(feature = "sweep")]
impl LanesName {
    pub(super) fn width(self) -> Width {
        match self {
            Self::Most => Width::Most,
            Self::Four => Width::Four,
            Self::One => Width::One,
        }
    }
}

#[cfg(feature = "pictures")]
#[derive(Args)]
pub(super) struct AnimateArguments {
    #[command(flatten)]
    pub(super) scene: SceneArguments,
    #[command(flatten)]
    pub(super) method: MethodArguments,
    /// Make no GIF, only the page
    #[arg(long)]
    pub(super) no_gif: bool,
    /// Folder for the files [default: out/SCENE]
    #[arg(long, value_name = "DIR")]
    pub(super) out: Option<PathBuf>,
}

#[cfg(feature = "pictures")]
#[derive(Args)]
pub(super) struct ReportArguments {
    #[command(flatten)]
    pub(super) scene: SceneArguments,
    #[command(flatten)]
    pub(super) method: MethodArguments,
    /// Measure no run times and errors, which takes a few seconds
    #[arg(long)]
    pub(super) no_accuracy: bool,
    /// Folder for the file [default: out/SCENE]
    #[arg(long, value_name = "DIR")]
    pub(super) out: Option<PathBuf>,
}

#[derive(Args)]
pub(super) struct CheckArguments {
    #[command(flatten)]
    pub(super) scene: SceneArguments,
    #[command(flatten)]
    pub(super) method: MethodArguments,
    /// Only say what balances the loads at rest, at a position such as `phi2=45deg`; may be repeated
    #[arg(long = "static", value_name = "NAME=VALUE", allow_hyphen_values = true)]
    pub(super) at_rest: Vec<String>,
}

#[cfg(feature = "pictures")]
#[derive(Args)]
pub(super) struct AccuracyArguments {
    #[command(flatten)]
    pub(super) scene: SceneArguments,
    /// Compare at this time in seconds; may be repeated [default: eight times up to the end]
    #[arg(long, value_name = "T", allow_hyphen_values = true)]
    pub(super) at: Vec<String>,
    /// What to compare with [default: the energy integral where there is one, unless a run is more certain]
    #[arg(long, value_enum)]
    pub(super) reference: Option<ReferenceName>,
    /// Begin no further measurement after this time, such as `30s`
    #[arg(long, value_name = "TIME", default_value = "30s", allow_hyphen_values = true)]
    pub(super) budget: String,
    /// Folder for the files [default: out/SCENE]
    #[arg(long, value_name = "DIR")]
    pub(super) out: Option<PathBuf>,
}

#[cfg(feature = "stability")]
#[derive(Args)]
pub(super) struct StabilityArguments {
    #[command(flatten)]
    pub(super) scene: SceneArguments,
    /// Leave out the scene's `[[extreme]]` cases
    #[arg(long)]
    pub(super) no_extremes: bool,
    /// Folder for the files [default: out/SCENE]
    #[arg(long, value_name = "DIR")]
    pub(super) out: Option<PathBuf>,
}

#[derive(Args)]
pub(super) struct ExplainArguments {
    /// Name of the scene; `qrm list` shows them
    #[arg(default_value = "quick-return")]
    pub(super) scene: String,
}

#[derive(Args)]
pub(super) struct CodeArguments {
    /// Name of the scene; `qrm list` shows them
    #[arg(default_value = "quick-return")]
    pub(super) scene: String,
    /// A function such as `com_jacobian`, or its symbol: `T`, `C_q`, `Mbar`
    pub(super) function: Option<String>,
}

#[derive(Args)]
pub(super) struct DeriveArguments {
    /// Name of the scene; `qrm list` shows them
    #[arg(default_value = "quick-return")]
    pub(super) scene: String,
    /// Folder for the file [default: out/SCENE]
    #[arg(long, value_name = "DIR")]
    pub(super) out: Option<PathBuf>,
}

#[derive(Clone, Copy, ValueEnum)]
pub(super) enum MethodName {
    /// Classical Runge-Kutta, order 4, fixed step
    Rk4,
    /// Dormand-Prince pair of order 5, steps chosen by --tolerance
    Dopri5,
    /// Dormand-Prince pair of order 8, steps chosen by --tolerance
    Dop853,
    /// dop853, and rodas where springs or dampers are stiff; steps chosen by --tolerance
    Auto,
    /// Linearly implicit method of order 4 for stiff springs and dampers, steps chosen by --tolerance; the scene must say
    /// `stiff = true`
    Rodas,
    /// The assignment's script: RK4 with Euclidean projection, what it derives from the states late or differenced
    Document,
}

impl MethodName {
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Rk4 => "rk4",
            Self::Dopri5 => "dopri5",
            Self::Dop853 => "dop853",
            Self::Auto => "auto",
            Self::Rodas => "rodas",
            Self::Document => "document",
        }
    }
}

/// Where exact values may come from.
#[cfg(feature = "pictures")]
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum ReferenceName {
    /// The energy integral of a conservative motion with one freedom that does not turn back
    Energy,
    /// Values in the scene's [reference], if no parameter is changed
    Scene,
    /// The method of order 8 at two tight tolerances
    Run,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum ProjectionName {
    None,
    Euclidean,
    Mass,
}

impl ProjectionName {
    pub(super) fn projection(self) -> Projection {
        match self {
            Self::None => Projection::None,
            Self::Euclidean => Projection::Euclidean,
            Self::Mass => Projection::Mass,
        }
    }

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Euclidean => "euclidean",
            Self::Mass => "mass",
        }
    }
}
