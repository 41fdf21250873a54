//! The command `qrm` with the scenes of this workspace, and the same scenes as a library for simulation tools (FMI 3.0). All it does is
//! bring the parts together, so that a changed scene recompiles little.

use std::process::ExitCode;

/// Runs the command.
pub fn main() -> ExitCode {
    let mut scenes = qrm_sim::scenes::Scenes::default();
    qrm_model::visit_all(&mut scenes);
    qrm_sim::command::main(&scenes)
}

#[cfg(feature = "fmu")]
qrm_fmu::export!(qrm_model::visit_all);
