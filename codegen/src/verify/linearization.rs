//! Derivatives of the equations of motion by automatic differentiation.

use num_dual::Dual;

use super::equations::Residual;
use super::expected::Expected;
use super::sample::Sample;
use crate::term::Equations;
use qrm_scene::function::Differentiable;
use qrm_scene::scene::Scene;

impl<B: Differentiable> Sample<B> {
    /// All parts of the linearization, row by row.
    pub(super) fn linearization(&self, scene: &Scene, equations: &Equations) -> Expected<B> {
        let parts = [
            (By::Coordinates, ["linearization.stiffness", "linearization.constraint_stiffness"]),
            (By::Rates, ["linearization.damping", "linearization.constraint_damping"]),
            (By::Time, ["linearization.forcing", "linearization.constraint_forcing"]),
        ];
        let mut expected = Expected::new();
        for (by, [forces, constraints]) in parts {
            let count = if by == By::Time { 1 } else { self.q.len() };
            // Derivatives with respect to time are on the right-hand side of the linearized equations.
            let sign = if by == By::Time { -1.0 } else { 1.0 };
            let columns: Vec<Residual<Dual<B>>> =
                (0..count).map(|j| self.along(by, j).residual(scene, equations)).collect();
            let rows = |part: fn(&Residual<Dual<B>>) -> &Vec<Dual<B>>| -> Vec<B> {
                let row = |i: usize| columns.iter().map(move |column| part(column)[i].eps * sign);
                (0..columns.first().map_or(0, |column| part(column).len())).flat_map(row).collect()
            };
            expected.push((forces, rows(|residual| &residual.forces)));
            expected.push((constraints, rows(|residual| &residual.constraints)));
        }
        expected
    }

    /// The sample whose values carry their derivatives with respect to time, or to one coordinate or rate.
    fn along(&self, by: By, j: usize) -> Sample<Dual<B>> {
        let [zero, one] = [0.0, 1.0].map(B::from);
        let dual = |values: &[B], is_moving: bool| {
            let part = |i: usize| if is_moving && i == j { one } else { zero };
            values.iter().enumerate().map(|(i, &value)| Dual::new(value, part(i))).collect()
        };
        Sample {
            parameters: self.parameters.clone(),
            t: Dual::new(self.t, if by == By::Time { one } else { zero }),
            q: dual(&self.q, by == By::Coordinates),
            qd: dual(&self.qd, by == By::Rates),
            qdd: dual(&self.qdd, false),
            multipliers: dual(&self.multipliers, false),
            normal_forces: dual(&self.normal_forces, false),
        }
    }
}

/// The variable of the differentiation.
#[derive(Clone, Copy, PartialEq)]
enum By {
    Coordinates,
    Rates,
    Time,
}
