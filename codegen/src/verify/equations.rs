//! The equations of motion at a state, evaluated directly from the scene.

use num_dual::Dual2;

use super::gradients::Gradients;
use super::sample::Sample;
use crate::term::{Equations, Row};
use qrm_scene::evaluate::State;
use qrm_scene::function::Differentiable;
use qrm_scene::scene::{Scene, Value as Formula};

impl<B: Differentiable> Sample<B> {
    /// The residual of the equations of motion for the accelerations and multipliers of the sample.
    pub(super) fn residual(&self, scene: &Scene, equations: &Equations) -> Residual<B> {
        let gradients = Gradients::new(self, scene);
        let plain = State::plain(scene, &self.parameters, self.t, &self.q, &self.qd);
        let rows = self.com_rows(scene, equations, &plain);
        let found = EquationsOfMotion::new(self, &rows, &gradients, &plain);
        let n = self.q.len();
        let mass = found.mass_matrix(&rows);
        let dot = |row: &[B]| row.iter().zip(&self.qdd).map(|(entry, a)| *entry * *a).sum::<B>();
        let reaction = |i: usize| {
            let column = found.constraint_jacobian.iter().skip(i).step_by(n);
            column.zip(&self.multipliers).map(|(entry, lambda)| *entry * *lambda).sum::<B>()
        };
        let constraints = found.residuals.iter().zip(found.constraint_jacobian.chunks(n.max(1)));
        Residual {
            forces: (0..n).map(|i| dot(&mass[i * n..(i + 1) * n]) + reaction(i) - found.forces[i]).collect(),
            constraints: constraints.map(|(residual, row)| dot(row) + residual.v2).collect(),
        }
    }

    /// The formulae of the rows of `T`, each with its mass or moment of inertia.
    pub(super) fn com_rows<'s>(
        &self,
        scene: &'s Scene,
        equations: &Equations,
        plain: &State<B>,
    ) -> Vec<(&'s Formula, B)> {
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

/// The residual of the equations of motion; zero during a motion.
pub(super) struct Residual<B> {
    /// `Mbar qdd + C_q' lambda - fbar`
    pub(super) forces: Vec<B>,
    /// `C_q qdd + bias`
    pub(super) constraints: Vec<B>,
}

/// The parts of the equations of motion at a state.
pub(super) struct EquationsOfMotion<B> {
    /// The rows of `T` with two derivatives with respect to time.
    pub(super) positions: Vec<Dual2<B>>,
    pub(super) jacobian: Vec<Vec<B>>,
    pub(super) forces: Vec<B>,
    /// The loop constraints with two derivatives with respect to time.
    pub(super) residuals: Vec<Dual2<B>>,
    pub(super) constraint_jacobian: Vec<B>,
}

impl<B: Differentiable> EquationsOfMotion<B> {
    pub(super) fn new(sample: &Sample<B>, rows: &[(&Formula, B)], gradients: &Gradients<B>, plain: &State<B>) -> Self {
        let scene = gradients.scene;
        let n = sample.q.len();
        let zero = B::from(0.0);
        let moving = State::along(scene, &sample.parameters, sample.t, &sample.q, &sample.qd, &vec![zero; n]);
        let positions: Vec<Dual2<B>> = rows.iter().map(|(row, _)| moving.value(row)).collect();
        let jacobian: Vec<Vec<B>> = rows.iter().map(|(row, _)| gradients.gradient(row)).collect();
        let mut forces = sample.generalized_forces(gradients, plain);
        for (((_, inertia), row), bias) in rows.iter().zip(&jacobian).zip(&positions) {
            // In a large mechanism most rows depend on few coordinates.
            for i in (0..n).filter(|&i| !row[i].is_zero()) {
                forces[i] -= *inertia * row[i] * bias.v2;
            }
        }
        let constraints = || scene.constraints.iter().map(|c| &c.residual);
        Self {
            positions,
            jacobian,
            forces,
            residuals: constraints().map(|row| moving.value(row)).collect(),
            constraint_jacobian: constraints().flat_map(|row| gradients.gradient(row)).collect(),
        }
    }

    /// `T' M T`
    pub(super) fn mass_matrix(&self, rows: &[(&Formula, B)]) -> Vec<B> {
        let n = self.forces.len();
        let mut mass = vec![B::from(0.0); n * n];
        for ((_, inertia), row) in rows.iter().zip(&self.jacobian) {
            for i in (0..n).filter(|&i| !row[i].is_zero()) {
                for j in 0..n {
                    mass[i * n + j] += *inertia * row[i] * row[j];
                }
            }
        }
        mass
    }
}
