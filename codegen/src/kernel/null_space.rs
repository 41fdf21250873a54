//! The null-space method for the linear equations of a kernel: constraints are solved for the dependent coordinates, in
//! an order that preserves zeros, and the remaining equations for the independent ones.

mod pivots;
mod solutions;

use std::collections::HashSet;

use super::algebra::{Matrix, Value};
use super::block::Block;
use super::builder::Builder;
use crate::graph::Signed;
use crate::term::Equations;
use pivots::pivots;

/// A factored system.
pub(super) struct NullSpace {
    constraints: usize,
    /// Constraint and coordinate of each pivot, in order.
    pivots: Vec<(usize, usize)>,
    /// The independent coordinates.
    independent: Vec<usize>,
    /// One over each pivot.
    inverses: Vec<Value>,
    /// Entries to the left of and below pivots.
    lower: Matrix,
    /// Entries to the right of and above pivots, divided by the pivot.
    upper: Matrix,
    mass: Matrix,
    /// The derivatives of all coordinates with respect to each independent one.
    tangents: Matrix,
    /// Mbar T, a row for each independent coordinate.
    momenta: Matrix,
    /// The factors of T' Mbar T = L D L'.
    factors: Matrix,
    inverse_inertia: Vec<Value>,
    /// The fraction of the inertia that each pivot kept.
    kept_inertia: Vec<Value>,
    pivot_ratios: Vec<Value>,
    /// Whether a pivot may vanish without a growth factor that says so: nothing else is in its row or column.
    has_lone_pivot: bool,
}

impl NullSpace {
    pub(super) fn new(builder: &mut Builder, equations: &Equations, jacobian: &Matrix, mass: &Matrix) -> Self {
        let pivots = pivots(builder, equations, jacobian);
        let n = builder.scene.coordinates.len();
        let independent: Vec<usize> = (0..n).filter(|i| !pivots.iter().any(|(_, c)| c == i)).collect();
        let mut system = Self {
            constraints: jacobian.len(),
            pivots,
            independent,
            inverses: Vec::new(),
            lower: Vec::new(),
            upper: Vec::new(),
            mass: mass.clone(),
            tangents: Vec::new(),
            momenta: Vec::new(),
            factors: Vec::new(),
            inverse_inertia: Vec::new(),
            kept_inertia: Vec::new(),
            pivot_ratios: Vec::new(),
            has_lone_pivot: false,
        };
        system.factor(builder, jacobian);
        system.tangents(builder, jacobian);
        system.pivot_ratios(builder, jacobian);
        system.inertia(builder);
        system
    }

    fn name(&self, builder: &Builder, coordinate: usize) -> String {
        builder.scene.coordinates[coordinate].name.clone()
    }

    /// Crout's factors of the columns of dependent coordinates: `L` with the pivots, `U` with ones on its diagonal.
    fn factor(&mut self, builder: &mut Builder, jacobian: &Matrix) {
        let m = self.pivots.len();
        self.lower = vec![vec![None; m]; m];
        self.upper = vec![vec![None; m]; m];
        for k in 0..m {
            let (row, column) = self.pivots[k];
            for i in k..m {
                let (other, _) = self.pivots[i];
                let known =
                    (0..k).filter_map(|j| builder.multiply(self.lower[i][j], self.upper[j][k])).map(Signed::negated);
                let terms: Vec<Signed> = jacobian[other][column].into_iter().chain(known.collect::<Vec<_>>()).collect();
                let sum = builder.sum(terms);
                let name = format!("{}_{}_left", builder.scene.constraints[other].name, self.name(builder, column));
                self.lower[i][k] = builder.keep(Block::Tangents, &name, sum);
            }
            let constraint = builder.scene.constraints[row].name.clone();
            let inverse = builder.reciprocal(self.lower[k][k]);
            self.inverses.push(builder.keep(Block::Tangents, &format!("inv_{constraint}"), inverse));
            for j in k + 1..m {
                let (_, other) = self.pivots[j];
                let known =
                    (0..k).filter_map(|i| builder.multiply(self.lower[k][i], self.upper[i][j])).map(Signed::negated);
                let terms: Vec<Signed> = jacobian[row][other].into_iter().chain(known.collect::<Vec<_>>()).collect();
                let sum = builder.sum(terms);
                let ratio = builder.multiply(sum, self.inverses[k]);
                let name = format!("{constraint}_{}_share", self.name(builder, other));
                self.upper[k][j] = builder.keep(Block::Tangents, &name, ratio);
            }
        }
    }

    /// Solves the constraints for the dependent coordinates, with a right-hand side for each constraint.
    fn solve(
        &self,
        builder: &mut Builder,
        right: &[Value],
        keep: impl Fn(&mut Builder, usize, Value) -> Value,
    ) -> Vec<Value> {
        let m = self.pivots.len();
        let mut x: Vec<Value> = vec![None; m];
        for k in 0..m {
            let mut sum: Vec<Signed> = right[self.pivots[k].0].into_iter().collect();
            sum.extend((0..k).filter_map(|j| builder.multiply(self.lower[k][j], x[j])).map(Signed::negated));
            let sum = builder.sum(sum);
            x[k] = builder.multiply(sum, self.inverses[k]);
            // Only values that are used again get a name.
            if (k + 1..m).any(|i| self.lower[i][k].is_some()) || (k + 1..m).all(|j| self.upper[k][j].is_none()) {
                x[k] = keep(builder, k, x[k]);
            }
        }
        for k in (0..m).rev() {
            let mut sum: Vec<Signed> = x[k].into_iter().collect();
            sum.extend((k + 1..m).filter_map(|j| builder.multiply(self.upper[k][j], x[j])).map(Signed::negated));
            let sum = builder.sum(sum);
            x[k] = keep(builder, k, sum);
        }
        x
    }

    fn tangents(&mut self, builder: &mut Builder, jacobian: &Matrix) {
        let one = builder.lowering.graph.number(1.0);
        for place in 0..self.independent.len() {
            let by = self.independent[place];
            let right: Vec<Value> = jacobian.iter().map(|row| row[by].map(Signed::negated)).collect();
            let by_name = self.name(builder, by);
            let solved = self.solve(builder, &right, |builder, k, value| {
                let name = format!("{}_per_{by_name}", self.name(builder, self.pivots[k].1));
                builder.keep(Block::Tangents, &name, value)
            });
            let mut tangent = vec![None; builder.scene.coordinates.len()];
            tangent[by] = Some(one);
            for (k, value) in solved.into_iter().enumerate() {
                tangent[self.pivots[k].1] = value;
            }
            self.tangents.push(tangent);
        }
    }

    fn inertia(&mut self, builder: &mut Builder) {
        let n = self.mass.len();
        for (place, tangent) in self.tangents.clone().iter().enumerate() {
            let by = self.name(builder, self.independent[place]);
            let momentum = |builder: &mut Builder, i: usize| {
                let sum = builder.dot(&self.mass[i], tangent);
                let name = format!("momentum_{}_{by}", self.name(builder, i));
                builder.keep(Block::Inertia, &name, sum)
            };
            let momentum = (0..n).map(|i| momentum(builder, i)).collect();
            self.momenta.push(momentum);
        }
        let f = self.independent.len();
        self.factors = vec![vec![None; f]; f];
        // L times D.
        let mut scaled: Matrix = vec![vec![None; f]; f];
        for i in 0..f {
            let name = self.name(builder, self.independent[i]);
            for j in 0..i {
                let entry = builder.dot(&self.tangents[i], &self.momenta[j]);
                let known =
                    (0..j).filter_map(|k| builder.multiply(scaled[i][k], self.factors[j][k])).map(Signed::negated);
                let terms = entry.into_iter().chain(known.collect::<Vec<_>>()).collect();
                let sum = builder.sum(terms);
                let other = self.name(builder, self.independent[j]);
                scaled[i][j] = builder.keep(Block::Inertia, &format!("inertia_{other}_{name}"), sum);
                let ratio = builder.multiply(scaled[i][j], self.inverse_inertia[j]);
                self.factors[i][j] = builder.keep(Block::Inertia, &format!("share_{other}_{name}"), ratio);
            }
            let whole = builder.dot(&self.tangents[i], &self.momenta[i]);
            let whole = builder.keep(Block::Inertia, &format!("inertia_{name}"), whole);
            let known = (0..i).filter_map(|k| builder.multiply(scaled[i][k], self.factors[i][k])).map(Signed::negated);
            let terms: Vec<Signed> = whole.into_iter().chain(known.collect::<Vec<_>>()).collect();
            let is_whole = terms.len() == 1;
            let pivot = builder.sum(terms);
            let pivot = builder.keep(Block::Inertia, &format!("free_inertia_{name}"), pivot);
            let inverse = builder.reciprocal(pivot);
            let inverse = builder.keep(Block::Inertia, &format!("inv_inertia_{name}"), inverse);
            self.inverse_inertia.push(inverse);
            if !is_whole {
                let kept = builder.multiply(whole, inverse);
                self.kept_inertia.push(builder.keep(Block::Inertia, &format!("loss_{name}"), kept));
            }
        }
    }

    /// The independent coordinates.
    pub(super) fn independent(&self) -> &[usize] {
        &self.independent
    }

    /// Whether some constraint has no dependent coordinate.
    pub(super) fn has_repeated(&self) -> bool {
        self.pivots.len() < self.constraints
    }

    /// Whether every constraint has a dependent coordinate, every independent coordinate has inertia, and growth
    /// factors tell each pivot that vanishes.
    pub(super) fn is_valid_everywhere(&self) -> bool {
        !self.has_repeated() && !self.has_lone_pivot && self.inverse_inertia.iter().all(Option::is_some)
    }

    /// The ratio of the other entries in a pivot's column to the pivot.
    fn pivot_ratios(&mut self, builder: &mut Builder, jacobian: &Matrix) {
        for ((row, column), inverse) in self.pivots.iter().zip(&self.inverses) {
            let is_filled = |entry: &Value| entry.is_some_and(|value| !builder.is_zero(value));
            let is_alone = jacobian[*row].iter().filter(|entry| is_filled(entry)).count() == 1
                && jacobian.iter().filter(|entries| is_filled(&entries[*column])).count() == 1;
            let is_constant = jacobian[*row][*column].is_none_or(|pivot| builder.lowering.graph.is_constant(pivot.id));
            self.has_lone_pivot |= is_alone && !is_constant;
            for other in (0..self.constraints).filter(|other| other != row) {
                let ratio = builder.multiply(jacobian[other][*column], *inverse);
                let constraints = &builder.scene.constraints;
                let (above, below) = (&constraints[other].name, &constraints[*row].name);
                let name = format!("{above}_over_{below}_{}", self.name(builder, *column));
                self.pivot_ratios.push(builder.keep(Block::Tangents, &name, ratio));
            }
        }
    }

    /// Measures of the growth of rounding errors: how strongly the dependent coordinates follow the independent ones,
    /// how much of an inertia cancelled, and how small the pivots became.
    pub(super) fn growth_factors(&self) -> Vec<Value> {
        let tangents = self.tangents.iter().zip(&self.independent).flat_map(|(tangent, by)| {
            tangent.iter().enumerate().filter(move |(i, _)| i != by).map(|(_, value)| *value)
        });
        let all = tangents.chain(self.kept_inertia.iter().chain(&self.pivot_ratios).copied()).flatten();
        // Several pivots may be compared with the same value.
        let mut seen = HashSet::new();
        all.filter(|value| seen.insert(value.id)).map(Some).collect()
    }
}
