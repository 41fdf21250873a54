//! The data for judging a motion in progress, collected from its rows.

use qrm_core::{Mechanism, RowRequest};

use super::companion::{Companion, RowBlock};
use super::error_estimate::ErrorEstimates;
use super::judgement::{Evidence, RejectionReason};
use super::monitor::RunMonitor;
use super::sampler::Sampler;
use crate::integrate::{Integrator, MethodSettings, StepError};
use crate::state::State;

/// The data for judging a motion in progress; a run of the same rows has the same data.
///
/// A change of parameters begins a new part of the motion. Ranges continue; errors are estimated, and energy and work
/// compared, within each part, and summed.
#[derive(Clone, Debug)]
pub(crate) struct RunHealth {
    monitor: RunMonitor,
    sampler: Option<Sampler>,
    companion: Option<Companion>,
    /// The data of the completed parts of the motion.
    before: Before,
}

/// The data of the completed parts of a motion.
#[derive(Clone, Debug)]
struct Before {
    imbalance: f64,
    is_conservative: bool,
    corrections: Vec<f64>,
    residual: f64,
    steps: u64,
    rows: u64,
}

impl RunHealth {
    /// Begins at a state.
    ///
    /// # Errors
    /// The energy is not finite there.
    pub(crate) fn new(mechanism: &dyn Mechanism, settings: &MethodSettings, first: &State) -> Result<Self, StepError> {
        let mut watch = Self {
            monitor: RunMonitor::new(mechanism, first, [false; 2]),
            sampler: Sampler::new(mechanism, settings, first, f64::INFINITY),
            companion: Companion::new(mechanism, settings, (first, None), f64::INFINITY, false),
            before: Before {
                imbalance: 0.0,
                is_conservative: true,
                corrections: vec![0.0; first.q.len()],
                residual: 0.0,
                steps: 0,
                rows: 0,
            },
        };
        watch.take(mechanism, first)?;
        Ok(watch)
    }

    /// Adds a block of rows. Its first row, with the number `request.first`, was added before.
    ///
    /// # Errors
    /// The energy of a row is not finite.
    pub(crate) fn follow(
        &mut self,
        mechanism: &dyn Mechanism,
        integrator: &mut Integrator,
        request: &RowRequest,
        rows: &mut [f64],
    ) -> Result<(), StepError> {
        if let Some(sampler) = &mut self.sampler {
            sampler.follow(mechanism, rows, self.before.rows + request.first, integrator.solver_mut());
        }
        let new = &mut rows[self.monitor.width()..];
        let taken = self.monitor.take(mechanism, new, integrator.inner_rows(), &mut ());
        if let Some(companion) = &mut self.companion {
            let block = RowBlock { rows: new, first: request.first + 1, steps: integrator.steps(), extremes: &[] };
            companion.follow(mechanism, request, block);
        }
        taken.map_err(|_| StepError::NotFinite)
    }

    /// Begins a new part of the motion with other parameters, at the state `first`; the last part ended at `end` after
    /// `rows` rows.
    ///
    /// # Errors
    /// The energy is not finite there.
    pub(crate) fn change(
        &mut self,
        [old, new]: [&dyn Mechanism; 2],
        integrator: &Integrator,
        rows: u64,
        [end, first]: [&State; 2],
    ) -> Result<(), StepError> {
        self.take(old, end)?;
        if let Some(companion) = &mut self.companion {
            companion.change([old, new], [end, first]);
        }
        let (imbalance, steps) = (self.imbalance(integrator), integrator.counts(rows).accepted);
        let before = &mut self.before;
        before.imbalance = imbalance;
        before.is_conservative &= self.monitor.is_conservative;
        before.corrections = larger(&before.corrections, integrator.corrections());
        before.residual = before.residual.max(integrator.stats().residual_before_correction);
        before.steps += steps;
        before.rows += rows;
        self.sampler = Sampler::new(new, &integrator.settings, first, f64::INFINITY);
        self.monitor.change(new, first);
        self.take(new, first)
    }

    /// The reasons not to trust the motion so far, after `rows` rows of its last part.
    pub(crate) fn rejection_reasons(
        &self,
        mechanism: &dyn Mechanism,
        integrator: &Integrator,
        rows: u64,
    ) -> Vec<RejectionReason> {
        let (before, monitor) = (&self.before, &self.monitor);
        let steps = before.steps + integrator.counts(rows).accepted;
        let corrections = larger(&before.corrections, integrator.corrections());
        let companion = self.companion.as_ref();
        let errors = companion.and_then(|companion| companion.errors(steps));
        let evidence = Evidence {
            energy_imbalance: self.imbalance(integrator),
            is_conservative: before.is_conservative && monitor.is_conservative,
            largest_kinetic_energy: monitor.largest_kinetic_energy,
            largest_energy: monitor.largest_energy,
            ranges: &monitor.ranges,
            tolerance: integrator.settings.tolerance(),
            steps,
            estimated_errors: errors.as_ref().map(ErrorEstimates::coordinates),
            companion_failed: companion.is_some_and(Companion::failed),
            corrections: &corrections,
            residual: before.residual.max(integrator.stats().residual_before_correction),
            unbounded_at: monitor.unbounded_at,
        };
        evidence.rejection_reasons(mechanism.description())
    }

    /// The largest difference between energy and work, summed over all parts.
    fn imbalance(&self, integrator: &Integrator) -> f64 {
        let is_conservative = self.monitor.is_conservative && integrator.is_conservative();
        let of_rows = self.monitor.balance.largest_known_excess();
        self.before.imbalance + self.monitor.imbalance(integrator.imbalance(), of_rows, is_conservative)
    }

    /// Adds a state as a row.
    fn take(&mut self, mechanism: &dyn Mechanism, state: &State) -> Result<(), StepError> {
        let mut row = vec![0.0; self.monitor.width()];
        state.write(&mut row);
        self.monitor.take(mechanism, &mut row, &[], &mut ()).map_err(|_| StepError::NotFinite)
    }
}

fn larger(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a.max(*b)).collect()
}
