//! The equations of motion at a state, straight from the scene.

use num_dual::Dual2_64;

use super::gradients::Gradients;
use super::sample::Sample;
use crate::term::{Equations, Row};
use qrm_scene::evaluate::State;
use qrm_scene::scene::{Scene, Value as Formula};

impl Sample {
    /// The residual of the equations of motion at the accelerations and multipliers of the sample; `None` outside the
    /// domain of the formulae.
    pub(super) fn residual(&self, scene: &Scene, equations: &Equations) -> Option<Residual> {
        let gradients = Gradients::new(self, scene);
        let plain = State::plain(scene, &self.parameters, self.t, &self.q, &self.qd);
        let rows = self.com_rows(scene, equations, &plain);
        let found = EquationsOfMotion::new(self, &rows, &gradients, &plain);
        let n = self.q.len();
        let dot = |row: &[f64]| row.iter().zip(&self.qdd).map(|(entry, a)| entry * a).sum::<f64>();
        let reaction = |i: usize| {
            let column = found.constraint_jacobian.iter().skip(i).step_by(n);
            column.zip(&self.multipliers).map(|(entry, lambda)| entry * lambda).sum::<f64>()
        };
        let residual = Residual {
            forces: (0..n).map(|i| dot(&found.mass[i * n..(i + 1) * n]) + reaction(i) - found.forces[i]).collect(),
            constraints: found
                .residuals
                .iter()
                .zip(found.constraint_jacobian.chunks(n.max(1)))
                .map(|(residual, row)| dot(row) + residual.v2)
                .collect(),
        };
        residual.forces.iter().chain(&residual.constraints).all(|number| number.is_finite()).then_some(residual)
    }

    /// The formulae of the rows of `T`, each with its mass or moment of inertia.
    pub(super) fn com_rows<'s>(
        &self,
        scene: &'s Scene,
        equations: &Equations,
        plain: &State<f64>,
    ) -> Vec<(&'s Formula, f64)> {
        let row = |row: &Row| {
            let body = &scene.bodies[row.body];
            let (position, inertia) = match row.axis {
                2 => (body.angle.as_ref(), &body.inertia),
                axis => (body.com.as_ref().map(|com| &com[axis]), &body.mass),
            };
            Some((position?, plain.value(inertia.as_ref()?)))
        };
        equations.rows.iter().filter_map(row).collect()
    }
}

/// The residual of the equations of motion: zero in a motion.
pub(super) struct Residual {
    /// `Mbar qdd + C_q' lambda - fbar`
    pub(super) forces: Vec<f64>,
    /// `C_q qdd + bias`
    pub(super) constraints: Vec<f64>,
}

/// The parts of the equations of motion at a state.
pub(super) struct EquationsOfMotion {
    /// The rows of `T` in their second derivative by time.
    pub(super) positions: Vec<Dual2_64>,
    pub(super) jacobian: Vec<Vec<f64>>,
    pub(super) mass: Vec<f64>,
    pub(super) forces: Vec<f64>,
    /// The loop constraints in their second derivative by time.
    pub(super) residuals: Vec<Dual2_64>,
    pub(super) constraint_jacobian: Vec<f64>,
}

impl EquationsOfMotion {
    pub(super) fn new(sample: &Sample, rows: &[(&Formula, f64)], gradients: &Gradients, plain: &State<f64>) -> Self {
        let scene = gradients.scene;
        let n = sample.q.len();
        let moving = State::along(scene, &sample.parameters, sample.t, &sample.q, &sample.qd, &vec![0.0; n]);
        let positions: Vec<Dual2_64> = rows.iter().map(|(row, _)| moving.value(row)).collect();
        let jacobian: Vec<Vec<f64>> = rows.iter().map(|(row, _)| gradients.of(row)).collect();
        let mut mass = vec![0.0; n * n];
        let mut forces = sample.generalized_forces(gradients, plain);
        for (((_, inertia), row), bias) in rows.iter().zip(&jacobian).zip(&positions) {
            // Most rows move with few coordinates of a large mechanism.
            for i in (0..n).filter(|&i| row[i] != 0.0) {
                forces[i] -= inertia * row[i] * bias.v2;
                for j in 0..n {
                    mass[i * n + j] += inertia * row[i] * row[j];
                }
            }
        }
        let constraints = || scene.constraints.iter().map(|c| &c.residual);
        Self {
            positions,
            jacobian,
            mass,
            forces,
            residuals: constraints().map(|row| moving.value(row)).collect(),
            constraint_jacobian: constraints().flat_map(|row| gradients.of(row)).collect(),
        }
    }
}
