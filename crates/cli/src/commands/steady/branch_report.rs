//! A branch in words and numbers.

use qrm_sim::analysis::{BranchEnd, MotionStability, NoSteadyMotion, PointKind};
use serde::Serialize;

use super::branch::Point;
use super::branch_table::BranchTable;
use super::failure;
use super::report::{MultiplierEntry, stability_name, start_errors};
use crate::format::{counted, heading, number, with_error};
use crate::output::Named;

/// A branch, in the order of `branch.json`.
#[derive(Serialize)]
pub(super) struct BranchReport {
    #[serde(skip)]
    heading: String,
    scene: &'static str,
    parameter: String,
    unit: &'static str,
    from: f64,
    to: f64,
    points: usize,
    /// Why the branch ends, and at which value of the parameter.
    end: &'static str,
    end_value: f64,
    #[serde(skip)]
    end_text: String,
    special: Vec<SpecialPoint>,
    /// The parts of the branch between folds and changes of stability, in their order.
    parts: Vec<Part>,
}

/// A point at which something happens.
#[derive(Serialize)]
struct SpecialPoint {
    kind: &'static str,
    value: f64,
    error: f64,
    period: f64,
    period_error: f64,
    start: Named<f64>,
    start_errors: Named<f64>,
    multipliers: Vec<MultiplierEntry>,
}

/// A part of the branch.
#[derive(Serialize)]
struct Part {
    stability: &'static str,
    from: f64,
    to: f64,
}

/// The name of a kind of points in files.
pub(super) fn kind_name(kind: PointKind) -> &'static str {
    match kind {
        PointKind::Regular => "",
        PointKind::Fold => "fold",
        PointKind::PeriodDoubling => "period_doubling",
        PointKind::Torus => "torus",
        PointKind::BranchPoint => "branch_point",
    }
}

impl BranchReport {
    pub(super) fn new(table: &BranchTable, end: &BranchEnd, cycles: u32) -> Self {
        let BranchTable { setup, vary, points, .. } = table;
        let description = setup.description;
        let last = points.last().map_or(vary.range[0], |point| point.at.parameter);
        let (reason, why) = match end {
            BranchEnd::Reached if last == vary.range[1] => ("reached", String::new()),
            BranchEnd::Reached => {
                ("turned_back", ": it turned back, and has come to the other end of the range".into())
            }
            BranchEnd::MostPoints => ("most_points", ": it has as many points as --points allows".into()),
            BranchEnd::Lost(NoSteadyMotion::Interrupted { .. }) => ("interrupted", ": interrupted".into()),
            BranchEnd::Lost(reason) => {
                ("lost", format!(": {}", failure::error(setup, cycles, reason.clone()).message()))
            }
        };
        let special = |point: &&Point| {
            let motion = &point.at.motion;
            SpecialPoint {
                kind: kind_name(point.at.kind),
                value: point.at.parameter,
                error: point.at.parameter_error,
                period: motion.period,
                period_error: motion.period_error,
                start: Named(motion.start.given_values(description)),
                start_errors: Named(start_errors(motion).given_values(description)),
                multipliers: motion.multipliers.iter().map(MultiplierEntry::from).collect(),
            }
        };
        Self {
            heading: heading(description),
            scene: description.name,
            parameter: vary.name.clone(),
            unit: table.unit(),
            from: vary.range[0],
            to: vary.range[1],
            points: points.len(),
            end: reason,
            end_value: last,
            end_text: format!("at {} = {}{why}", vary.name, number(last)),
            special: points.iter().filter(|point| point.at.kind != PointKind::Regular).map(|p| special(&p)).collect(),
            parts: parts(points),
        }
    }

    /// The text that the command prints.
    pub(super) fn text(&self) -> String {
        let mut text = format!("{}\n\n", self.heading);
        let range = [self.from, self.to].map(number);
        let name = &self.parameter;
        let mut lines = vec![(
            "branch",
            format!("{name} from {} to {}: {}", range[0], range[1], counted(self.points as u64, "point")),
        )];
        lines.push(("end", self.end_text.clone()));
        for special in &self.special {
            let start: Vec<String> =
                special.start.0.iter().map(|(name, value)| format!("{name} = {}", number(*value))).collect();
            lines.push((
                special.kind,
                format!("{name} = {}, {}", with_error(special.value, special.error), start.join(", ")),
            ));
        }
        for part in &self.parts {
            let [from, to] = [part.from, part.to].map(number);
            lines.push((part.stability, format!("{name} from {from} to {to}")));
        }
        for (topic, what) in lines {
            text += &format!("  {:15} {what}\n", topic.replace('_', " "));
        }
        text
    }
}

/// The parts of a branch between folds and changes of stability.
fn parts(points: &[Point]) -> Vec<Part> {
    let mut parts: Vec<(MotionStability, Part)> = Vec::new();
    let mut has_turned = false;
    for point in points.iter().map(|point| &point.at) {
        let stability = point.motion.stability;
        match parts.last_mut() {
            // At a special point the largest multiplier is one.
            Some((last, part)) if !has_turned && *last == stability || point.kind != PointKind::Regular => {
                part.to = point.parameter;
            }
            _ => {
                let from = parts.last().map_or(point.parameter, |(_, part)| part.to);
                parts.push((stability, Part { stability: stability_name(stability), from, to: point.parameter }));
            }
        }
        has_turned = point.kind == PointKind::Fold || has_turned && point.kind != PointKind::Regular;
    }
    parts.into_iter().map(|(_, part)| part).collect()
}
