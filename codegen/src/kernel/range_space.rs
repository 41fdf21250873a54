//! Range-space method for the linear equations of a kernel: sparse triangular factors of `Mbar` and `C_q Mbar^-1 C_q'`.
//! If bodies have their own coordinates, the cost grows linearly with their number, and the number of degrees of
//! freedom does not matter.

use super::algebra::{Matrix, Value};
use super::block::Block;
use super::builder::Builder;
use crate::graph::Signed;

/// A factored system.
pub(super) struct RangeSpace {
    mass: Triangles,
    jacobian: Matrix,
    /// `Mbar^-1 C_q'`, a row for each constraint.
    pull: Matrix,
    /// `C_q Mbar^-1 C_q'`
    loops: Triangles,
}

impl RangeSpace {
    /// Factors the system; `None` if a coordinate has no mass.
    pub(super) fn new(builder: &mut Builder, jacobian: &Matrix, mass: &Matrix) -> Option<Self> {
        let coordinates: Vec<String> = builder.scene.coordinates.iter().map(|c| c.name.clone()).collect();
        let constraints: Vec<String> = builder.scene.constraints.iter().map(|c| c.name.clone()).collect();
        let mass = Triangles::new(builder, Block::InverseMassJacobian, mass, &coordinates)?;
        let mut pull: Matrix = Vec::new();
        for (row, constraint) in jacobian.iter().zip(&constraints) {
            let solved = mass.solve(builder, Block::InverseMassJacobian, row, &format!("by_{constraint}"));
            let named = solved.into_iter().enumerate().map(|(i, value)| {
                builder.keep(Block::InverseMassJacobian, &format!("{}_by_{constraint}", coordinates[i]), value)
            });
            pull.push(named.collect());
        }
        let m = jacobian.len();
        let mut loops: Matrix = vec![vec![None; m]; m];
        for k in 0..m {
            for l in 0..=k {
                let value = builder.dot(&jacobian[k], &pull[l]);
                let name = format!("{}_on_{}", constraints[l], constraints[k]);
                loops[k][l] = builder.keep(Block::RangeSpaceMatrix, &name, value);
                loops[l][k] = loops[k][l];
            }
        }
        let loops = Triangles::new(builder, Block::RangeSpaceMatrix, &loops, &constraints)?;
        Some(Self { mass, jacobian: jacobian.clone(), pull, loops })
    }

    /// The fraction of each diagonal entry that its pivot kept: small pivots amplify rounding errors.
    pub(super) fn growth_factors(&self) -> Vec<Value> {
        self.mass.losses.iter().chain(&self.loops.losses).copied().collect()
    }

    /// Computes accelerations and multipliers; `closing` is the required `C_q qdd`.
    pub(super) fn accelerations(
        &self,
        builder: &mut Builder,
        closing: &[Value],
        forces: &[Value],
    ) -> (Vec<Value>, Vec<Value>) {
        let free = self.mass.solve(builder, Block::Accelerations, forces, "freely");
        let free: Vec<Value> = free
            .into_iter()
            .enumerate()
            .map(|(i, value)| builder.keep(Block::Accelerations, &format!("{}_free", self.mass.names[i]), value))
            .collect();
        let open: Vec<Value> = (0..self.jacobian.len())
            .map(|k| {
                let moved = builder.dot(&self.jacobian[k], &free);
                builder.difference(moved, closing[k])
            })
            .collect();
        let multipliers = self.loops.solve(builder, Block::Multipliers, &open, "lambda");
        let qdd =
            self.moved(builder, &free, &multipliers.iter().map(|value| value.map(Signed::negated)).collect::<Vec<_>>());
        let named = qdd
            .into_iter()
            .enumerate()
            .map(|(i, value)| builder.keep(Block::Accelerations, &format!("{}_ddot", self.mass.names[i]), value));
        (named.collect(), multipliers)
    }

    /// Computes the smallest change of coordinates with `C_q dq = closing`.
    pub(super) fn correction(&self, builder: &mut Builder, closing: &[Value]) -> Vec<Value> {
        let weights = self.loops.solve(builder, Block::Correction, closing, "weight");
        let rest = vec![None; self.mass.names.len()];
        self.moved(builder, &rest, &weights)
    }

    /// `x + Mbar^-1 C_q' weights`
    fn moved(&self, builder: &mut Builder, x: &[Value], weights: &[Value]) -> Vec<Value> {
        let coordinate = |(i, x): (usize, &Value)| {
            let mut terms: Vec<Signed> = x.iter().copied().collect();
            terms.extend(self.pull.iter().zip(weights).filter_map(|(row, weight)| builder.multiply(row[i], *weight)));
            builder.sum(terms)
        };
        x.iter().enumerate().map(coordinate).collect()
    }
}

/// A symmetric matrix as `L D L'`, with rows and columns in an order that keeps it sparse.
struct Triangles {
    names: Vec<String>,
    order: Vec<usize>,
    /// `L` without its unit diagonal, in that order.
    lower: Matrix,
    inverse_pivots: Vec<Value>,
    losses: Vec<Value>,
}

impl Triangles {
    /// Factors a matrix; `None` if a pivot is zero by structure.
    fn new(builder: &mut Builder, block: Block, matrix: &Matrix, names: &[String]) -> Option<Self> {
        let order = sparse_order(matrix);
        let n = order.len();
        // L times D.
        let mut scaled: Matrix = vec![vec![None; n]; n];
        let mut factors = Self {
            names: names.to_vec(),
            order,
            lower: vec![vec![None; n]; n],
            inverse_pivots: Vec::new(),
            losses: Vec::new(),
        };
        for i in 0..n {
            let row = factors.order[i];
            for j in 0..i {
                let own = matrix[row][factors.order[j]];
                let known =
                    (0..j).filter_map(|k| builder.multiply(scaled[i][k], factors.lower[j][k])).map(Signed::negated);
                let terms = own.into_iter().chain(known.collect::<Vec<_>>()).collect();
                let sum = builder.sum(terms);
                let (above, name) = (&names[factors.order[j]], &names[row]);
                scaled[i][j] = builder.keep(block, &format!("rest_{above}_{name}"), sum);
                let ratio = builder.multiply(scaled[i][j], factors.inverse_pivots[j]);
                factors.lower[i][j] = builder.keep(block, &format!("share_{above}_{name}"), ratio);
            }
            let whole = matrix[row][row]?;
            let known = (0..i).filter_map(|k| builder.multiply(scaled[i][k], factors.lower[i][k])).map(Signed::negated);
            let terms: Vec<Signed> = std::iter::once(whole).chain(known.collect::<Vec<_>>()).collect();
            let is_whole = terms.len() == 1;
            let pivot = builder.sum(terms)?;
            let pivot = builder.keep(block, &format!("pivot_{}", names[row]), Some(pivot));
            let inverse = builder.reciprocal(pivot);
            let inverse = builder.keep(block, &format!("inv_pivot_{}", names[row]), inverse);
            factors.inverse_pivots.push(inverse);
            if !is_whole {
                let loss = builder.multiply(Some(whole), inverse);
                factors.losses.push(builder.keep(block, &format!("loss_{}", names[row]), loss));
            }
        }
        Some(factors)
    }

    fn solve(&self, builder: &mut Builder, block: Block, right: &[Value], what: &str) -> Vec<Value> {
        let n = self.order.len();
        let mut y: Vec<Value> = Vec::new();
        for i in 0..n {
            let mut terms: Vec<Signed> = right[self.order[i]].into_iter().collect();
            terms.extend((0..i).filter_map(|k| builder.multiply(self.lower[i][k], y[k])).map(Signed::negated));
            let sum = builder.sum(terms);
            y.push(builder.keep(block, &format!("{what}_{}_down", self.names[self.order[i]]), sum));
        }
        let mut x: Vec<Value> = vec![None; n];
        for i in (0..n).rev() {
            let mut terms: Vec<Signed> = builder.multiply(y[i], self.inverse_pivots[i]).into_iter().collect();
            let later =
                (i + 1..n).filter_map(|k| builder.multiply(self.lower[k][i], x[self.order[k]])).map(Signed::negated);
            terms.extend(later.collect::<Vec<_>>());
            let sum = builder.sum(terms);
            x[self.order[i]] = builder.keep(block, &format!("{what}_{}", self.names[self.order[i]]), sum);
        }
        x
    }
}

/// Orders rows with few neighbours first, counted during the elimination of earlier rows.
fn sparse_order(matrix: &Matrix) -> Vec<usize> {
    let n = matrix.len();
    let mut filled: Vec<Vec<bool>> = matrix.iter().map(|row| row.iter().map(Option::is_some).collect()).collect();
    let mut left: Vec<usize> = (0..n).collect();
    let mut order = Vec::new();
    while let Some(&next) = left.iter().min_by_key(|&&i| (left.iter().filter(|&&j| filled[i][j]).count(), i)) {
        left.retain(|&i| i != next);
        let neighbours: Vec<usize> = left.iter().copied().filter(|&i| filled[next][i]).collect();
        for &i in &neighbours {
            for &j in &neighbours {
                filled[i][j] = true;
            }
        }
        order.push(next);
    }
    order
}
