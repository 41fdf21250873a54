//! The quantities of a motion whose errors are estimated.

use std::ops::Range;

use qrm_core::{Description, Mechanism, StateRef, Tape};

use crate::columns::Kind;

/// The numbers of coordinates, constraints and outputs of a mechanism: its quantities are coordinates, rates,
/// accelerations, multipliers, outputs and the energy, in this order.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Quantities {
    pub(super) n: usize,
    m: usize,
    outputs: usize,
}

impl Quantities {
    pub(crate) fn new(description: &Description, has_outputs: bool) -> Self {
        let outputs = if has_outputs { description.outputs.len() } else { 0 };
        Self { n: description.coordinates.len(), m: description.constraints.len(), outputs }
    }

    pub(crate) fn count(self) -> usize {
        3 * self.n + self.m + self.outputs + 1
    }

    /// The index ranges of quantities that depend on each other; each output is its own range.
    pub(crate) fn groups(self) -> Vec<Range<usize>> {
        let Self { n, m, outputs } = self;
        let motion = (0..3).map(|order| order * n..(order + 1) * n);
        let multipliers = 3 * n..3 * n + m;
        let others = (3 * n + m..=3 * n + m + outputs).map(|i| i..i + 1);
        motion.chain([multipliers]).chain(others).collect()
    }

    /// Whether each quantity depends on accelerations or multipliers, as far as the tape of the mechanism tells.
    pub(super) fn by_forces(self, mechanism: &dyn Mechanism) -> Vec<bool> {
        let Self { n, m, outputs } = self;
        let mut by_forces = vec![false; self.count()];
        by_forces[2 * n..3 * n + m].fill(true);
        let of_outputs = mechanism.tape().map(Tape::outputs_by_forces).unwrap_or_default();
        by_forces[3 * n + m..].iter_mut().zip(of_outputs).take(outputs).for_each(|(own, takes)| *own = takes);
        by_forces
    }

    /// The index of a column's quantity, if the column has extremes; `None` for times.
    pub(super) fn place_of_column(self, column: usize) -> Option<usize> {
        let column = column.checked_sub(1)?;
        // In the columns, coordinates, rates and accelerations alternate.
        Some(if column < 3 * self.n { column % 3 * self.n + column / 3 } else { column })
    }

    /// The index of a quantity; `None` if its errors are not estimated.
    pub(super) fn place(self, kind: Kind) -> Option<usize> {
        let Self { n, m, outputs } = self;
        match kind {
            Kind::Coordinate(i) => Some(i),
            Kind::Rate(i) => Some(n + i),
            Kind::Acceleration(i) => Some(2 * n + i),
            Kind::Multiplier(i) => Some(3 * n + i),
            Kind::Output(i) => (i < outputs).then_some(3 * n + m + i),
            Kind::Energy => Some(3 * n + m + outputs),
            Kind::Time | Kind::Parameter(_) | Kind::Residual | Kind::ResidualRate => None,
        }
    }

    /// Writes the quantities of a state.
    pub(super) fn write(self, mechanism: &dyn Mechanism, at: &StateRef, to: &mut [f64]) {
        let StateRef { t, q, qd, qdd, multipliers } = *at;
        let motion = [q, qd, qdd, multipliers].into_iter().flatten();
        to.iter_mut().zip(motion).for_each(|(to, number)| *to = *number);
        let (outputs, energy) = to[3 * self.n + self.m..].split_at_mut(self.outputs);
        if !outputs.is_empty() {
            mechanism.outputs(t, q, qd, qdd, multipliers, outputs);
        }
        energy[0] = mechanism.energy(q, qd).iter().sum();
    }
}
