//! The table of subcommands.

use clap::Subcommand;
use qrm_core::Model;

use crate::error::Error;

/// Declares the modules of the subcommands, each with its `Options` and its function `run`, and the enum for clap.
macro_rules! commands {
    ($($(#[doc = $doc:literal])+ $name:ident: $module:ident,)+) => {
        $(pub(crate) mod $module;)+

        #[derive(Subcommand)]
        pub(crate) enum Command {
            $($(#[doc = $doc])+ $name(Box<$module::Options>),)+
        }

        impl Command {
            /// Runs the subcommand.
            pub(crate) fn run(&self, models: &'static [Model]) -> Result<(), Error> {
                match self {
                    $(Self::$name(options) => $module::run(models, options),)+
                }
            }
        }
    };
}

commands! {
    /// Run a scene: trajectory.csv, summary.json and figures
    Run: run,
    /// Run a scene and show it moving: animation.html and animation.gif
    Animate: animate,
    /// Show a scene moving in a browser, and follow its file
    Live: live,
    /// Write a page that simulates a scene in any browser, with a slider for each parameter: SCENE.html
    Page: page,
    /// Run a scene and show all of its results on one page: report.html
    Report: report,
    /// Measure run time and error of every method: accuracy.csv and accuracy.svg
    Accuracy: accuracy,
    /// Report eigenvalues and stability limits along the motion, and test every method on the scene's extreme cases:
    /// stability.csv, stability.json, stability.svg, extremes.csv
    Stability: stability,
    /// Find the periodic motion that a scene settles into, and its Floquet multipliers: one period as files of a run,
    /// and steady.json
    Steady: steady,
    /// Find the equilibria of a scene, its natural frequencies and mode shapes, and their derivatives by parameters:
    /// modes.json, modes.csv, mode-1.gif
    Modes: modes,
    /// Write a linear model about an equilibrium, from parameters of loads to outputs, and its frequency response:
    /// linear.json, linear.m, frequency_response.csv, frequency_response.svg
    Linearize: linearize,
    /// Derivatives of the end of a motion, and of its outputs, by parameters: sensitivity.csv
    Sensitivity: sensitivity,
    /// Forces and torques needed for a prescribed motion: inverse.csv, inverse.json, inverse.svg
    Inverse: inverse,
    /// Prove intervals that contain the motion: certify.json
    Certify: certify,
    /// Run a scene with many combinations of parameters: one row a design, in CSV or Parquet
    Sweep: sweep,
    /// Propagate tolerances of parameters by linearization, worst case and Monte Carlo: tolerance.json, tolerance.svg
    Tolerance: tolerance,
    /// Join the parts of a sweep that was run with `--shard`
    Merge: merge,
    /// Pack a scene for simulation tools, as an FMU (FMI 3.0) for co-simulation and model exchange: SCENE.fmu
    ExportFmu: export_fmu,
    /// Serve an editor: mistakes while typing, completion, values at the start, renaming (language server protocol)
    Lsp: lsp,
    /// Write a JSON schema of scene files, for the completion of keys in TOML editors
    Schema: schema,
    /// Check a mechanism: strokes, limit positions, forces at rest, energy, recurrence
    Check: check,
    /// Say what the generated code of a scene costs, and what was left out of it and why
    Explain: explain,
    /// Print the generated code of a scene, or write it in C or MATLAB
    Code: code,
    /// Write the derivation of a scene's equations: derivation.md
    Derive: derive,
    /// List the scenes and their parameters
    List: list,
    /// Write a scene to begin with: NAME.toml
    New: new,
    /// Write the scene of a model of another program (PMKS, Ondsel, MJCF): NAME.toml
    Import: import,
}
