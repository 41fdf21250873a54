//! The advance of a motion to a time that its user asks for.

use std::sync::Arc;

use qrm_core::{RowLayout, RowRequest};

use super::super::error::{Reason, SimError};
use super::{Simulation, error};
use crate::integrate::StepError;
use crate::state::State;

/// Most steps on the way to a time.
const MAX_STEPS: f64 = 1e11;
/// Times nearer to each other than this part of a step are equal.
const NEAR: f64 = 1e-9;
/// Rows of a block.
const CHUNK: u64 = 256;

impl Simulation {
    /// The state at time `t`, which is not before the last one.
    ///
    /// # Errors
    /// The motion does not get there; the state stays what it was.
    pub fn advance(&mut self, t: f64) -> Result<&State, SimError> {
        *self = self.advanced(t)?;
        Ok(&self.now)
    }

    /// The state at time `t`, which is not before the last one, as long as there is no reason to distrust the motion:
    /// see [`rejection_reasons`](Self::rejection_reasons).
    ///
    /// # Errors
    /// The motion does not get there, or its numbers cannot be trusted there; the state stays what it was.
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
        // Not a number is no time that can be reached either.
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

    /// Makes the steps to a time; where one of them fails, this is of no use any more.
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
            // Whole steps of which the last one is not beyond the time that is asked for.
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
                    &buffer[..(block.rows_written + 1) * layout.width()],
                )?;
            }
            *rows += block.rows_written as u64;
            row.read(&buffer[block.rows_written * layout.width()..]);
        }
        self.now = if row.t >= t - NEAR * step { row.clone() } else { integrator.between(&*mechanism, row, t)? };
        Ok(())
    }
}
