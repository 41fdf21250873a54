//! The function for inverse dynamics.

use super::Writer;
use super::kernel::Emitter;
use crate::graph::Signed;
use crate::kernel::Kernel;
use qrm_core::named_tape::Argument;

/// Adds the function for the forces and torques along the independent coordinates, and for the multipliers.
pub(super) fn add_inverse_dynamics(writer: &Writer, kernel: &Kernel) {
    let (places, forces): (Vec<usize>, Vec<Signed>) = kernel.forces.iter().copied().unzip();
    let arguments = [Argument::Time, Argument::Coordinates, Argument::Rates, Argument::Accelerations];
    let mut function = Emitter::new(writer, kernel, false).function_without_position(
        "inverse_dynamics",
        &arguments,
        &[&forces, &kernel.multipliers],
    );
    let names: Vec<String> = places.iter().map(|i| format!("`{}`", writer.scene.coordinates[*i].name)).collect();
    let along = if names.is_empty() { String::new() } else { format!(" along {}", names.join(", ")) };
    function.doc = format!(
        "Inverse dynamics: the forces and torques{along} that accelerations take beside the loads, and the\n\
         multipliers: `Mbar qdd + C_q' lambda = fbar + forces`. Positions, rates and accelerations keep the \
         constraints."
    );
    writer.add(function);
    writer.tape.borrow_mut().actuated = places;
}
