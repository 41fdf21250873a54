//! Rows with their outputs and checks, and the statistics of a run.

use qrm_core::{Mechanism, RowLayout, RowQuantities, StateRef};

use super::balance::Balance;
use super::extreme_search::SEARCHES;
use super::extremes_tracker::ExtremesTracker;
use super::observer::{Observer, Row};
use super::outcome::{NonFiniteQuantity, Status};
use super::output_bounds::OutputBounds;
use super::singularity_monitor::SingularityMonitor;
use crate::columns::write_row;
use crate::solve::{LoopConstraints, SingularPositions, SingularityDistance, constraint_rank, largest};
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
    /// The distance from singular positions, and states near them.
    pub(crate) singularity: SingularityMonitor,
    singular_positions: Option<SingularPositions>,
    rank: usize,
    /// The time at which multipliers grow without bound, if they do.
    pub(crate) unbounded_at: Option<f64>,
    /// The extremes of columns, if requested.
    extremes: Option<ExtremesTracker>,
    /// The outputs whose extremes rows may not show.
    output_bounds: Option<OutputBounds>,
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
            singularity: SingularityMonitor::new(SingularityDistance::at(
                mechanism,
                rank,
                first.t,
                (&first.q, &first.qd),
            )),
            singular_positions: None,
            rank,
            unbounded_at: None,
            extremes: has_extremes.then(ExtremesTracker::default),
            output_bounds: if SEARCHES && has_extremes && has_outputs {
                OutputBounds::new(mechanism, layout)
            } else {
                None
            },
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

    /// Completes rows by their outputs and checks, and passes them to the observer; those near a singular position are
    /// replaced by states with all digits. Known states between rows count for extremes and ranges.
    ///
    /// # Errors
    /// A number of a row is not finite, or the observer cannot keep it.
    pub(crate) fn take(
        &mut self,
        mechanism: &dyn Mechanism,
        rows: &mut [f64],
        inner: &[f64],
        observer: &mut dyn Observer,
    ) -> Result<(), Status> {
        let width = self.layout.width();
        let mut inner = inner.chunks_exact(width).peekable();
        for row in rows.chunks_exact_mut(width) {
            let t = row[0];
            let is_inner = |state: &&[f64]| state[0] < t;
            let has_inner = inner.peek().is_some_and(is_inner);
            while let Some(state) = inner.next_if(is_inner) {
                self.between(mechanism, state);
            }
            let mut quantities =
                mechanism.row_quantities(&state_in(self.layout, row), &mut self.outputs, self.constraints.as_mut());
            if let Some(fraction) = self.singularity.note(self.rows, t, &self.constraints.constraint_jacobian)
                && self.replace(mechanism, fraction, row)
            {
                let at = state_in(self.layout, row);
                quantities = mechanism.row_quantities(&at, &mut self.outputs, self.constraints.as_mut());
            }
            let RowQuantities { energy: [kinetic, potential], power } = quantities;
            let StateRef { q, qd, qdd, multipliers, .. } = state_in(self.layout, row);
            let position = largest(&self.constraints.residuals);
            self.constraints.velocity_residual_into(qd, &mut self.rates);
            let velocity = largest(&self.rates);
            let energy = kinetic + potential;
            if let Some(what) = self.undefined(mechanism, row, energy) {
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
            self.note_extremes(row);
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

    /// Replaces a row near a singular position by the state with all digits; false if it is not determined.
    #[cold]
    fn replace(&mut self, mechanism: &dyn Mechanism, fraction: f64, row: &mut [f64]) -> bool {
        let StateRef { t, q, qd, .. } = state_in(self.layout, row);
        if self.singular_positions.is_none() {
            self.singular_positions = SingularPositions::new(mechanism, self.rank, t, q);
        }
        let positions = self.singular_positions.as_mut();
        let state = positions.and_then(|positions| positions.state(mechanism, fraction, t, (q, qd)));
        state.is_some_and(|state| {
            if state.has_pole {
                self.unbounded_at.get_or_insert(t);
            }
            state.write(row);
            true
        })
    }

    /// Adds a state between rows, if its columns are defined.
    fn between(&mut self, mechanism: &dyn Mechanism, state: &[f64]) {
        self.widen(&state[1..=self.layout.n]);
        let mut state = state.to_vec();
        if self.extremes.is_some() {
            self.constraints.evaluate(mechanism, state[0], &state[1..=self.layout.n]);
            if let Some(fraction) = self.singularity.fraction(&self.constraints.constraint_jacobian) {
                self.replace(mechanism, fraction, &mut state);
            }
        }
        let StateRef { t, q, qd, qdd, multipliers } = state_in(self.layout, &state);
        self.is_conservative &= mechanism.power(t, q, qd, qdd, multipliers) == 0.0;
        if self.extremes.is_none() {
            return;
        }
        mechanism.outputs(t, q, qd, qdd, multipliers, &mut self.outputs);
        if self.outputs.iter().all(|value| value.is_finite()) {
            write_row(t, [q, qd, qdd], multipliers, &self.outputs, [0.0; CHECKS], &mut self.columns);
            self.note_extremes(&state);
        } else if SEARCHES && let Some(bounds) = &mut self.output_bounds {
            bounds.add(&state, &self.outputs);
        }
    }

    /// Adds a state whose columns and outputs were written last.
    fn note_extremes(&mut self, state: &[f64]) {
        if let Some(extremes) = &mut self.extremes {
            extremes.row(state[0], &self.columns[..self.columns.len() - CHECKS]);
        }
        if SEARCHES && let Some(bounds) = &mut self.output_bounds {
            bounds.add(state, &self.outputs);
        }
    }

    /// The extremes, and the bounds of outputs that rows may not show.
    pub(super) fn extremes(&mut self) -> Option<(&mut ExtremesTracker, Option<&mut OutputBounds>)> {
        Some((self.extremes.as_mut()?, self.output_bounds.as_mut()))
    }

    /// Extends the ranges by these coordinates.
    fn widen(&mut self, q: &[f64]) {
        for (range, q) in self.ranges.iter_mut().zip(q) {
            *range = [range[0].min(*q), range[1].max(*q)];
        }
    }

    /// The quantity of the current row that is not finite, if any.
    fn undefined(&mut self, mechanism: &dyn Mechanism, row: &[f64], energy: f64) -> Option<NonFiniteQuantity> {
        let mut output = self.outputs.iter().position(|value| !value.is_finite());
        if SEARCHES && let Some(bounds) = &mut self.output_bounds {
            output = output.or_else(|| bounds.pole_at(mechanism, row, &self.outputs));
        }
        output.map(NonFiniteQuantity::Output).or((!energy.is_finite()).then_some(NonFiniteQuantity::Energy))
    }
}
