//! Some designs of a sweep, compared with runs of their own.

use std::fmt;

use qrm_sim::batch::{DesignResult, LaneCount};
use qrm_sim::integrate::MethodSettings;

use super::designs::Designs;
use crate::error::Error;
use crate::format::counted;

/// The number of designs that are compared.
const DESIGNS: usize = 8;
/// The part of the tolerance of a sweep with which a design runs by itself.
const FINER: f64 = 1e-2;
/// A design may differ by so many of its estimated errors, and by rounding errors.
const ALLOWED: f64 = 10.0;
const ROUNDING: f64 = 1e-11;

/// Designs that agree with runs of their own.
pub(super) struct Agreement {
    designs: usize,
    /// The largest difference of a coordinate, or of the end's time multiplied by the largest rate.
    largest: f64,
}

/// A design that differs from a run of its own.
pub(super) struct Difference {
    design: usize,
    difference: f64,
    estimated: f64,
}

/// Runs some designs once more, in lanes as the sweep did, and by themselves at a finer tolerance.
///
/// The coordinates at the end must agree within the estimated errors, and so must its time. Without estimates, and with fixed steps, nothing is
/// compared: designs with those run by themselves already.
pub(super) fn compare(designs: &Designs, (begin, end): (usize, usize)) -> Result<Agreement, Difference> {
    let settings = designs.setup.settings;
    let mut agreement = Agreement { designs: 0, largest: 0.0 };
    if !designs.estimate_error || !settings.method.is_adaptive() {
        return Ok(agreement);
    }
    let count = DESIGNS.min(end - begin);
    let numbers: Vec<usize> = (0..count).map(|k| begin + (2 * k + 1) * (end - begin) / (2 * count)).collect();
    let finer = MethodSettings { tolerance: FINER * settings.tolerance, ..settings };
    let of_sweep = designs.results(&numbers, settings, designs.lanes);
    let alone = designs.results(&numbers, finer, LaneCount::One);
    for ((design, own), exact) in numbers.into_iter().zip(of_sweep).zip(alone) {
        let (Ok(own), Ok(exact)) = (own.result, exact.result) else { continue };
        if !is_trusted(&own) || !is_trusted(&exact) {
            continue;
        }
        let Some(estimated) = own.estimated_error else { continue };
        let pairs = || own.q.iter().zip(&exact.q);
        let largest = |numbers: &[f64]| numbers.iter().map(|number| number.abs()).fold(0.0, f64::max);
        // A condition may fix the coordinates at the end, and leave the time open.
        let by_time = (own.end_time - exact.end_time).abs() * largest(&exact.qd);
        let difference = pairs().map(|(own, exact)| (own - exact).abs()).fold(by_time, f64::max);
        let size = largest(&exact.q).max(1.0);
        if difference > ALLOWED * estimated + ROUNDING * size {
            return Err(Difference { design, difference, estimated });
        }
        agreement.designs += 1;
        agreement.largest = agreement.largest.max(difference);
    }
    Ok(agreement)
}

fn is_trusted(result: &DesignResult) -> bool {
    result.status.as_ref().is_ok_and(|status| status.is_done()) && result.doubts.is_empty()
}

impl fmt::Display for Agreement {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let Self { designs, largest } = self;
        if *designs == 0 {
            return Ok(());
        }
        let designs = counted(*designs as u64, "design");
        write!(f, "\nself-check: {designs} within {largest:.1e} of runs of their own at a finer tolerance")
    }
}

impl Difference {
    pub(super) fn error(self) -> Error {
        let Self { design, difference, estimated } = self;
        Error::run(format!(
            "design {design} differs by {difference:.1e} from a run of its own, and {estimated:.1e} was estimated"
        ))
        .help("do not trust the table; a smaller `--tolerance` or `--lanes one` may help")
    }
}
