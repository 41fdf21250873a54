//! The command `qrm` with the scenes of this workspace, and the same scenes as a library for simulation tools (FMI
//! 3.0). All it does is bring the parts together, so that a changed scene recompiles little.

use std::process::ExitCode;

/// Runs the command.
pub fn main() -> ExitCode {
    qrm_cli::main(qrm_model::MODELS)
}

qrm_fmu::export!(qrm_model::MODELS);
