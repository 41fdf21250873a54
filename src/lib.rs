//! The command `qrm` with the scenes of this workspace, and a shared library with the same scenes for simulation tools
//! (FMI 3.0). It only joins the parts, so that a changed scene recompiles little.

use std::process::ExitCode;

/// Runs the command.
pub fn main() -> ExitCode {
    qrm_cli::main(qrm_model::MODELS)
}

qrm_fmu::export!(qrm_model::MODELS);
