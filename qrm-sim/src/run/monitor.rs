//! Rows with their outputs and checks, and the statistics of a run.

use qrm_core::{Mechanism, RowLayout, RowQuantities, StateRef};

use super::balance::Balance;
use super::extremes_tracker::ExtremesTracker;
use super::observer::{Observer, Row};
use super::outcome::{NonFiniteQuantity, Status};
use super::singularity_monitor::SingularityMonitor;
use crate::columns::write_row;
use crate::solve::{LoopConstraints, constraint_rank, largest};
use crate::state::{State, state_in};

/// The statistics over all rows of a run.
#[derive(Clone, Debug)]
pub(crate) struct RunMonitor {
    layout: RowLayout,
    outputs: Vec<f64>,
    /// The columns of the last row.
    pub(crate) columns: Vec<f64>,
    constraints: LoopConstraints,
    rates: Vec<f64>,
    /// The number of rows.
    pub(crate) rows: u64,
    /// The constraint with the largest residual in any row, and that residual.
    pub(crate) residual_position: (usize, f64),
    /// The constraint with the largest rate of its residual in any row, and that rate.
    pub(crate) residual_velocity: (usize, f64),
    /// The smallest and the largest value of each coordinate in any row.
    pub(crate) ranges: Vec<[f64; 2]>,
    first_energy: f64,
    /// Largest kinetic energy in any row.
    pub(crate) largest_kinetic_energy: f64,
    /// Largest energy in any row, kinetic and potential.
    pub(crate) largest_energy: f64,
    /// Largest change of the energy.
    pub(crate) energy_drift: f64,
    /// Whether no load without potential did work.
    pub(crate) is_conservative: bool,
    /// The energy balance.
    pub(crate) balance: Balance,
    /// The distance from singular positions.
    pub(crate) singularity: SingularityMonitor,
    /// The extremes of columns, if requested.
    extremes: Option<ExtremesTracker>,
}

/// The number of checks, which are the last columns.
const CHECKS: usize = 3;

impl RunMonitor {
    pub(crate) fn new(mechanism: &dyn Mechanism, first: &State, [has_outputs, has_extremes]: [bool; 2]) -> Self {
        let layout = RowLayout { n: first.q.len(), m: first.multipliers.len() };
        let rank = constraint_rank(mechanism, first.t, &first.q);
        Self {
            layout,
            outputs: vec![0.0; if has_outputs { mechanism.description().outputs.len() } else { 0 }],
            columns: Vec::new(),
            constraints: LoopConstraints::zero(layout.n, layout.m),
            rates: vec![0.0; layout.m],
            rows: 0,
            residual_position: (0, 0.0),
            residual_velocity: (0, 0.0),
            ranges: first.q.iter().map(|q| [*q; 2]).collect(),
            first_energy: first.energy(mechanism),
            largest_kinetic_energy: 0.0,
            largest_energy: 0.0,
            energy_drift: 0.0,
            is_conservative: true,
            balance: Balance::default(),
            singularity: SingularityMonitor::new(layout.m, layout.n, rank),
            extremes: has_extremes.then(ExtremesTracker::default),
        }
    }

    /// The number of entries of a row.
    pub(crate) fn width(&self) -> usize {
        self.layout.width()
    }

    /// Restarts the energy balance from a state, with another mechanism.
    pub(crate) fn change(&mut self, mechanism: &dyn Mechanism, first: &State) {
        self.first_energy = first.energy(mechanism);
        (self.energy_drift, self.is_conservative, self.balance) = (0.0, true, Balance::default());
    }

    /// The largest difference between energy and work: at the ends of all steps if a method chooses its steps,
    /// otherwise at the rows.
    pub(crate) fn imbalance(&self, of_steps: Option<f64>, of_rows: f64, is_conservative: bool) -> f64 {
        match of_steps {
            None => of_rows,
            // Rows between the steps must conserve the energy too.
            Some(of_steps) if is_conservative => of_steps.max(self.energy_drift),
            Some(of_steps) => of_steps,
        }
    }

    /// Completes rows by their outputs and checks, and passes them to the observer. Known states between rows count for
    /// extremes and ranges.
    ///
    /// # Errors
    /// A number of a row is not finite, or the observer cannot keep it.
    pub(crate) fn take(
        &mut self,
        mechanism: &dyn Mechanism,
        rows: &[f64],
        inner: &[f64],
        observer: &mut dyn Observer,
    ) -> Result<(), Status> {
        let width = self.layout.width();
        let mut inner = inner.chunks_exact(width).peekable();
        for row in rows.chunks_exact(width) {
            let at = state_in(self.layout, row);
            let StateRef { t, q, qd, qdd, multipliers } = at;
            let is_inner = |state: &&[f64]| state[0] < t;
            let has_inner = inner.peek().is_some_and(is_inner);
            while let Some(state) = inner.next_if(is_inner) {
                self.between(mechanism, state);
            }
            let RowQuantities { energy: [kinetic, potential], power } =
                mechanism.row_quantities(&at, &mut self.outputs, self.constraints.as_mut());
            let position = largest(&self.constraints.residuals);
            self.constraints.velocity_residual_into(qd, &mut self.rates);
            let velocity = largest(&self.rates);
            self.singularity.note(self.rows, t, &self.constraints.constraint_jacobian);
            let energy = kinetic + potential;
            if let Some(what) = self.undefined(energy) {
                return Err(Status::NotFinite { t, what });
            }
            self.widen(q);
            self.largest_energy = self.largest_energy.max(energy.abs()).max(potential.abs());
            self.largest_kinetic_energy = self.largest_kinetic_energy.max(kinetic);
            self.is_conservative &= power == 0.0;
            self.energy_drift = self.energy_drift.max((energy - self.first_energy).abs());
            let worse = |old: (usize, f64), new: (usize, f64)| if new.1 > old.1 { new } else { old };
            self.residual_position = worse(self.residual_position, position);
            self.residual_velocity = worse(self.residual_velocity, velocity);
            let checks = [position.1, velocity.1, energy];
            write_row(t, [q, qd, qdd], multipliers, &self.outputs, checks, &mut self.columns);
            self.note_extremes(t);
            let row = Row {
                index: self.rows,
                t,
                q,
                qd,
                qdd,
                multipliers,
                outputs: &self.outputs,
                columns: &self.columns,
                residual_position: position.1,
                residual_velocity: velocity.1,
                energy,
                power,
                corrections: row[self.layout.corrections()] as u32,
            };
            if has_inner {
                self.balance.skip_jump(&row);
            }
            observer.row(&row).and_then(|()| self.balance.row(&row)).map_err(Status::Unwritable)?;
            self.rows += 1;
        }
        Ok(())
    }

    /// Adds a state between rows, if its columns are defined.
    fn between(&mut self, mechanism: &dyn Mechanism, state: &[f64]) {
        let StateRef { t, q, qd, qdd, multipliers } = state_in(self.layout, state);
        self.widen(q);
        self.is_conservative &= mechanism.power(t, q, qd, qdd, multipliers) == 0.0;
        if self.extremes.is_none() {
            return;
        }
        mechanism.outputs(t, q, qd, qdd, multipliers, &mut self.outputs);
        if self.outputs.iter().all(|value| value.is_finite()) {
            write_row(t, [q, qd, qdd], multipliers, &self.outputs, [0.0; CHECKS], &mut self.columns);
            self.note_extremes(t);
        }
    }

    fn note_extremes(&mut self, t: f64) {
        if let Some(extremes) = &mut self.extremes {
            extremes.row(t, &self.columns[..self.columns.len() - CHECKS]);
        }
    }

    /// The extremes.
    pub(crate) fn extremes(&mut self) -> Option<&mut ExtremesTracker> {
        self.extremes.as_mut()
    }

    /// Extends the ranges by these coordinates.
    fn widen(&mut self, q: &[f64]) {
        for (range, q) in self.ranges.iter_mut().zip(q) {
            *range = [range[0].min(*q), range[1].max(*q)];
        }
    }

    /// The quantity of the current row that is not finite, if any.
    fn undefined(&self, energy: f64) -> Option<NonFiniteQuantity> {
        let output = self.outputs.iter().position(|value| !value.is_finite());
        output.map(NonFiniteQuantity::Output).or((!energy.is_finite()).then_some(NonFiniteQuantity::Energy))
    }
}
