//! The motion without tolerances.

use qrm_pictures::Recording;
use qrm_sim::columns::Kind;
use qrm_sim::run::{ErrorEstimates, Extremes, Outcome};

use crate::commands::sweep::Field;
use crate::error::Error;
use crate::progress::Progress;
use crate::run_report::RunReport;
use crate::setup::Setup;

/// A quantity of the motion without tolerances.
#[derive(Clone, Copy, Debug)]
pub(super) struct Nominal {
    pub(super) value: f64,
    /// The estimated error of the value.
    pub(super) error: Option<f64>,
    /// The largest absolute value of its column in the motion.
    pub(super) size: f64,
}

/// Runs the scene like `qrm run`, with error estimates.
///
/// # Errors
/// The motion does not reach its end, or its results cannot be trusted.
pub(super) fn run(setup: &Setup, fields: &[Field]) -> Result<Vec<Nominal>, Error> {
    let mut observer = (Progress::new(), Recording::for_extremes(setup.description));
    let outcome = setup.simulate(true, &mut observer)?;
    let (_, recording) = observer;
    if let Some(problem) = RunReport::new(setup, &outcome, &recording).problem() {
        return Err(problem);
    }
    Ok(fields.iter().map(|field| nominal(*field, &outcome, &recording)).collect())
}

fn nominal(field: Field, outcome: &Outcome, recording: &Recording) -> Nominal {
    let errors = outcome.errors.as_ref();
    let range = |kind: Kind| recording.extremes(kind);
    let size = |range: &Extremes| range.minimum.0.abs().max(range.maximum.0.abs());
    let at_end = |kind: Kind, value: f64| Nominal {
        value,
        error: errors.and_then(|errors| errors.column(kind)).map(|error| error.at_end),
        size: range(kind).map_or(value.abs(), |range| size(&range)),
    };
    let extreme = |i: usize, end: usize| {
        let kind = Kind::Output(i);
        let Some(range) = range(kind) else { return Nominal { value: f64::NAN, error: None, size: f64::NAN } };
        let error = errors.and_then(|errors| errors.extremes(kind, &range)).map(|errors| errors[end]);
        Nominal { value: [range.minimum.0, range.maximum.0][end], error, size: size(&range) }
    };
    match field {
        Field::Minimum(i) => extreme(i, 0),
        Field::Maximum(i) => extreme(i, 1),
        Field::Coordinate(i) => at_end(Kind::Coordinate(i), outcome.q[i]),
        Field::Rate(i) => at_end(Kind::Rate(i), outcome.qd[i]),
        _ => Nominal {
            value: outcome.end_time,
            error: errors.and_then(ErrorEstimates::end_time),
            size: outcome.end_time.abs(),
        },
    }
}
