//! A design of a sweep: its request, its result, and its separate run.

use std::io;
use std::ops::Range;

use qrm_core::{Description, Mechanism};

use crate::columns::{Kind, columns};
use crate::integrate::{DOP853, MethodSettings, StepBounds};
use crate::run::{
    End, ErrorEstimates, Extremes, NearestSingularity, Observer, Redundancy, RejectionReason, Request, Row, StartError,
    Status, simulate,
};

/// The settings of every design of a sweep.
pub struct SweepRequest<'a> {
    /// The method. Lanes support `dop853`, and `auto` while nothing is stiff; with other methods designs run one by
    /// one.
    pub settings: MethodSettings,
    /// The bounds of the chosen steps of each design, by number; those of the settings if `None`.
    pub step_bounds: Option<&'a (dyn Fn(usize) -> StepBounds + Sync)>,
    /// Length of the steps, or of the rows if the method chooses its steps; the scene's if `None`.
    pub step: Option<f64>,
    /// The end; the scene's if `None`.
    pub end: Option<End<'a>>,
    /// Whether the extremes of outputs are recorded; otherwise outputs are not computed.
    pub extremes: bool,
    /// Whether a companion motion estimates the error.
    pub estimate_error: bool,
}

impl Default for SweepRequest<'_> {
    /// Uses `dop853` to the end of the scene, with extremes and error estimates.
    fn default() -> Self {
        let settings = MethodSettings { method: DOP853, ..MethodSettings::default() };
        Self { settings, step_bounds: None, step: None, end: None, extremes: true, estimate_error: true }
    }
}

impl SweepRequest<'_> {
    /// The bounds of the steps of a design.
    pub(super) fn bounds_of(&self, design: usize) -> StepBounds {
        self.step_bounds.map_or(self.settings.step_bounds, |of| of(design))
    }
}

/// The result of a design.
#[derive(Debug)]
pub struct DesignResult {
    /// The reason why it ended, or could not begin.
    pub status: Result<Status, StartError>,
    /// The number of steps.
    pub steps: u64,
    /// Time of the end.
    pub end_time: f64,
    /// The estimated error of the time at which a condition ended the motion.
    pub end_time_error: Option<f64>,
    /// Coordinates at the end.
    pub q: Vec<f64>,
    /// Rates at the end.
    pub qd: Vec<f64>,
    /// Smallest and largest value of each output during the motion, if recorded.
    pub extremes: Vec<[f64; 2]>,
    /// The estimated errors of the smallest and of the largest value of each output; empty without estimates.
    pub extreme_errors: Vec<[f64; 2]>,
    /// Estimated largest error of a coordinate: in lanes over the end and two earlier times, in a separate run over all
    /// rows. At the end, an error of the time counts too.
    pub estimated_error: Option<f64>,
    /// The reasons not to trust these numbers.
    pub rejection_reasons: Vec<RejectionReason>,
    /// The position of a separate run that was nearest to a singular one.
    pub nearest_singular: Option<NearestSingularity>,
    /// The redundancy of the constraints in a separate run.
    pub redundancy: Option<Redundancy>,
    /// Whether the design ran separately: there were no lanes, or its lane needed a closer look.
    pub is_alone: bool,
}

/// Runs a design separately.
pub(super) fn run_alone(design: usize, mechanism: &dyn Mechanism, request: &SweepRequest) -> DesignResult {
    let mut ranges = Ranges::new(mechanism.description(), request.extremes);
    let request = Request {
        settings: MethodSettings { step_bounds: request.bounds_of(design), ..request.settings },
        step: request.step,
        end: request.end,
        estimate_error: request.estimate_error,
        is_single_threaded: true,
        ..Request::default()
    };
    match simulate(mechanism, &request, &mut ranges) {
        Err(reason) => DesignResult::not_started(reason),
        Ok(outcome) => DesignResult {
            rejection_reasons: if outcome.status.is_done() {
                outcome.rejection_reasons(mechanism.description())
            } else {
                Vec::new()
            },
            estimated_error: outcome
                .errors
                .as_ref()
                .map(|errors| with_end_time(errors.coordinates(), &outcome.qd, errors.end_time().unwrap_or(0.0))),
            end_time_error: outcome.errors.as_ref().and_then(ErrorEstimates::end_time),
            nearest_singular: outcome.nearest_singular,
            redundancy: outcome.redundancy,
            status: Ok(outcome.status),
            steps: outcome.counts.accepted,
            end_time: outcome.end_time,
            q: outcome.q,
            qd: outcome.qd,
            extreme_errors: match &outcome.errors {
                Some(errors) => ranges.errors(errors),
                None => Vec::new(),
            },
            extremes: ranges.values(),
            is_alone: true,
        },
    }
}

/// The largest error of a coordinate at the end, which an error of the time increases.
pub(super) fn with_end_time(errors: &[f64], rates: &[f64], end_time_error: f64) -> f64 {
    errors.iter().zip(rates).map(|(error, rate)| error + rate.abs() * end_time_error).fold(0.0, f64::max)
}

/// The smallest and the largest value of each output, including those between rows.
struct Ranges {
    is_wanted: bool,
    /// The range of the outputs in the columns.
    places: Range<usize>,
    found: Vec<Extremes>,
}

impl Ranges {
    fn new(description: &Description, is_wanted: bool) -> Self {
        let begin = columns(description).iter().position(|column| matches!(column.kind, Kind::Output(_))).unwrap_or(0);
        let places = begin..begin + description.outputs.len();
        Self { is_wanted, places, found: Vec::new() }
    }

    fn values(&self) -> Vec<[f64; 2]> {
        self.found.iter().map(|found| [found.minimum.0, found.maximum.0]).collect()
    }

    /// The errors of the extremes of each output.
    fn errors(&self, errors: &ErrorEstimates) -> Vec<[f64; 2]> {
        let error = |(i, found): (usize, &Extremes)| errors.extremes(Kind::Output(i), found).unwrap_or_default();
        self.found.iter().enumerate().map(error).collect()
    }
}

impl Observer for Ranges {
    fn row(&mut self, _: &Row) -> io::Result<()> {
        Ok(())
    }

    fn needs_outputs(&self) -> bool {
        self.is_wanted
    }

    fn wants_extremes(&self) -> bool {
        self.is_wanted
    }

    fn extremes(&mut self, extremes: &[Extremes]) {
        self.found = extremes.get(self.places.clone()).unwrap_or_default().to_vec();
    }
}

impl DesignResult {
    /// The result of a design that did not begin.
    pub(super) fn not_started(reason: StartError) -> Self {
        Self {
            status: Err(reason),
            steps: 0,
            end_time: 0.0,
            end_time_error: None,
            q: Vec::new(),
            qd: Vec::new(),
            extremes: Vec::new(),
            extreme_errors: Vec::new(),
            estimated_error: None,
            rejection_reasons: Vec::new(),
            nearest_singular: None,
            redundancy: None,
            is_alone: true,
        }
    }
}
