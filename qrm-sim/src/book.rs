//! What is noted of every row while a run goes on.

use qrm_core::Mechanism;

use crate::balance::Balance;
use crate::linear::largest;
use crate::motion::Moment;
use crate::observer::{Observer, Row};
use crate::outcome::{Status, Undefined};
use crate::rank::Rank;

/// The notes.
#[derive(Debug)]
pub(crate) struct Book {
    outputs: Vec<f64>,
    /// Rows kept.
    pub(crate) rows: u64,
    /// Largest residual of a constraint in any row, and which constraint.
    pub(crate) residual_position: (usize, f64),
    /// Largest rate of a residual in any row, and of which constraint.
    pub(crate) residual_velocity: (usize, f64),
    first_energy: f64,
    /// Largest kinetic energy in any row.
    pub(crate) largest_kinetic_energy: f64,
    /// Largest energy in any row, kinetic and potential.
    pub(crate) largest_energy: f64,
    /// Largest change of the energy.
    pub(crate) energy_drift: f64,
    /// Whether no load without potential did work.
    pub(crate) is_conservative: bool,
    /// Energy against work.
    pub(crate) balance: Balance,
    /// How near the constraints came to saying too little.
    pub(crate) rank: Rank,
}

impl Book {
    pub(crate) fn new<X: Mechanism<N, M>, const N: usize, const M: usize>(mechanism: &X, first: &Moment<N, M>) -> Self {
        Self {
            outputs: vec![0.0; X::DESCRIPTION.outputs.len()],
            rows: 0,
            residual_position: (0, 0.0),
            residual_velocity: (0, 0.0),
            first_energy: mechanism.energy(&first.q, &first.qd).iter().sum(),
            largest_kinetic_energy: 0.0,
            largest_energy: 0.0,
            energy_drift: 0.0,
            is_conservative: true,
            balance: Balance::default(),
            rank: Rank::default(),
        }
    }

    /// Completes moments to rows and hands them on.
    pub(crate) fn keep<X: Mechanism<N, M>, const N: usize, const M: usize>(
        &mut self,
        mechanism: &X,
        moments: &[Moment<N, M>],
        observer: &mut dyn Observer,
    ) -> Result<(), Status> {
        for at in moments {
            let Moment { t, q, qd, qdd, multipliers, corrections } = at;
            mechanism.outputs(*t, q, qd, qdd, multipliers, &mut self.outputs);
            let closure = mechanism.closure(*t, q);
            let position = largest(&closure.constraints);
            let velocity = largest(&closure.drift(qd));
            self.rank.note(self.rows, *t, &closure.constraint_jacobian);
            let [kinetic, potential] = mechanism.energy(q, qd);
            let energy = kinetic + potential;
            if let Some(what) = self.undefined(energy) {
                return Err(Status::NotFinite { t: *t, what });
            }
            self.largest_energy = self.largest_energy.max(energy.abs()).max(potential.abs());
            self.largest_kinetic_energy = self.largest_kinetic_energy.max(kinetic);
            let power = mechanism.power(*t, q, qd, multipliers);
            self.is_conservative &= power == 0.0;
            self.energy_drift = self.energy_drift.max((energy - self.first_energy).abs());
            let worse = |old: (usize, f64), new: (usize, f64)| if new.1 > old.1 { new } else { old };
            self.residual_position = worse(self.residual_position, position);
            self.residual_velocity = worse(self.residual_velocity, velocity);
            let row = Row {
                index: self.rows,
                t: *t,
                q,
                qd,
                qdd,
                multipliers,
                outputs: &self.outputs,
                residual_position: position.1,
                residual_velocity: velocity.1,
                energy,
                power,
                corrections: *corrections,
            };
            observer.row(&row).and_then(|()| self.balance.row(&row)).map_err(Status::Unwritable)?;
            self.rows += 1;
        }
        Ok(())
    }

    /// Which number of the row under way is not finite.
    fn undefined(&self, energy: f64) -> Option<Undefined> {
        let output = self.outputs.iter().position(|value| !value.is_finite());
        output.map(Undefined::Output).or((!energy.is_finite()).then_some(Undefined::Energy))
    }
}
