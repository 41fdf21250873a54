//! The advance of a motion to a requested time.

use std::sync::Arc;

use qrm_core::{RowLayout, RowRequest};

use super::super::error::{Reason, SimError};
use super::{Simulation, error};
use crate::integrate::StepError;
use crate::solve::IRREGULAR;
use crate::state::State;

/// The largest number of steps to a requested time.
const MAX_STEPS: f64 = 1e11;
/// The difference of times, relative to a step, below which they are equal.
const NEAR: f64 = 1e-9;
/// The number of rows in a block.
const CHUNK: u64 = 256;

impl Simulation {
    /// Advances to the time `t`, which must not be before the last one, and returns the state.
    ///
    /// # Errors
    /// The motion cannot be continued to that time; the state stays unchanged.
    pub fn advance(&mut self, t: f64) -> Result<&State, SimError> {
        *self = self.advanced(t)?;
        Ok(&self.now)
    }

    /// Advances to the time `t`, which must not be before the last one, and returns the state if the motion can be
    /// trusted: see [`rejection_reasons`](Self::rejection_reasons).
    ///
    /// # Errors
    /// The motion cannot be continued to that time, or cannot be trusted there; the state stays unchanged.
    pub fn advance_trusted(&mut self, t: f64) -> Result<&State, SimError> {
        let advanced = self.advanced(t)?;
        let rejection_reasons = advanced.rejection_reasons();
        if !rejection_reasons.is_empty() {
            let tolerance = self.integrator.settings.tolerance();
            return Err(error(&self.model, Reason::Doubtful { t, rejection_reasons, tolerance }));
        }
        *self = advanced;
        Ok(&self.now)
    }

    fn advanced(&self, t: f64) -> Result<Self, SimError> {
        let from = self.now.t;
        // Written so that NaN is rejected too.
        if !(t - from <= MAX_STEPS * self.step) {
            return Err(error(&self.model, Reason::NoTime { from, to: t }));
        }
        if t < from - NEAR * self.step {
            return Err(error(&self.model, Reason::Backwards { from, to: t }));
        }
        let mut advanced = self.clone();
        match advanced.advance_to(t) {
            Ok(()) => Ok(advanced),
            Err(reason) => Err(error(&self.model, Reason::Failed { t: from, error: reason })),
        }
    }

    /// Makes the steps to a time; if one of them fails, the simulation must not be used any more.
    fn advance_to(&mut self, t: f64) -> Result<(), StepError> {
        // Rows up to this time are made on the way.
        let latest = t + NEAR * self.step;
        let (origin, step) = (self.origin, self.step);
        let time = |row: u64| origin + row as f64 * step;
        let mechanism = Arc::clone(&self.mechanism);
        let Self { integrator, rows, row, .. } = self;
        let layout = RowLayout { n: row.q.len(), m: row.multipliers.len() };
        let mut buffer = Vec::new();
        while time(*rows + 1) <= latest {
            // The whole steps that do not pass the requested time.
            let mut steps = (((latest - time(*rows)) / step) as u64).clamp(1, CHUNK);
            while time(*rows + steps) > latest {
                steps -= 1;
            }
            buffer.resize((steps + 1) as usize * layout.width(), 0.0);
            row.write(&mut buffer);
            let request = RowRequest {
                origin,
                step,
                end_time: f64::INFINITY,
                first: *rows,
                residual: integrator.settings.projection_tolerance.residual,
                watches_event: false,
            };
            let block = integrator.fill(&*mechanism, &request, &mut buffer);
            block.reason?;
            if let Some(watch) = &mut self.watch {
                watch.follow(
                    &*mechanism,
                    integrator,
                    &request,
                    &mut buffer[..(block.rows_written + 1) * layout.width()],
                )?;
            }
            *rows += block.rows_written as u64;
            row.read(&buffer[block.rows_written * layout.width()..]);
        }
        self.now = if row.t >= t - NEAR * step { row.clone() } else { integrator.between(&*mechanism, row, t)? };
        integrator.solver_mut().refine(&*mechanism, IRREGULAR, &mut self.now);
        Ok(())
    }
}
