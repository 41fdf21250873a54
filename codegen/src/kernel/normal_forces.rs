//! Friction proportional to normal forces. These depend on accelerations and multipliers, and therefore on friction.
//!
//! The equations of motion are linear in the sizes `N` of the normal forces: their components are `o = rest + by N`.
//! With the direction `d = o/|o|` of each, `N = d . rest + (d . by) N`. Newton's method solves these equations, then
//! updates the directions. If the matrix of the sizes `|by|` has a spectral radius below one, there is one solution.
//! Otherwise there may be none or several (Painlevé), and the normal forces are not numbers.

mod any_position;

use super::algebra::{Matrix, Value};
use super::block::Block;
use super::builder::Builder;
use crate::graph::{Op, Signed};
use crate::term::{AffineForce, NormalForce, Symbol, Term};
use qrm_scene::function::Function;

/// The number of steps of Newton's method. Five reach full precision for a spectral radius of 0.5, and this number for
/// 0.97.
const STEPS: usize = 8;
/// Largest error of the solution, relative to the sum of the normal forces.
const TOLERANCE: f64 = 1e-9;
/// Added to the square of a size before the root is taken, since a force of zero has no direction and is a divisor.
const TINY: f64 = 1e-300;
/// The factor of a test value that is added to normal forces: it changes no digit, but makes the force NaN if the test
/// value is NaN.
const CHECK_SCALE: f64 = 1e-300;

/// Accelerations and multipliers.
pub(super) type Solution = (Vec<Value>, Vec<Value>);

/// Solves for forces; with the name of a normal force, for forces alone.
type Solve<'s, B> = &'s dyn Fn(&mut B, &[Value], Option<&str>) -> Solution;

/// The components of a normal force.
struct Components {
    rest: Vec<Value>,
    /// The derivatives of each component with respect to all normal forces.
    by: Matrix,
}

impl Components {
    /// The derivatives of all components with respect to one normal force.
    fn by_normal_force(&self, k: usize) -> Vec<Value> {
        self.by.iter().map(|component| component[k]).collect()
    }
}

impl Builder<'_> {
    /// Solves the equations of motion with friction. `solve` solves them for other forces; with the name of a normal
    /// force, for forces alone, with a zero right-hand side of the constraints.
    pub(super) fn with_friction(
        &mut self,
        normal_forces: &[NormalForce],
        forces: &[Value],
        solve: Solve<'_, Self>,
    ) -> Solution {
        let without = solve(self, forces, None);
        if normal_forces.is_empty() {
            return without;
        }
        let units: Vec<Solution> = normal_forces
            .iter()
            .map(|own| {
                let friction: Vec<Value> = own.friction.iter().map(|force| self.value(force)).collect();
                solve(self, &friction, Some(&own.name))
            })
            .collect();
        let components: Vec<Components> =
            normal_forces.iter().map(|own| self.components(own, &without, &units)).collect();
        let sizes = self.sizes(normal_forces, &components);
        for (own, size) in normal_forces.iter().zip(&sizes) {
            self.bind(Symbol::NormalForce(own.output), *size);
        }
        let mut total = |part: fn(&Solution) -> &Vec<Value>, name: &dyn Fn(&Self, usize) -> String, block: Block| {
            let entry = |i: usize| {
                let by: Vec<Value> = units.iter().map(|unit| part(unit)[i]).collect();
                let more = self.dot(&by, &sizes);
                let sum = self.sum(part(&without)[i].into_iter().chain(more).collect());
                let name = name(self, i);
                self.keep(block, &name, sum)
            };
            (0..part(&without).len()).map(entry).collect::<Vec<Value>>()
        };
        let coordinate = |builder: &Self, i: usize| format!("{}_ddot", builder.scene.coordinates[i].name);
        let constraint = |builder: &Self, k: usize| format!("lambda_{}", builder.scene.constraints[k].name);
        let accelerations = total(|solution| &solution.0, &coordinate, Block::Friction);
        (accelerations, total(|solution| &solution.1, &constraint, Block::Friction))
    }

    fn components(&mut self, own: &NormalForce, without: &Solution, units: &[Solution]) -> Components {
        let (mut rest, mut by) = (Vec::new(), Matrix::new());
        for (force, axis) in own.components.iter().zip(["", "_y"]) {
            let name = format!("{}{axis}", own.name);
            rest.push(self.component(force, without, &force.rest, &format!("{name}_rest")));
            let of_units = units.iter().zip(&force.by_normal_forces).enumerate();
            by.push(
                of_units.map(|(k, (unit, own))| self.component(force, unit, own, &format!("{name}_by_{k}"))).collect(),
            );
        }
        Components { rest, by }
    }

    /// A component for given accelerations and multipliers.
    fn component(
        &mut self,
        force: &AffineForce,
        (accelerations, multipliers): &Solution,
        more: &Term,
        name: &str,
    ) -> Value {
        let mut values = |terms: &[Term]| terms.iter().map(|term| self.value(term)).collect::<Vec<Value>>();
        let (by_accelerations, by_multipliers) = (values(&force.by_accelerations), values(&force.by_multipliers));
        let more = self.value(more);
        let parts = [self.dot(&by_accelerations, accelerations), self.dot(&by_multipliers, multipliers), more];
        let sum = self.sum(parts.into_iter().flatten().collect());
        self.keep(Block::Friction, name, sum)
    }

    /// The sizes of the normal forces.
    fn sizes(&mut self, normal_forces: &[NormalForce], components: &[Components]) -> Vec<Value> {
        let is_free = components.iter().flat_map(|own| &own.by).flatten().all(Option::is_none);
        let name = |k: usize, what: &str| format!("{}_{what}", normal_forces[k].name);
        let sizes_at = |builder: &mut Self, forces: &[Vec<Value>], what: &str| -> Vec<Value> {
            let size = |(k, force): (usize, &Vec<Value>)| {
                let size = builder.size(force);
                builder.keep(Block::Friction, &name(k, what), size)
            };
            forces.iter().enumerate().map(size).collect()
        };
        let rest: Vec<Vec<Value>> = components.iter().map(|own| own.rest.clone()).collect();
        if is_free {
            return sizes_at(self, &rest, "size");
        }
        let mut forces = rest;
        let mut sizes = Vec::new();
        // The sign of a single component does not change with friction, if the solution is unique.
        let steps = if matches!(components, [only] if only.rest.len() == 1) { 1 } else { STEPS };
        for _ in 0..steps {
            let directions = self.directions(&forces);
            let (mut matrix, mut right) = (Matrix::new(), Vec::new());
            for (own, direction) in components.iter().zip(&directions) {
                let row = (0..components.len()).map(|k| self.dot(direction, &own.by_normal_force(k)));
                matrix.push(row.collect());
                right.push(self.dot(direction, &own.rest));
            }
            sizes = self.fixed_point(&matrix, right).0;
            sizes =
                sizes.iter().enumerate().map(|(k, size)| self.keep(Block::Friction, &name(k, "size"), *size)).collect();
            forces = self.forces_of(components, &sizes);
        }
        let found = sizes_at(self, &forces, "found");
        let uniqueness_check = self.uniqueness_check(components, &sizes, &found);
        let checked = |(k, size): (usize, &Value)| {
            let sum = self.sum(size.iter().copied().chain(uniqueness_check).collect());
            self.keep(Block::Friction, &name(k, "normal"), sum)
        };
        sizes.iter().enumerate().map(checked).collect()
    }

    /// Zero up to rounding if the solution is unique, otherwise not a number.
    fn uniqueness_check(&mut self, components: &[Components], sizes: &[Value], found: &[Value]) -> Value {
        let contraction: Matrix = components
            .iter()
            .map(|own| (0..components.len()).map(|k| self.size(&own.by_normal_force(k))).collect())
            .collect();
        let none = vec![None; components.len()];
        // All pivots are positive if the spectral radius is below one.
        let mut margins = self.fixed_point(&contraction, none).1;
        let tiny = Some(self.lowering.graph.number(CHECK_SCALE));
        let tolerance = Some(self.lowering.graph.number(TOLERANCE));
        let total = self.sum(found.iter().copied().flatten().chain(tiny).collect());
        let allowed = self.multiply(total, tolerance);
        for (size, found) in sizes.iter().zip(found) {
            let difference = self.difference(*size, *found);
            let error = self.size(&[difference]);
            margins.push(self.difference(allowed, error));
        }
        let scale = Some(self.lowering.graph.number(CHECK_SCALE));
        margins.retain(|margin| margin.is_some_and(|margin| !self.is_one(margin)));
        let roots: Vec<Signed> = margins.into_iter().filter_map(|margin| self.root(margin)).collect();
        let sum = self.sum(roots);
        let uniqueness_check = self.multiply(scale, sum);
        self.keep(Block::Friction, "doubt", uniqueness_check)
    }

    /// `rest + by N`
    fn forces_of(&mut self, components: &[Components], sizes: &[Value]) -> Vec<Vec<Value>> {
        let mut force = |own: &Components| {
            let component = |(rest, by): (&Value, &Vec<Value>)| {
                let more = self.dot(by, sizes);
                self.sum(rest.iter().copied().chain(more).collect())
            };
            own.rest.iter().zip(&own.by).map(component).collect()
        };
        components.iter().map(&mut force).collect()
    }

    fn directions(&mut self, forces: &[Vec<Value>]) -> Vec<Vec<Value>> {
        let mut direction = |force: &Vec<Value>| match &force[..] {
            [single] => vec![self.call(Function::Sign, *single)],
            _ => {
                let size = self.size(force);
                let over = self.reciprocal(size);
                force.iter().map(|component| self.multiply(*component, over)).collect()
            }
        };
        forces.iter().map(&mut direction).collect()
    }

    /// The size of a force from its components.
    fn size(&mut self, force: &[Value]) -> Value {
        match force {
            [single] => self.call(Function::Abs, *single),
            _ => {
                let square = self.dot(force, force)?;
                let tiny = self.lowering.graph.number(TINY);
                let square = self.sum(vec![square, tiny]);
                self.root(square)
            }
        }
    }

    fn call(&mut self, function: Function, argument: Value) -> Value {
        let argument = self.lowering.positive(argument?);
        Some(Signed { negative: false, id: self.lowering.graph.add(Op::Call(function, argument)) })
    }

    /// Solves `x = matrix x + right`; also returns the pivots.
    fn fixed_point(&mut self, matrix: &Matrix, right: Vec<Value>) -> Solution {
        let size = matrix.len();
        let one = self.lowering.graph.number(1.0);
        let mut rows: Matrix = matrix
            .iter()
            .enumerate()
            .map(|(i, row)| {
                let entry = |(j, value): (usize, &Value)| {
                    let negative = value.map(Signed::negated);
                    if i == j { self.sum(negative.into_iter().chain([one]).collect()) } else { negative }
                };
                row.iter().enumerate().map(entry).collect()
            })
            .collect();
        let (mut x, mut inverses) = (right, Vec::new());
        for k in 0..size {
            let inverse = self.reciprocal(rows[k][k]);
            inverses.push(self.keep(Block::Friction, "over_pivot", inverse));
            for i in k + 1..size {
                let multiple = self.multiply(rows[i][k], inverses[k]);
                let multiple = self.keep(Block::Friction, "multiple", multiple);
                for j in k + 1..size {
                    let product = self.multiply(multiple, rows[k][j]);
                    rows[i][j] = self.difference(rows[i][j], product);
                }
                let product = self.multiply(multiple, x[k]);
                x[i] = self.difference(x[i], product);
            }
        }
        for k in (0..size).rev() {
            let known: Vec<Value> = (k + 1..size).map(|j| self.multiply(rows[k][j], x[j])).collect();
            let terms = x[k].into_iter().chain(known.into_iter().flatten().map(Signed::negated)).collect();
            let sum = self.sum(terms);
            x[k] = self.multiply(sum, inverses[k]);
        }
        (x, (0..size).map(|k| rows[k][k]).collect())
    }
}
