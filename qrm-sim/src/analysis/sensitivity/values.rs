//! The results of a motion without derivatives.

use std::io;

use qrm_core::Mechanism;

use super::SensitivityRequest;
use super::error::SensitivityError;
use super::result::{Derivatives, OutputValues, Sensitivity};
use crate::bounds::{Resolution, Unresolved};
use crate::integrate::quintic;
use crate::run::{Extremes, ExtremesTracker, Integral, Observer, Request, Row, Status, simulate};
use crate::solve::Solver;
use crate::state::State;

/// The largest difference between the values of one extreme, in parts of the output's range.
const SAME: f64 = 1e-6;

/// The number of rows that are looked at together.
const ROWS: usize = 8;

/// The values whose derivatives are not asked for, by the steps of the kernel.
///
/// # Errors
/// The motion does not come to its end, or is interrupted.
pub(super) fn values(mechanism: &dyn Mechanism, request: &SensitivityRequest) -> Result<Sensitivity, SensitivityError> {
    let mut columns = Columns {
        mechanism,
        wants_extremes: request.outputs.is_none_or(|outputs| !outputs.is_empty()),
        keep_running: request.keep_running,
        located: ExtremesTracker::default(),
        extremes: Vec::new(),
        integrals: Vec::new(),
        outputs: Vec::new(),
        resolution: Resolution::new(mechanism, request.outputs, 1.0),
        solver: Solver::new(mechanism),
        before: None,
        waiting: Vec::new(),
        unresolved: None,
    };
    let run = Request { settings: request.settings, step: request.step, end: request.end, ..Request::default() };
    let outcome = simulate(mechanism, &run, &mut columns).map_err(SensitivityError::Start)?;
    let t = outcome.end_time;
    if let Some(unresolved) = columns.unresolved {
        return Err(unresolved.into());
    }
    columns.add_waiting()?;
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
    let description = mechanism.description();
    let first = 1 + 3 * description.coordinates.len() + description.constraints.len();
    columns.located.finish();
    columns.located.note_estimates();
    let located = columns.located.found();
    let extremes = columns.extremes.get(first..).unwrap_or(located);
    let outputs = columns.outputs.iter().zip(&columns.integrals).zip(extremes.iter().zip(located));
    let output = |((end, integral), (extremes, located)): ((&f64, &Integral<f64>), (&Extremes, &Extremes))| {
        let range = extremes.maximum.0 - extremes.minimum.0;
        // Both name the same extreme where their values agree.
        let pair = |(found, t): (f64, f64), other: (f64, f64)| {
            [value(found), value(if (found - other.0).abs() <= SAME * range { other.1 } else { t })]
        };
        OutputValues {
            end: value(*end),
            minimum: pair(extremes.minimum, located.minimum),
            maximum: pair(extremes.maximum, located.maximum),
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
struct Columns<'a> {
    mechanism: &'a dyn Mechanism,
    /// Whether extremes are asked for.
    wants_extremes: bool,
    keep_running: Option<&'a dyn Fn(f64, f64) -> bool>,
    /// The extremes of outputs by polynomials through rows, whose times are smooth functions of parameters.
    located: ExtremesTracker,
    /// The extremes of all columns.
    extremes: Vec<Extremes>,
    integrals: Vec<Integral<f64>>,
    /// The last row.
    outputs: Vec<f64>,
    resolution: Resolution,
    /// Completes states between rows.
    solver: Solver,
    before: Option<State>,
    /// The last rows, and their outputs.
    waiting: Vec<(State, Vec<f64>)>,
    /// The output that changed too fast.
    unresolved: Option<Unresolved>,
}

impl Columns<'_> {
    /// Adds the rows that wait, and others between them where outputs change fast.
    fn add_waiting(&mut self) -> Result<(), Unresolved> {
        let rows = std::mem::take(&mut self.waiting);
        let mut times = self.resolution.times(self.mechanism, &rows)?.into_iter().peekable();
        for (at, outputs) in rows {
            let mut values = outputs.clone();
            while let Some(t) = times.next_if(|t| *t < at.t) {
                let Some(before) = &self.before else { break };
                let mut between = quintic(before, &at, t);
                if self.solver.complete(self.mechanism, &mut between).is_ok() {
                    let State { q, qd, qdd, multipliers, .. } = &between;
                    self.mechanism.outputs(t, q, qd, qdd, multipliers, &mut values);
                    self.add(t, &values);
                }
            }
            self.add(at.t, &outputs);
            self.before = Some(at);
        }
        Ok(())
    }

    fn add(&mut self, t: f64, outputs: &[f64]) {
        self.integrals.resize_with(outputs.len(), Integral::default);
        self.integrals.iter_mut().zip(outputs).for_each(|(integral, value)| integral.row(t, *value));
        self.located.row(t, outputs);
    }
}

impl Observer for Columns<'_> {
    fn row(&mut self, row: &Row) -> io::Result<()> {
        if self.resolution.is_needed() {
            let [q, qd, qdd, multipliers] = [row.q, row.qd, row.qdd, row.multipliers].map(<[f64]>::to_vec);
            let state = State { t: row.t, q, qd, qdd, multipliers, corrections: 0 };
            self.waiting.push((state, row.outputs.to_vec()));
            if self.waiting.len() == ROWS && self.unresolved.is_none() {
                self.unresolved = self.add_waiting().err();
            }
        } else {
            self.add(row.t, row.outputs);
        }
        self.outputs.clear();
        self.outputs.extend_from_slice(row.outputs);
        Ok(())
    }

    fn wants_extremes(&self) -> bool {
        self.wants_extremes
    }

    fn extremes(&mut self, extremes: &[Extremes]) {
        self.extremes = extremes.to_vec();
    }

    fn keep_running(&mut self, t: f64, end_time: f64) -> io::Result<bool> {
        Ok(self.unresolved.is_none() && self.keep_running.is_none_or(|keep_running| keep_running(t, end_time)))
    }
}
