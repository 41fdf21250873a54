//! The command `qrm` with the scenes of this workspace. All it does is bring the two together, so that a changed scene
//! recompiles little.

use std::process::ExitCode;

fn main() -> ExitCode {
    let mut scenes = qrm_sim::scenes::Scenes::default();
    qrm_model::visit_all(&mut scenes);
    qrm_sim::command::main(&scenes)
}
