//! Inverse dynamics: the forces and torques for given accelerations.

use super::Kernel;
use super::algebra::Value;
use super::block::Block;
use super::builder::Builder;
use super::null_space::NullSpace;
use crate::graph::Signed;
use crate::term::{Equations, Symbol};

impl Builder<'_> {
    /// The multipliers follow from the rows of the dependent coordinates, and the forces then from the rows of the
    /// independent ones: `Mbar qdd + C_q' lambda = fbar + forces`.
    pub(super) fn inverse_dynamics(mut self, equations: &Equations) -> Option<Kernel> {
        let e = &equations.kernel;
        self.names(&e.names);
        let (jacobian, mass) = (self.jacobian(e), self.mass_matrix(e));
        let null_space = NullSpace::new(&mut self, equations, &jacobian, &mass);
        if null_space.has_repeated() {
            return None;
        }
        self.named_rates(&e.names);
        let applied = self.forces(&e.effort_groups);
        let n = self.scene.coordinates.len();
        let accelerations: Vec<Value> =
            (0..n).map(|i| Some(self.lowering.graph.input(Symbol::Acceleration(i)))).collect();
        let multipliers = null_space.multipliers(&mut self, &applied, &accelerations);
        let force = |&i: &usize| {
            let column: Vec<Value> = jacobian.iter().map(|row| row[i]).collect();
            let moved = [self.dot(&mass[i], &accelerations), self.dot(&column, &multipliers)];
            let terms: Vec<Signed> = moved.into_iter().chain([applied[i].map(Signed::negated)]).flatten().collect();
            let sum = self.sum(terms);
            let name = format!("needed_{}", self.scene.coordinates[i].name);
            (i, self.keep(Block::Inverse, &name, sum))
        };
        let forces: Vec<(usize, Value)> = null_space.independent().iter().map(force).collect();
        let zero = self.lowering.graph.number(0.0);
        let mut kernel = Kernel {
            multipliers: multipliers.into_iter().map(|value| value.unwrap_or(zero)).collect(),
            forces: forces.into_iter().map(|(i, value)| (i, value.unwrap_or(zero))).collect(),
            is_timed: true,
            ..Kernel::default()
        };
        let needed = self.needed(&self.locals, kernel.values().map(|value| value.id).collect());
        kernel.locals = self.locals.into_iter().filter(|local| needed.contains(&local.input.id)).collect();
        Some(kernel)
    }
}
