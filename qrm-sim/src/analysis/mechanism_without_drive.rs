//! A mechanism at time zero whose drive can be moved.

use qrm_core::{
    Description, DynamicsMut, LoopConstraintsMut, Mechanism, QuantityDescription, Schedule, StartMut, StateRef,
};

use crate::position::{NotAssembled, Start, assemble};
use crate::solve::{Dynamics, LoopConstraints};

/// A mechanism at time zero with one additional given coordinate: the value that a drive prescribes.
///
/// The constraint `C_k(q, t)` of the drive becomes `C_k(q, 0) - s`. If it contains a single coordinate, `s` has the
/// name and the value of that coordinate. Otherwise `s` has the name of the constraint, and is zero at the start.
pub struct MechanismWithoutDrive {
    mechanism: Box<dyn Mechanism>,
    description: &'static Description,
    /// The constraint of the drive.
    constraint: usize,
    /// The residual that is taken as zero.
    offset: f64,
    start: Start,
}

impl MechanismWithoutDrive {
    /// Releases the drive of this constraint.
    ///
    /// # Errors
    /// The mechanism cannot be assembled.
    pub fn new(mechanism: Box<dyn Mechanism>, constraint: usize) -> Result<Self, NotAssembled> {
        Self::described(mechanism, constraint, None)
    }

    /// Releases the same drive in the mechanism with other parameters.
    ///
    /// # Errors
    /// The mechanism cannot be assembled.
    pub fn with(&self, mechanism: Box<dyn Mechanism>) -> Result<Self, NotAssembled> {
        Self::described(mechanism, self.constraint, Some(self.description))
    }

    fn described(
        mechanism: Box<dyn Mechanism>,
        constraint: usize,
        description: Option<&'static Description>,
    ) -> Result<Self, NotAssembled> {
        let (q, qd) = assemble(&*mechanism, Start::new(&*mechanism))?;
        let constraints = LoopConstraints::at(&*mechanism, 0.0, &q);
        let row = &constraints.constraint_jacobian[constraint];
        let mut moved = (0..q.len()).filter(|&i| row[i] != 0.0);
        let coordinate = moved.next().filter(|&i| row[i] == 1.0 && moved.next().is_none());
        let description = description.unwrap_or_else(|| {
            let own = mechanism.description();
            let added = coordinate.map_or(own.constraints[constraint], |i| own.coordinates[i]);
            let coordinates: Vec<QuantityDescription> = own.coordinates.iter().copied().chain([added]).collect();
            Box::leak(Box::new(Description { coordinates: coordinates.leak(), ..*own }))
        });
        let value = coordinate.map_or(0.0, |i| q[i]);
        let mut start = Start { q, qd, ..Start::new(&*mechanism) };
        start.q.push(value);
        start.qd.push(-constraints.constraint_rate[constraint]);
        start.given.push(true);
        start.given_rates.push(true);
        let mut released = Self { mechanism, description, constraint, offset: -value, start };
        if assemble(&released, Start::new(&released)).is_err() {
            // Other drives keep their prescribed values fixed.
            released.start.qd.fill(0.0);
            released.start.given_rates.fill(false);
        }
        Ok(released)
    }

    /// The coordinates of the original mechanism.
    fn inner<'a>(&self, q: &'a [f64]) -> &'a [f64] {
        &q[..q.len() - 1]
    }

    /// Writes rows with an additional column: nonzero only for the constraint of the drive.
    fn write_jacobian(&self, rows: &[f64], to: &mut [f64]) {
        let n = self.start.q.len();
        for (row, own) in to.chunks_exact_mut(n).zip(rows.chunks_exact(n - 1)) {
            row[..n - 1].copy_from_slice(own);
            row[n - 1] = 0.0;
        }
        to[self.constraint * n + n - 1] = -1.0;
    }

    /// Writes a matrix with an additional row and column of zeros.
    fn write_mass_matrix(&self, rows: &[f64], to: &mut [f64]) {
        let n = self.start.q.len();
        to.fill(0.0);
        for (row, own) in to.chunks_exact_mut(n).zip(rows.chunks_exact(n - 1)) {
            row[..n - 1].copy_from_slice(own);
        }
    }
}

impl Mechanism for MechanismWithoutDrive {
    fn description(&self) -> &'static Description {
        self.description
    }

    fn parameters(&self) -> &[f64] {
        self.mechanism.parameters()
    }

    fn is_driven(&self) -> bool {
        false
    }

    fn operations(&self) -> usize {
        self.mechanism.operations()
    }

    fn start(&self, start: StartMut) {
        start.q.copy_from_slice(&self.start.q);
        start.qd.copy_from_slice(&self.start.qd);
        start.given.copy_from_slice(&self.start.given);
        start.given_rates.copy_from_slice(&self.start.given_rates);
    }

    fn schedule(&self) -> Schedule<f64> {
        self.mechanism.schedule()
    }

    fn event(&self, at: &StateRef) -> Option<f64> {
        let [q, qd, qdd] = [at.q, at.qd, at.qdd].map(|x| self.inner(x));
        self.mechanism.event(&StateRef { t: 0.0, q, qd, qdd, ..*at })
    }

    fn dynamics(&self, _: f64, q: &[f64], qd: &[f64], to: DynamicsMut) {
        let own = Dynamics::at(&*self.mechanism, 0.0, self.inner(q), self.inner(qd));
        self.write_mass_matrix(own.mass_matrix.entries(), to.mass_matrix);
        to.generalized_forces[..q.len() - 1].copy_from_slice(&own.generalized_forces);
        to.generalized_forces[q.len() - 1] = 0.0;
        self.write_jacobian(own.constraint_jacobian.entries(), to.constraint_jacobian);
        to.constraint_bias.copy_from_slice(&own.constraint_bias);
    }

    fn loop_constraints(&self, _: f64, q: &[f64], to: LoopConstraintsMut) {
        let own = LoopConstraints::at(&*self.mechanism, 0.0, self.inner(q));
        to.residuals.copy_from_slice(&own.residuals);
        to.residuals[self.constraint] -= q[q.len() - 1] + self.offset;
        self.write_jacobian(own.constraint_jacobian.entries(), to.constraint_jacobian);
        // Other drives keep their prescribed values fixed.
        to.constraint_rate.fill(0.0);
    }

    fn mass_matrix(&self, q: &[f64], mass_matrix: &mut [f64]) {
        let mut own = vec![0.0; (q.len() - 1).pow(2)];
        self.mechanism.mass_matrix(self.inner(q), &mut own);
        self.write_mass_matrix(&own, mass_matrix);
    }

    fn energy(&self, q: &[f64], qd: &[f64]) -> [f64; 2] {
        self.mechanism.energy(self.inner(q), self.inner(qd))
    }

    fn power(&self, _: f64, q: &[f64], qd: &[f64], qdd: &[f64], multipliers: &[f64]) -> f64 {
        self.mechanism.power(0.0, self.inner(q), self.inner(qd), self.inner(qdd), multipliers)
    }

    fn outputs(&self, _: f64, q: &[f64], qd: &[f64], qdd: &[f64], multipliers: &[f64], outputs: &mut [f64]) {
        self.mechanism.outputs(0.0, self.inner(q), self.inner(qd), self.inner(qdd), multipliers, outputs);
    }
}
