//! The options of `qrm tolerance`.

use clap::{Args, ValueEnum};

use crate::gpu::Processor;
use crate::options::{MethodOptions, OutFolder, SceneOptions};

#[derive(Args)]
pub(crate) struct Options {
    #[command(flatten)]
    pub(super) scene: SceneOptions,
    #[command(flatten)]
    pub(super) how: MethodOptions,
    /// Give a parameter a tolerance, `NAME=VALUE+-TOLERANCE`, or `NAME=+-TOLERANCE` about the value that it has; may be
    /// repeated
    #[arg(long, value_name = "NAME=VALUE+-TOL", required = true, allow_hyphen_values = true)]
    pub(super) vary: Vec<String>,
    /// The column of `qrm sweep` to analyse, such as `x6_max` or `end_time`; may be repeated [default: the extremes of
    /// all outputs]
    #[arg(long, value_name = "NAME")]
    pub(super) of: Vec<String>,
    /// Number of Monte Carlo samples
    #[arg(long, value_name = "N", default_value_t = 10_000)]
    #[arg(value_parser = clap::value_parser!(u32).range(100..=100_000_000))]
    pub(super) samples: u32,
    /// How parameters vary within their tolerances
    #[arg(long, value_enum, default_value_t = Distribution::Normal)]
    pub(super) distribution: Distribution,
    /// Seed of the random numbers
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub(super) seed: u64,
    /// Write all samples too: samples.csv
    #[arg(long)]
    pub(super) keep_samples: bool,
    /// How many cores to use [default: all]
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    #[arg(value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub(super) threads: Option<u32>,
    /// The processor that runs the samples
    #[arg(long, value_enum, default_value_t)]
    pub(super) device: Processor,
    #[command(flatten)]
    pub(super) out: OutFolder,
}

/// How a parameter varies within its tolerance.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum Distribution {
    /// About the value with a third of the tolerance as standard deviation
    Normal,
    /// Evenly, from the value minus the tolerance to the value plus it
    Uniform,
}

impl Distribution {
    /// The standard deviation of a parameter against its tolerance.
    pub(super) fn deviation(self) -> f64 {
        match self {
            Self::Normal => 1.0 / 3.0,
            Self::Uniform => 1.0 / 3.0_f64.sqrt(),
        }
    }

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Normal => "normal",
            Self::Uniform => "uniform",
        }
    }
}
