//! Elimination of the sparse equations of motion, in an order that preserves zeros.

use std::cmp::Reverse;

use super::super::algebra::Value;
use super::super::block::Block;
use super::super::builder::Builder;
use super::sparse_symmetric_matrix::SparseSymmetricMatrix;
use super::variables::Variables;
use crate::graph::Signed;

/// One step of an elimination.
enum Step {
    /// A named quantity is replaced by its definition.
    Substitution(usize),
    /// A row is solved for a coordinate or a multiplier.
    Pivot {
        variable: usize,
        inverse: Value,
        /// The other variables of the row, with the entries divided by the pivot.
        ratios: Vec<(usize, Value)>,
    },
}

/// The factored equations of motion.
pub(super) struct SparseElimination {
    steps: Vec<Step>,
    /// The growth factor of each pivot: its unreduced value divided by it.
    pub(super) growth_factors: Vec<Value>,
    constraints: usize,
    /// The names of the variables and of the constraints.
    names: Vec<String>,
}

impl SparseElimination {
    /// Factors the equations; `None` if a pivot is zero by structure. Multipliers follow the variables, and are
    /// eliminated after all coordinates of their constraints: pivots of coordinates are then positive, those of
    /// multipliers negative.
    pub(super) fn new(
        builder: &mut Builder,
        variables: &Variables,
        inertia: SparseSymmetricMatrix,
        jacobian: &[Vec<(usize, Value)>],
    ) -> Option<Self> {
        let (count, m) = (variables.count(), jacobian.len());
        let names: Vec<String> = (0..count)
            .map(|z| variables.name(z).to_owned())
            .chain(builder.scene.constraints.iter().map(|constraint| constraint.name.clone()))
            .collect();
        let name = |z: usize| names[z].clone();
        let mut form = inertia;
        form.grow(count + m);
        for (k, row) in jacobian.iter().enumerate() {
            row.iter().for_each(|(z, by)| form.add(*z, count + k, *by));
        }
        // How many definitions use each variable.
        let mut uses = vec![0_usize; count + m];
        for (z, _) in variables.definitions.iter().flatten() {
            uses[*z] += 1;
        }
        let is_named = |z: usize| z >= variables.coordinates() && z < count;
        let definition = |z: usize| &variables.definitions[z - variables.coordinates()];
        let (mut steps, mut growth_factors) = (Vec::new(), Vec::new());
        let mut left: Vec<usize> = (0..count + m).collect();
        while !left.is_empty() {
            let is_ready = |&&z: &&usize| uses[z] == 0 && (z < count || form.neighbours(z).iter().all(|u| *u >= count));
            // How many variables a step couples with each other; without the coordinates that can follow at once.
            let cost = |&&z: &&usize| {
                let definition = if is_named(z) { definition(z).as_slice() } else { &[] };
                let released = definition.iter().filter(|(u, _)| *u < variables.coordinates() && uses[*u] == 1).count();
                let new = definition.iter().filter(|(u, _)| !form.neighbours(z).contains(u)).count();
                (form.neighbours(z).len() + new - released.min(new), Reverse(released), Reverse(z))
            };
            let z = left.iter().filter(is_ready).min_by_key(cost).copied()?;
            left.retain(|other| *other != z);
            if is_named(z) {
                definition(z).iter().for_each(|(u, _)| uses[*u] -= 1);
                form.substitute(builder, z, definition(z), name);
                steps.push(Step::Substitution(z));
                continue;
            }
            let is_multiplier = z >= count;
            let pivot = form.entry(builder, [z, z], name)?;
            let inverse = builder.reciprocal(Some(pivot));
            let inverse = builder.keep(Block::Inertia, &format!("inv_{}", names[z]), inverse);
            let before = form.unreduced(builder, z, &names[z]);
            if before.is_some_and(|before| before.id != pivot.id) {
                let loss = builder.multiply(before, inverse);
                growth_factors.push(builder.keep(Block::Inertia, &format!("loss_{}", names[z]), loss));
            }
            let row: Vec<(usize, Value)> =
                form.neighbours(z).clone().into_iter().map(|u| (u, form.entry(builder, [z, u], name))).collect();
            form.remove(z);
            let ratio = |builder: &mut Builder, u: usize, entry: Value| match entry {
                Some(entry) if entry.id == pivot.id => {
                    let one = builder.lowering.graph.number(1.0);
                    Some(Signed { negative: entry.negative != pivot.negative, ..one })
                }
                _ => {
                    let ratio = builder.multiply(entry, inverse);
                    builder.keep(Block::Inertia, &format!("ratio_{}_{}", names[z], names[u]), ratio)
                }
            };
            let ratios: Vec<(usize, Value)> = row.iter().map(|(u, entry)| (*u, ratio(builder, *u, *entry))).collect();
            // If `u = z + ...`, both columns are equal: the whole inertia of `z` leaves `u` without cancellation.
            for (u, _) in row.iter().filter(|(_, entry)| entry.is_some_and(|entry| entry.id == pivot.id)) {
                form.remove_unreduced(*u, before);
            }
            for (i, (u, entry)) in row.iter().enumerate() {
                for (v, ratio) in &ratios[..=i] {
                    let product = builder.multiply(*entry, *ratio).map(Signed::negated);
                    form.add(*u, *v, product);
                    // Pivots of multipliers are negative.
                    if u == v && (*u >= count) != is_multiplier {
                        form.add_unreduced(*u, product);
                    }
                }
            }
            steps.push(Step::Pivot { variable: z, inverse, ratios });
        }
        Some(Self { steps, growth_factors, constraints: m, names })
    }

    /// Solves the equations for forces along the variables, and a required `C_q qdd`. Returns the accelerations of all
    /// variables without their biases, and the multipliers.
    pub(super) fn solve(
        &self,
        builder: &mut Builder,
        variables: &Variables,
        forces: Vec<Vec<Signed>>,
        closing: &[Value],
        block: Block,
        what: &str,
    ) -> (Vec<Value>, Vec<Value>) {
        let count = variables.count();
        let mut right: Vec<Vec<Signed>> = forces;
        right.extend(closing.iter().map(|value| value.iter().copied().collect()));
        let names = &self.names;
        let definition = |z: usize| &variables.definitions[z - variables.coordinates()];
        let mut reduced: Vec<Value> = vec![None; count + self.constraints];
        for step in &self.steps {
            let (Step::Substitution(z) | Step::Pivot { variable: z, .. }) = step;
            let sum = builder.sum(std::mem::take(&mut right[*z]));
            let own = builder.keep(block, &format!("right_{}_{what}", names[*z]), sum);
            reduced[*z] = own;
            match step {
                Step::Substitution(z) => {
                    for (u, by) in definition(*z) {
                        right[*u].extend(builder.multiply(*by, own));
                    }
                }
                Step::Pivot { ratios, .. } => {
                    for (u, ratio) in ratios {
                        right[*u].extend(builder.multiply(*ratio, own).map(Signed::negated));
                    }
                }
            }
        }
        let mut solved: Vec<Value> = vec![None; count + self.constraints];
        for step in self.steps.iter().rev() {
            let (z, terms) = match step {
                Step::Substitution(z) => {
                    let moved = definition(*z).iter().filter_map(|(u, by)| builder.multiply(*by, solved[*u]));
                    (*z, moved.collect::<Vec<Signed>>())
                }
                Step::Pivot { variable, inverse, ratios } => {
                    let own = builder.multiply(reduced[*variable], *inverse);
                    let others = ratios
                        .iter()
                        .filter_map(|(u, ratio)| builder.multiply(*ratio, solved[*u]))
                        .map(Signed::negated);
                    (*variable, own.into_iter().chain(others.collect::<Vec<_>>()).collect())
                }
            };
            let sum = builder.sum(terms);
            let name = if z < count { format!("{}_{what}", names[z]) } else { format!("lambda_{}", names[z]) };
            solved[z] = builder.keep(block, &name, sum);
        }
        let multipliers = solved.split_off(count);
        (solved, multipliers)
    }
}
