//! The results of a motion without derivatives.

use std::io;

use qrm_core::Mechanism;

use super::SensitivityRequest;
use super::error::SensitivityError;
use super::result::{Derivatives, OutputValues, Sensitivity};
use crate::run::{Extremes, ExtremesTracker, Integral, Observer, Request, Row, Status, simulate};

/// The values whose derivatives are not asked for, by the steps of the kernel.
///
/// # Errors
/// The motion does not come to its end, or is interrupted.
pub(super) fn values(mechanism: &dyn Mechanism, request: &SensitivityRequest) -> Result<Sensitivity, SensitivityError> {
    let mut columns = Columns { keep_running: request.keep_running, ..Columns::default() };
    let run = Request { settings: request.settings, step: request.step, end: request.end, ..Request::default() };
    let outcome = simulate(mechanism, &run, &mut columns).map_err(SensitivityError::Start)?;
    let t = outcome.end_time;
    match outcome.status {
        Status::Completed | Status::Stopped => {}
        Status::StopNotReached { .. } => return Err(SensitivityError::EventNotReached { end_time: t }),
        Status::StopUndecided { between: [t, _] } => return Err(SensitivityError::GrazingEvent { t }),
        Status::Failed(error) => return Err(SensitivityError::Step { t, error }),
        Status::NotFinite { t, .. } => return Err(SensitivityError::NotSmooth { t }),
        // The columns take every row.
        Status::Interrupted | Status::Unwritable(_) => return Err(SensitivityError::Interrupted { t }),
    }
    let value = |value: f64| Derivatives { value, ..Derivatives::default() };
    columns.extremes.finish();
    columns.extremes.note_estimates();
    let outputs = columns.outputs.iter().zip(&columns.integrals).zip(columns.extremes.found());
    let output = |((end, integral), extremes): ((&f64, &Integral<f64>), &Extremes)| {
        let pair = |(found, t): (f64, f64)| [value(found), value(t)];
        OutputValues {
            end: value(*end),
            minimum: pair(extremes.minimum),
            maximum: pair(extremes.maximum),
            integral: value(integral.finish()),
        }
    };
    Ok(Sensitivity {
        end_time: value(t),
        q: outcome.q.into_iter().map(value).collect(),
        qd: outcome.qd.into_iter().map(value).collect(),
        outputs: outputs.map(output).collect(),
    })
}

/// The columns of the outputs.
#[derive(Default)]
struct Columns<'a> {
    keep_running: Option<&'a dyn Fn(f64, f64) -> bool>,
    extremes: ExtremesTracker,
    integrals: Vec<Integral<f64>>,
    /// The last row.
    outputs: Vec<f64>,
}

impl Observer for Columns<'_> {
    fn row(&mut self, row: &Row) -> io::Result<()> {
        self.integrals.resize_with(row.outputs.len(), Integral::default);
        self.integrals.iter_mut().zip(row.outputs).for_each(|(integral, value)| integral.row(row.t, *value));
        self.extremes.row(row.t, row.outputs);
        self.outputs.clear();
        self.outputs.extend_from_slice(row.outputs);
        Ok(())
    }

    fn keep_running(&mut self, t: f64, end_time: f64) -> io::Result<bool> {
        Ok(self.keep_running.is_none_or(|keep_running| keep_running(t, end_time)))
    }
}
