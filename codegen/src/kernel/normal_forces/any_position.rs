//! Normal forces of friction in plain functions, valid at any position.

use super::super::algebra::{Matrix, Value};
use super::super::range_space::RangeSpace;
use super::super::{Block, Builder};
use crate::graph::Signed;
use crate::term::{KernelEquations, Symbol};

impl Builder<'_> {
    /// Binds the symbols of normal forces; returns the named intermediate values.
    ///
    /// `Mbar` is completed by `C_q' W C_q`, with weights `W` that give both parts the same size. The result is regular
    /// wherever the motion is determined, and the solution does not change.
    pub(in crate::kernel) fn bind_normal_forces(mut self, e: &KernelEquations) -> Vec<(String, Signed)> {
        let jacobian = self.jacobian(e);
        let mass = self.mass_matrix(e);
        let closing: Vec<Value> = e.constraint_bias.iter().map(|bias| self.value(bias).map(Signed::negated)).collect();
        let forces: Vec<Value> =
            e.effort_groups.iter().flat_map(|group| &group.total).map(|force| self.value(force)).collect();
        let weighted = self.weighted(&jacobian, &mass);
        let completed = self.completed(&jacobian, &weighted, mass);
        if let Some(system) = RangeSpace::new(&mut self, &jacobian, &completed) {
            let still = vec![None; closing.len()];
            let solve = |builder: &mut Self, forces: &[Value], unit: Option<&str>| {
                let closing = if unit.is_some() { &still } else { &closing };
                let pulled = |(i, force): (usize, &Value)| {
                    let column: Vec<Value> = weighted.iter().map(|row| row[i]).collect();
                    let more = builder.dot(&column, closing);
                    builder.sum(force.iter().copied().chain(more).collect())
                };
                let forces: Vec<Value> = forces.iter().enumerate().map(pulled).collect();
                system.accelerations(builder, closing, &forces)
            };
            self.with_friction(&e.normal_forces, &forces, &solve);
        } else {
            // If some coordinate has no inertia at all, there is no motion, and normal forces are set to zero.
            e.normal_forces.iter().for_each(|own| self.bind(Symbol::NormalForce(own.output), None));
        }
        self.locals.into_iter().map(|local| (local.name, local.value)).collect()
    }

    /// `W C_q`
    fn weighted(&mut self, jacobian: &Matrix, mass: &Matrix) -> Matrix {
        let trace: Vec<Signed> = (0..mass.len()).filter_map(|i| mass[i][i]).collect();
        let trace = self.sum(trace);
        let mut weighted = Matrix::new();
        for row in jacobian {
            let square = self.dot(row, row);
            let over = self.reciprocal(square);
            let weight = self.multiply(trace, over);
            let weight = self.keep(Block::Mass, "weight", weight);
            weighted.push(row.iter().map(|entry| self.multiply(weight, *entry)).collect());
        }
        weighted
    }

    /// `Mbar + C_q' W C_q`
    fn completed(&mut self, jacobian: &Matrix, weighted: &Matrix, mut mass: Matrix) -> Matrix {
        for (i, row) in mass.iter_mut().enumerate() {
            for (j, entry) in row.iter_mut().enumerate() {
                let products = jacobian.iter().zip(weighted).filter_map(|(own, by)| self.multiply(own[i], by[j]));
                let terms: Vec<Signed> = entry.iter().copied().chain(products.collect::<Vec<_>>()).collect();
                *entry = self.sum(terms);
            }
        }
        mass
    }
}
