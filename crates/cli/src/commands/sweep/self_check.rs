//! A comparison of some designs of a sweep with separate runs.

use std::fmt;

use qrm_core::Description;
use qrm_sim::batch::{DesignResult, LaneCount};
use qrm_sim::integrate::MethodSettings;
use qrm_sim::run::Status;

use super::designs::Designs;
use crate::error::{Error, Message};
use crate::format::{counted, number};
use crate::progress::interrupted;

/// The number of compared designs.
const DESIGNS: usize = 8;
/// The tolerance of a separate run relative to that of the sweep, and the bounds of that tolerance.
const FINER: f64 = 1e-2;
const FINEST: f64 = 1e-14;
const COARSEST: f64 = 1e-11;
/// The largest accepted difference, in estimated errors, plus rounding errors.
const ALLOWED: f64 = 10.0;
const ROUNDING: f64 = 1e-11;

/// The accepted difference of the time of a condition: relative to the time, and as a multiple of the estimated error
/// over the largest rate.
const END_TIME: f64 = 1e-6;
const ALLOWED_OF_END_TIME: f64 = 1e3;

/// The largest accepted difference of an extreme, relative to the range of the output.
const EXTREMES: f64 = 1e-4;

/// The result of a successful comparison.
pub(crate) struct Agreement {
    /// The number of separate runs.
    tried: usize,
    /// The number of designs that could be compared.
    designs: usize,
    /// The largest difference of a coordinate.
    largest: f64,
    /// An extreme of an output that the sweep missed.
    missed: Option<MissedExtreme>,
}

/// An extreme of an output that differs from that of a separate run.
struct MissedExtreme {
    design: usize,
    column: String,
    values: [f64; 2],
    /// The difference, relative to the range of the output.
    part: f64,
}

/// A design that differs from its separate run.
pub(crate) struct Difference {
    design: usize,
    kind: DifferenceKind,
}

enum DifferenceKind {
    /// A coordinate at the end: the difference, and the estimated error.
    Coordinate(f64, f64),
    /// The times at which the condition became true: that of the sweep, and that of the design's own run, if it did.
    EndTime(f64, Option<f64>),
}

/// Repeats some designs, in lanes as in the sweep, and in separate runs with a tighter tolerance.
///
/// The coordinates at the end of the design must agree within the estimated errors, and so must the time of a condition
/// that ends it. Without estimates, and with fixed steps, nothing is compared: such designs run separately anyway.
pub(crate) fn compare(designs: &Designs, (begin, end): (usize, usize)) -> Result<Agreement, Difference> {
    let settings = designs.setup.settings;
    let mut agreement = Agreement { tried: 0, designs: 0, largest: 0.0, missed: None };
    if !designs.estimate_error || !settings.method.is_adaptive() {
        return Ok(agreement);
    }
    let count = DESIGNS.min(end - begin);
    let numbers: Vec<usize> = (0..count).map(|k| begin + (2 * k + 1) * (end - begin) / (2 * count)).collect();
    let finer = MethodSettings { tolerance: (FINER * settings.tolerance).clamp(FINEST, COARSEST), ..settings };
    let of_sweep = designs.results(&numbers, settings, designs.lanes, None);
    for (design, own) in numbers.into_iter().zip(of_sweep) {
        let Ok(own) = own.result else { continue };
        // Errors are estimated at fixed times, so both runs end at the same time instead of at an event.
        let alone = designs.results(&[design], finer, LaneCount::One, Some(own.end_time)).remove(0);
        if interrupted() {
            break;
        }
        if matches!(own.status, Ok(Status::Stopped))
            && let Ok(exact) = designs.results(&[design], finer, LaneCount::One, None).remove(0).result
        {
            compare_end_times(design, &own, &exact)?;
        }
        agreement.tried += 1;
        if let Ok(exact) = alone.result
            && let Some(difference) = difference(design, &own, &exact)?
        {
            agreement.designs += 1;
            agreement.largest = agreement.largest.max(difference);
            let of_own = if own.is_alone { &[] } else { &own.extremes[..] };
            let missed = missed_extreme(design, of_own, &exact.extremes, designs.setup.description);
            let part = |missed: &Option<MissedExtreme>| missed.as_ref().map_or(EXTREMES, |missed| missed.part);
            if part(&missed) > part(&agreement.missed) {
                agreement.missed = missed;
            }
        }
    }
    Ok(agreement)
}

/// The difference of a design from its separate run; `None` if one of them is unreliable.
fn difference(design: usize, own: &DesignResult, exact: &DesignResult) -> Result<Option<f64>, Difference> {
    let Some(estimated) = own.estimated_error.filter(|_| is_trusted(own) && is_trusted(exact)) else { return Ok(None) };
    let pairs = || own.q.iter().zip(&exact.q);
    let largest = |numbers: &[f64]| numbers.iter().map(|number| number.abs()).fold(0.0, f64::max);
    let difference = pairs().map(|(own, exact)| (own - exact).abs()).fold(0.0, f64::max);
    let size = largest(&exact.q).max(1.0);
    if !(difference <= ALLOWED * estimated + ROUNDING * size) {
        return Err(Difference { design, kind: DifferenceKind::Coordinate(difference, estimated) });
    }
    Ok(Some(difference))
}

/// Compares the time at which the condition of a design became true with that of a separate run.
fn compare_end_times(design: usize, own: &DesignResult, exact: &DesignResult) -> Result<(), Difference> {
    let Some(estimated) = own.estimated_error.filter(|_| is_trusted(own)) else { return Ok(()) };
    let reached = match &exact.status {
        Ok(Status::Stopped) if is_trusted(exact) => Some(exact.end_time),
        Ok(Status::StopNotReached { .. }) => None,
        _ => return Ok(()),
    };
    let fastest = own.qd.iter().map(|rate| rate.abs()).fold(0.0, f64::max);
    let allowed = END_TIME * own.end_time.abs() + ALLOWED_OF_END_TIME * estimated / fastest.max(f64::MIN_POSITIVE);
    if reached.is_some_and(|reached| (own.end_time - reached).abs() <= allowed) {
        return Ok(());
    }
    Err(Difference { design, kind: DifferenceKind::EndTime(own.end_time, reached) })
}

/// The extreme of a design that differs most from that of its separate run, if any differs.
fn missed_extreme(
    design: usize,
    own: &[[f64; 2]],
    exact: &[[f64; 2]],
    description: &Description,
) -> Option<MissedExtreme> {
    let extremes = own.iter().zip(exact).zip(description.outputs).flat_map(|((own, exact), output)| {
        let range = exact[1] - exact[0];
        let rounding = ROUNDING * exact[0].abs().max(exact[1].abs());
        [(0, "min"), (1, "max")].into_iter().filter_map(move |(end, suffix)| {
            let difference = (own[end] - exact[end]).abs();
            let part = difference / range;
            (part > EXTREMES && difference > rounding).then(|| MissedExtreme {
                design,
                column: format!("{}_{suffix}", output.name),
                values: [own[end], exact[end]],
                part,
            })
        })
    });
    extremes.max_by(|a, b| a.part.total_cmp(&b.part))
}

fn is_trusted(result: &DesignResult) -> bool {
    result.status.as_ref().is_ok_and(|status| status.is_done()) && result.rejection_reasons.is_empty()
}

impl Agreement {
    /// A warning about an extreme that the sweep missed.
    pub(crate) fn warning(&self) -> Option<Message> {
        let MissedExtreme { design, column, values, .. } = self.missed.as_ref()?;
        let [own, exact] = values.map(number);
        let text = format!("`{column}` of design {design} is {own}, and {exact} in a run of its own");
        Some(Message::new(text).help(
            "lanes look at outputs four times a step, and miss narrow peaks and corners: use a shorter `--max-step`, \
             or `--lanes one`",
        ))
    }
}

impl fmt::Display for Agreement {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let Self { tried, designs, largest, .. } = self;
        if *tried == 0 {
            return Ok(());
        }
        if *designs == 0 {
            let tried = counted(*tried as u64, "design");
            return write!(f, "\nself-check: left out, as none of {tried} can be relied on in a run of its own");
        }
        let designs = counted(*designs as u64, "design");
        write!(f, "\nself-check: {designs} within {largest:.1e} of runs of their own at a finer tolerance")?;
        self.warning().map_or(Ok(()), |warning| write!(f, "\n\n{}", warning.warning()))
    }
}

impl Difference {
    pub(crate) fn error(self) -> Error {
        let design = self.design;
        let text = match self.kind {
            DifferenceKind::Coordinate(difference, estimated) => format!(
                "design {design} differs by {difference:.1e} from a run of its own, and {estimated:.1e} was estimated"
            ),
            DifferenceKind::EndTime(own, reached) => {
                let own = number(own);
                let reached = reached.map_or_else(|| "never".to_owned(), |t| format!("at t = {}", number(t)));
                format!("the condition of design {design} becomes true at t = {own}, and {reached} in a run of its own")
            }
        };
        Error::run(text).help("do not trust the table; a smaller `--tolerance` or `--lanes one` may help")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn result(q: f64, end_time: f64, estimated: f64) -> DesignResult {
        DesignResult {
            status: Ok(Status::Completed),
            steps: 100,
            end_time,
            end_time_error: None,
            q: vec![q],
            qd: vec![2.0],
            extremes: Vec::new(),
            extreme_errors: Vec::new(),
            estimated_error: Some(estimated),
            rejection_reasons: Vec::new(),
            nearest_singular: None,
            redundancy: None,
            is_alone: false,
        }
    }

    #[test]
    fn a_design_that_differs_is_named() {
        let exact = result(1.0, 3.0, 1e-9);
        let of = |own: &DesignResult| difference(7, own, &exact);
        assert!(of(&result(1.0 + 5e-9, 3.0, 1e-9)).is_ok_and(|found| found.is_some_and(|d| (d - 5e-9).abs() < 1e-14)));
        assert!(of(&result(1.0 + 5e-8, 3.0, 1e-9)).is_err_and(|found| found.error().to_string().contains("design 7")));
        let failed = DesignResult { status: Ok(Status::Interrupted), ..result(9.0, 3.0, 1e-9) };
        assert!(of(&failed).is_ok_and(|found| found.is_none()), "a failed design says nothing");
    }

    #[test]
    fn a_condition_that_is_met_later_is_named() {
        let stopped = |t: f64| DesignResult { status: Ok(Status::Stopped), ..result(1.0, t, 1e-9) };
        let exact = stopped(3.0);
        assert!(compare_end_times(7, &stopped(3.0 + 1e-6), &exact).is_ok());
        let found = compare_end_times(7, &stopped(3.0 + 1e-4), &exact).map_err(Difference::error);
        assert!(found.is_err_and(|found| found.to_string().contains("becomes true at t = 3.0001")));
        let missing = Status::StopNotReached { nearest_time: 1.0, missing: 0.1 };
        let never = DesignResult { status: Ok(missing), ..result(1.0, 9.0, 1e-9) };
        let found = compare_end_times(7, &stopped(3.0), &never).map_err(Difference::error);
        assert!(found.is_err_and(|found| found.to_string().contains("never in a run of its own")));
    }
}
