//! The solutions of a factored system.

use super::NullSpace;
use crate::graph::Signed;
use crate::kernel::algebra::Value;
use crate::kernel::block::Block;
use crate::kernel::builder::Builder;

impl NullSpace {
    /// A solution of `C_q x = right` whose independent coordinates are zero.
    pub(in crate::kernel) fn particular(
        &self,
        builder: &mut Builder,
        right: &[Value],
        block: Block,
        what: &str,
    ) -> Vec<Value> {
        let solved = self.solve(builder, right, |builder, k, value| {
            let name = format!("{}_{what}", self.name(builder, self.pivots[k].1));
            builder.keep(block, &name, value)
        });
        let mut x = vec![None; self.mass.len()];
        for (k, value) in solved.into_iter().enumerate() {
            x[self.pivots[k].1] = value;
        }
        x
    }

    /// The solution of `C_q x = ...` with `T' (Mbar x - forces) = 0`.
    pub(in crate::kernel) fn free(
        &self,
        builder: &mut Builder,
        particular: &[Value],
        forces: Option<&[Value]>,
        block: Block,
        what: &str,
    ) -> Vec<Value> {
        let f = self.independent.len();
        let mut y: Vec<Value> = Vec::new();
        for place in 0..f {
            let mut terms: Vec<Signed> = Vec::new();
            if let Some(forces) = forces {
                terms.extend(self.tangents[place].iter().zip(forces).filter_map(|(t, f)| builder.multiply(*t, *f)));
            }
            terms.extend(
                self.momenta[place]
                    .iter()
                    .zip(particular)
                    .filter_map(|(u, p)| builder.multiply(*u, *p))
                    .map(Signed::negated),
            );
            terms
                .extend((0..place).filter_map(|k| builder.multiply(self.factors[place][k], y[k])).map(Signed::negated));
            let sum = builder.sum(terms);
            let name = self.name(builder, self.independent[place]);
            y.push(builder.keep(block, &format!("drive_{name}_{what}"), sum));
        }
        let mut a: Vec<Value> = vec![None; f];
        for place in (0..f).rev() {
            let own = builder.multiply(y[place], self.inverse_inertia[place]);
            let others =
                (place + 1..f).filter_map(|k| builder.multiply(self.factors[k][place], a[k])).map(Signed::negated);
            let terms = own.into_iter().chain(others.collect::<Vec<_>>()).collect();
            let sum = builder.sum(terms);
            let name = format!("{}_{what}", self.name(builder, self.independent[place]));
            a[place] = builder.keep(block, &name, sum);
        }
        let coordinate = |builder: &mut Builder, i: usize| {
            if let Some(place) = self.independent.iter().position(|&by| by == i) {
                return a[place];
            }
            let mut terms: Vec<Signed> = particular[i].into_iter().collect();
            terms.extend((0..f).filter_map(|k| builder.multiply(self.tangents[k][i], a[k])));
            let sum = builder.sum(terms);
            let name = format!("{}_{what}", self.name(builder, i));
            builder.keep(block, &name, sum)
        };
        (0..self.mass.len()).map(|i| coordinate(builder, i)).collect()
    }

    /// The multipliers: `C_q' lambda = forces - Mbar qdd` in the rows of dependent coordinates.
    pub(in crate::kernel) fn multipliers(
        &self,
        builder: &mut Builder,
        forces: &[Value],
        accelerations: &[Value],
    ) -> Vec<Value> {
        let m = self.pivots.len();
        let excess = |builder: &mut Builder, i: usize| {
            let mut terms: Vec<Signed> = forces[i].into_iter().collect();
            terms.extend(
                self.mass[i]
                    .iter()
                    .zip(accelerations)
                    .filter_map(|(m, a)| builder.multiply(*m, *a))
                    .map(Signed::negated),
            );
            terms
        };
        let mut x: Vec<Value> = vec![None; m];
        for k in 0..m {
            let mut terms = excess(builder, self.pivots[k].1);
            terms.extend((0..k).filter_map(|j| builder.multiply(self.upper[j][k], x[j])).map(Signed::negated));
            let sum = builder.sum(terms);
            x[k] = if (k + 1..m).any(|j| self.upper[k][j].is_some()) {
                builder.keep(Block::Multipliers, &format!("excess_{}", self.name(builder, self.pivots[k].1)), sum)
            } else {
                sum
            };
        }
        let mut multipliers = vec![None; self.constraints];
        for k in (0..m).rev() {
            let mut terms: Vec<Signed> = x[k].into_iter().collect();
            let (row, _) = self.pivots[k];
            terms.extend((k + 1..m).filter_map(|i| builder.multiply(self.lower[i][k], x[i])).map(Signed::negated));
            let sum = builder.sum(terms);
            let value = builder.multiply(sum, self.inverses[k]);
            let name = format!("lambda_{}", builder.scene.constraints[row].name);
            x[k] = builder.keep(Block::Multipliers, &name, value);
            multipliers[row] = x[k];
        }
        multipliers
    }
}
