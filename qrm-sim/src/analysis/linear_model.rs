//! Linear models about an equilibrium: state-space matrices from parameters of loads to coordinates and outputs.

mod frequency_response;
mod matrices;

use nalgebra::DMatrix;
use qrm_core::{Mechanism, Tape};

use super::equilibria::Equilibrium;
use super::modes::{Modes, NoModes, RestEquations, RestState};
use crate::position::LoopSolver;
use matrices::{Matrices, OutputDerivatives};

/// A linear model: `x' = A x + B u`, `y = C x + D u`, where states, inputs and outputs are deviations from those at the
/// equilibrium.
#[derive(Clone, Debug)]
pub struct LinearModel {
    /// The independent coordinates: they and then their rates are the states.
    pub independent: Vec<usize>,
    /// `A`, `B`, `C` and `D`, row by row.
    pub matrices: [Vec<Vec<f64>>; 4],
    /// Their estimated errors.
    pub errors: [Vec<Vec<f64>>; 4],
    /// The outputs at the equilibrium.
    pub values: Vec<f64>,
}

/// An output of a linear model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LinearOutput {
    /// A coordinate.
    Coordinate(usize),
    /// Its rate.
    Rate(usize),
    /// Its acceleration.
    Acceleration(usize),
    /// An output of the scene.
    Output(usize),
}

/// Linearizes a mechanism about an equilibrium, from parameters to outputs. `modes` are those about it.
///
/// Inputs are parameters of loads alone. The independent coordinates are those that the start gives, where they
/// determine the position well, else others. Accelerations and multipliers, and outputs that take them, respond to
/// states and inputs as the linear equations say.
///
/// # Errors
/// An input changes constraints or masses, or an output has no derivatives: see [`NoModes`].
pub fn linear_model(
    mechanism: &dyn Mechanism,
    tape: &Tape,
    (equilibrium, modes): (&Equilibrium, &Modes),
    inputs: &[usize],
    outputs: &[LinearOutput],
) -> Result<LinearModel, NoModes> {
    let mut equations = RestEquations::new(mechanism, tape);
    let at = equations.at(&equilibrium.q, &equilibrium.preferred)?;
    let by = equations.by_parameters(&at);
    for &parameter in inputs {
        if by.changes_constraints[parameter] || by.changes_mass[parameter] {
            return Err(NoModes::NotALoad { parameter, changes_constraints: by.changes_constraints[parameter] });
        }
    }
    let derivatives = OutputDerivatives::new(&mut equations, &at, inputs, outputs)?;
    let matrices = Matrices::new(&at, by.forces.select_columns(inputs), &derivatives)?;
    let found = matrices.state_space();
    let rounding = matrices.rounding();
    let moved = moved(&mut equations, &at, modes).map(|at| {
        let by = equations.by_parameters(&at);
        let derivatives = OutputDerivatives::new(&mut equations, &at, inputs, outputs)?;
        Ok::<_, NoModes>(Matrices::new(&at, by.forces.select_columns(inputs), &derivatives)?.state_space())
    });
    let mut errors = rounding;
    if let Some(moved) = moved {
        for ((error, own), other) in errors.iter_mut().zip(&found).zip(&moved?) {
            *error += (own - other).abs();
        }
    }
    Ok(LinearModel {
        independent: at.null_space.independent.clone(),
        matrices: found.each_ref().map(rows),
        errors: errors.each_ref().map(rows),
        values: derivatives.values,
    })
}

/// The equations where the independent coordinates are off by their errors; `None` if these are zero.
fn moved(equations: &mut RestEquations, at: &RestState, modes: &Modes) -> Option<RestState> {
    let held = at.null_space.is_independent();
    let mut q = at.q.clone();
    let moves = held.iter().zip(&modes.q_errors).map(|(held, error)| if *held { *error } else { 0.0 });
    q.iter_mut().zip(moves).for_each(|(q, error)| *q += error);
    if q == at.q {
        return None;
    }
    let position = LoopSolver::new(equations.mechanism, held.clone())?.solve_loops(q)?;
    equations.at(&position.q, &held).ok()
}

fn rows(matrix: &DMatrix<f64>) -> Vec<Vec<f64>> {
    // Adding zero turns -0 into 0.
    matrix.row_iter().map(|row| row.iter().map(|entry| entry + 0.0).collect()).collect()
}
