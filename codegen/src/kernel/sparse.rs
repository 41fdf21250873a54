//! A kernel that solves for the second rates of points and angles together with the accelerations of the coordinates.
//! On trees of bodies this is the articulated-body recursion: the number of operations grows with that of the bodies.

mod elimination;
mod sparse_symmetric_matrix;
mod variables;

use super::Kernel;
use super::algebra::Value;
use super::block::Block;
use super::builder::Builder;
use crate::graph::Signed;
use crate::term::{EffortsAlongVariables, SparseEquations, Symbol};
use elimination::SparseElimination;
use qrm_scene::scene::EliminationForm;
use sparse_symmetric_matrix::SparseSymmetricMatrix;
use variables::Variables;

impl Builder<'_> {
    /// Creates the kernel; `None` if a pivot is zero by structure.
    pub(super) fn build_sparse(mut self, e: &SparseEquations) -> Option<Kernel> {
        let (n, m) = (self.scene.coordinates.len(), self.scene.constraints.len());
        let constraints: Vec<String> = self.scene.constraints.iter().map(|c| c.name.clone()).collect();
        let mut variables = Variables::new(&mut self, &e.names);
        let residuals: Vec<Value> = (0..m)
            .map(|k| {
                let name = format!("{}_residual", constraints[k]);
                let value = self.value(&e.constraints[k].value);
                self.keep(Block::Constraints, &name, value)
            })
            .collect();
        let mut jacobian: Vec<Vec<(usize, Value)>> = Vec::new();
        for (constraint, name) in e.constraints.iter().zip(&constraints) {
            let row = constraint.by.iter().map(|(symbol, by)| {
                let variable = variables.place(*symbol);
                let value = self.value(by);
                (variable, self.keep(Block::Jacobian, &format!("{name}_{}", variables.name(variable)), value))
            });
            jacobian.push(row.collect());
        }
        let own_rates: Vec<Value> = (0..m)
            .map(|k| {
                let value = self.value(&e.constraints[k].by_time);
                self.keep(Block::Jacobian, &format!("{}_t", constraints[k]), value)
            })
            .collect();
        let inertia = self.inertia(&variables, e);
        let elimination = SparseElimination::new(&mut self, &variables, inertia, &jacobian)?;

        variables.rates(&mut self, &e.names);
        let velocity_residual: Vec<Value> = jacobian
            .iter()
            .zip(own_rates)
            .map(|(row, own)| {
                let moved: Vec<Signed> =
                    row.iter().filter_map(|(z, by)| self.multiply(*by, variables.rates[*z])).collect();
                self.sum(moved.into_iter().chain(own).collect())
            })
            .collect();
        let closing: Vec<Value> = (0..m)
            .map(|k| {
                let own = self.value(&e.constraints[k].bias);
                let moved: Vec<Signed> =
                    jacobian[k].iter().filter_map(|(z, by)| self.multiply(*by, variables.biases[*z])).collect();
                let bias = self.sum(moved.into_iter().chain(own).collect());
                self.keep(Block::Bias, &format!("{}_bias", constraints[k]), bias).map(Signed::negated)
            })
            .collect();
        let forces = self.forces_along_variables(&variables, &e.efforts);
        let (accelerations, multipliers) =
            elimination.solve(&mut self, &variables, forces, &closing, Block::Accelerations, "ddot");
        let required = self.required_change();
        let still = vec![Vec::new(); variables.count()];
        let (correction, _) =
            elimination.solve(&mut self, &variables, still, &required, Block::Correction, "correction");
        variables.accelerations(&mut self, &e.names);
        let outputs: Vec<Value> = e.outputs.iter().map(|output| self.value(output)).collect();
        let zero = self.lowering.graph.number(0.0);
        let all = |values: Vec<Value>| values.into_iter().map(|value| value.unwrap_or(zero)).collect();
        let mut kernel = Kernel {
            residuals: all(residuals),
            growth_factors: all(elimination.growth_factors.clone()),
            velocity_residual: all(velocity_residual),
            correction: all(correction[..n].to_vec()),
            accelerations: all(accelerations[..n].to_vec()),
            multipliers: all(multipliers),
            outputs: all(outputs),
            form: EliminationForm::Sparse,
            is_valid_everywhere: true,
            is_timed: self.scene.is_driven()
                || e.names.iter().any(|named| named.function.value.any_symbol(&|symbol| symbol == Symbol::Time)),
            ..Kernel::default()
        };
        let needed = self.needed(&self.locals, kernel.values().map(|value| value.id).collect());
        kernel.locals = self.locals.into_iter().filter(|local| needed.contains(&local.input.id)).collect();
        Some(kernel)
    }

    /// Binds the generalized momenta and forces: those along named quantities are replaced by those along the variables
    /// in their definitions, the last one first.
    pub(super) fn bind_dynamics(mut self, e: &SparseEquations) {
        let mut variables = Variables::new(&mut self, &e.names);
        variables.rates(&mut self, &e.names);
        let n = variables.coordinates();
        let velocities = variables.velocities(&mut self);
        let mut momenta: Vec<Vec<Signed>> = vec![Vec::new(); variables.count()];
        for (entry, [a, b]) in self.entries_of_inertia(&variables, e) {
            momenta[a].extend(self.multiply(entry, velocities[b]));
            if a != b {
                momenta[b].extend(self.multiply(entry, velocities[a]));
            }
        }
        let mut forces = self.forces_along_variables(&variables, &e.efforts);
        for z in (n..variables.count()).rev() {
            for along in [&mut momenta, &mut forces] {
                let own = self.sum(std::mem::take(&mut along[z]));
                for (u, by) in &variables.definitions[z - n] {
                    along[*u].extend(self.multiply(*by, own));
                }
            }
        }
        for (i, (momentum, force)) in momenta.into_iter().zip(forces).enumerate().take(n) {
            let [momentum, force] = [momentum, force].map(|terms| self.sum(terms));
            self.bind(Symbol::Momentum(i), momentum);
            self.bind(Symbol::GeneralizedForce(i), force);
        }
    }

    /// The inertia of all bodies for the rates of the variables.
    fn inertia(&mut self, variables: &Variables, e: &SparseEquations) -> SparseSymmetricMatrix {
        let mut inertia = SparseSymmetricMatrix::new(variables.count());
        for (entry, [a, b]) in self.entries_of_inertia(variables, e) {
            inertia.add(a, b, entry);
            if a == b {
                inertia.add_unreduced(a, entry);
            }
        }
        inertia
    }

    /// The entries on and below the diagonals of the bodies' inertia, with their variables.
    fn entries_of_inertia(&mut self, variables: &Variables, e: &SparseEquations) -> Vec<(Value, [usize; 2])> {
        let mut entries = Vec::new();
        for body in &e.inertias {
            for (i, row) in body.matrix.iter().enumerate() {
                for (j, entry) in row.iter().enumerate() {
                    entries.push((self.value(entry), [i, j].map(|place| variables.place(body.variables[place]))));
                }
            }
        }
        entries
    }

    /// The forces along the variables.
    fn forces_along_variables(&mut self, variables: &Variables, efforts: &[EffortsAlongVariables]) -> Vec<Vec<Signed>> {
        let mut forces: Vec<Vec<Signed>> = vec![Vec::new(); variables.count()];
        for group in efforts {
            let places: Vec<usize> = group.variables.iter().map(|symbol| variables.place(*symbol)).collect();
            self.add_efforts(&group.efforts, &group.total, &places, &mut forces);
        }
        forces
    }
}
