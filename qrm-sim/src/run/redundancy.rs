//! Redundant constraints, and the forces that are therefore not unique.

use qrm_core::Mechanism;

use crate::solve::{LoopConstraints, PivotedLdl, constraint_rank, largest, row_products};
use crate::state::State;

/// Constraints that are redundant along the whole motion.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Redundancy {
    /// The rank of `C_q`.
    pub rank: usize,
    /// The constraints whose multipliers are not unique; a run uses those of least norm.
    pub multipliers: Vec<usize>,
    /// The outputs that depend on the non-unique part of the multipliers.
    pub outputs: Vec<usize>,
}

/// The largest part of a constraint in a combination that is a rounding error.
const ROUNDING: f64 = 1e-6;

impl Redundancy {
    /// The redundancy of a mechanism at a closed position; `None` if all constraints are independent.
    pub fn at(mechanism: &dyn Mechanism, at: &State) -> Option<Self> {
        let count = at.multipliers.len();
        let rank = constraint_rank(mechanism, at.t, &at.q);
        if rank == count {
            return None;
        }
        let jacobian = LoopConstraints::at(mechanism, at.t, &at.q).constraint_jacobian;
        let products = row_products(&jacobian);
        let factors = PivotedLdl::with_rank(&products, rank);
        // The part of each multiplier without effect: `C_q'` times it is zero.
        let null_direction = |k: usize| {
            let mut part: Vec<f64> = products.iter().map(|row| row[k]).collect();
            factors.solve(&mut part);
            part.iter_mut().for_each(|part| *part = -*part);
            part[k] += 1.0;
            part
        };
        let null_directions: Vec<Vec<f64>> =
            (0..count).map(null_direction).filter(|part| largest(part).1 > ROUNDING).collect();
        let multipliers = (0..count).filter(|&k| null_directions.iter().any(|part| part[k].abs() > ROUNDING)).collect();

        let size = largest(&at.multipliers).1.max(1.0);
        let outputs = |multipliers: &[f64]| {
            let mut outputs = vec![0.0; mechanism.description().outputs.len()];
            mechanism.outputs(at.t, &at.q, &at.qd, &at.qdd, multipliers, &mut outputs);
            outputs
        };
        let own = outputs(&at.multipliers);
        // The changes of all outputs for multipliers along a direction.
        let changes = |direction: &[f64]| -> Vec<f64> {
            let moved: Vec<f64> = at.multipliers.iter().zip(direction).map(|(own, part)| own + size * part).collect();
            outputs(&moved).iter().zip(&own).map(|(moved, own)| (moved - own).abs()).collect()
        };
        let unit = |k: usize| (0..count).map(|i| f64::from(u8::from(i == k))).collect::<Vec<f64>>();
        let units: Vec<Vec<f64>> = (0..count).map(|k| changes(&unit(k))).collect();
        let changes_along: Vec<Vec<f64>> = null_directions.iter().map(|part| changes(part)).collect();
        let is_not_unique = |output: usize| {
            let by_all: f64 = units.iter().map(|changes| changes[output]).sum();
            changes_along.iter().any(|changes| changes[output] > ROUNDING * by_all)
        };
        let outputs = (0..own.len()).filter(|&output| is_not_unique(output)).collect();
        Some(Self { rank, multipliers, outputs })
    }
}
