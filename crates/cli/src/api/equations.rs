//! The equations of motion at one state, in numbers.

use qrm_sim::integrate::StepError;
use qrm_sim::run::StartError;
use qrm_sim::solve::{Dynamics, LoopConstraints, Solver};

use super::options::RunOptions;
use super::scene::LoadedScene;
use crate::error::Error;

/// The terms of `Mbar qdd + C_q' lambda = fbar`, `C_q qdd + bias = 0` and of the constraints `C = 0` at a state, and
/// their solution. Matrices are stored row by row.
#[derive(Clone, Debug)]
pub struct EquationsOfMotion {
    /// Mbar, `n` by `n`.
    pub mass_matrix: Vec<f64>,
    /// fbar, `n`.
    pub generalized_forces: Vec<f64>,
    /// C, `m`.
    pub residuals: Vec<f64>,
    /// C_q, `m` by `n`.
    pub constraint_jacobian: Vec<f64>,
    /// C_t, `m`.
    pub constraint_rate: Vec<f64>,
    /// `(C_q qd)_q qd + 2 C_qt qd + C_tt`, `m`.
    pub constraint_bias: Vec<f64>,
    /// qdd, `n`.
    pub accelerations: Vec<f64>,
    /// lambda, `m`.
    pub multipliers: Vec<f64>,
    /// The outputs.
    pub outputs: Vec<f64>,
    /// The kinetic energy and the potential of the conservative loads, in J.
    pub energy: [f64; 2],
}

impl LoadedScene {
    /// Computes the equations of motion at a time; coordinates and rates need not satisfy the constraints.
    ///
    /// # Errors
    /// An option is invalid, a vector has the wrong length, or the accelerations are not determined.
    pub fn equations(&self, options: &RunOptions, t: f64, q: &[f64], qd: &[f64]) -> Result<EquationsOfMotion, Error> {
        let setup = self.setup(options)?;
        if !t.is_finite() {
            return Err(Error::usage(format!("`t` must be finite, but is {t}")));
        }
        let count = setup.description.coordinates.len();
        for (name, vector) in [("q", q), ("qd", qd)] {
            if vector.len() != count {
                let names: Vec<&str> = setup.description.coordinates.iter().map(|c| c.name).collect();
                let text = format!("`{name}` has {} entries instead of {count}", vector.len());
                return Err(Error::usage(text).help(format!("give one for each of {}", names.join(", "))));
            }
            if !vector.iter().all(|entry| entry.is_finite()) {
                return Err(Error::usage(format!("`{name}` must be finite, but is {vector:?}")));
            }
        }
        let mechanism = &*setup.mechanism();
        let Dynamics { mass_matrix, generalized_forces, constraint_jacobian, constraint_bias } =
            Dynamics::at(mechanism, t, q, qd);
        let LoopConstraints { residuals, constraint_rate, .. } = LoopConstraints::at(mechanism, t, q);
        let (mut accelerations, mut multipliers) = (vec![0.0; count], vec![0.0; residuals.len()]);
        Solver::at(mechanism, t, q)
            .accelerations(mechanism, t, (q, qd), (&mut accelerations, &mut multipliers))
            .map_err(|reason| setup.no_start(&StartError::Step(StepError::from(reason))))?;
        let mut outputs = vec![f64::NAN; setup.description.outputs.len()];
        mechanism.outputs(t, q, qd, &accelerations, &multipliers, &mut outputs);
        Ok(EquationsOfMotion {
            mass_matrix: mass_matrix.entries().to_vec(),
            generalized_forces,
            residuals,
            constraint_jacobian: constraint_jacobian.entries().to_vec(),
            constraint_rate,
            constraint_bias,
            accelerations,
            multipliers,
            outputs,
            energy: mechanism.energy(q, qd),
        })
    }

    /// Computes coordinates and rates at the start of the motion, which satisfy the constraints.
    ///
    /// # Errors
    /// An option is invalid, or the mechanism cannot be assembled.
    pub fn start(&self, options: &RunOptions) -> Result<[Vec<f64>; 2], Error> {
        let setup = self.setup(options)?;
        setup.first_state()
    }
}
