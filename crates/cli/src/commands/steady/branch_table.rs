//! A branch as a table and a figure.

use qrm_sim::analysis::PointKind;
use qrm_view::figure::{Abscissa, Curve, Figure, Panel, Scale};

use super::branch::{Point, Vary};
use super::branch_report::kind_name;
use super::columns::ColumnEntry;
use super::report::{stability_name, start_errors};
use crate::error::Error;
use crate::format::{full, number};
use crate::options::unit_of_parameter;
use crate::output::csv;
use crate::setup::Setup;

/// The most special points that a figure marks.
const MOST_MARKED: usize = 4;

/// The name of a curve, and its value at a point; `None` where it is not known.
type Named<'a> = (&'a str, &'a dyn Fn(&Point) -> Option<f64>);

/// The points of a branch.
pub(super) struct BranchTable<'a> {
    pub(super) setup: &'a Setup,
    pub(super) vary: &'a Vary,
    pub(super) points: &'a [Point],
    /// The coordinate that tells cycles.
    pub(super) phase: Option<usize>,
}

impl BranchTable<'_> {
    pub(super) fn unit(&self) -> &'static str {
        unit_of_parameter(self.setup.description, &self.vary.name)
    }

    /// `branch.csv`; values that are not known are left empty.
    pub(super) fn csv(&self) -> Result<Vec<u8>, Error> {
        let description = self.setup.description;
        let mut header: Vec<String> = vec!["kind".to_owned()];
        let with_errors = |name: &str| [name.to_owned(), format!("{name}_error")];
        header.extend(with_errors(&self.vary.name));
        header.extend(with_errors("period"));
        if let Some(first) = self.points.first() {
            header.extend(
                first
                    .at
                    .motion
                    .start
                    .given_values(description)
                    .iter()
                    .flat_map(|(name, _)| with_errors(&format!("start_{name}"))),
            );
        }
        header.extend(["stability", "multiplier_re", "multiplier_im", "multiplier_error"].map(str::to_owned));
        header
            .extend(description.coordinates.iter().flat_map(|c| ["min", "max"].map(|end| format!("{}_{end}", c.name))));
        for (name, column) in self.columns() {
            header.extend(["mean", "min", "max"].iter().flat_map(|part| with_errors(&format!("{name}_{part}"))));
            header.extend(column.work.map(|_| with_errors(&format!("{name}_work"))).into_iter().flatten());
            header
                .extend(column.fluctuation.map(|_| with_errors(&format!("{name}_fluctuation"))).into_iter().flatten());
        }
        csv(header, self.points.iter().map(|point| self.record(point)))
    }

    /// The rates and outputs of the first point that has them.
    fn columns(&self) -> &[(String, ColumnEntry)] {
        let all = self.points.iter().map(|point| &point.columns.0.0);
        all.into_iter().find(|columns| !columns.is_empty()).map_or(&[], |columns| columns)
    }

    fn record(&self, point: &Point) -> Vec<String> {
        let description = self.setup.description;
        let motion = &point.at.motion;
        let known = |value: f64| if value.is_finite() { full(value) } else { String::new() };
        let mut record = vec![kind_name(point.at.kind).to_owned()];
        record.extend([point.at.parameter, point.at.parameter_error, motion.period, motion.period_error].map(known));
        for ((_, value), (_, error)) in
            motion.start.given_values(description).iter().zip(start_errors(motion).given_values(description))
        {
            record.extend([*value, error].map(known));
        }
        record.push(stability_name(motion.stability).to_owned());
        let largest = motion.multipliers.first();
        record.extend(
            largest.map_or([String::new(), String::new(), String::new()], |m| {
                [m.value.re, m.value.im, m.error].map(known)
            }),
        );
        record.extend(point.ranges.iter().flatten().map(|value| known(*value)));
        for (name, column) in self.columns() {
            let own = point.columns.0.get(name);
            let nan = f64::NAN;
            let value = |f: &dyn Fn(&ColumnEntry) -> [Option<f64>; 2]| {
                own.map_or([nan; 2], |column| f(column).map(|value| value.unwrap_or(nan)))
            };
            let mut pairs = vec![
                value(&|c| [Some(c.mean), Some(c.mean_error)]),
                value(&|c| [Some(c.min), c.min_error]),
                value(&|c| [Some(c.max), c.max_error]),
            ];
            pairs.extend(column.work.map(|_| value(&|c| [c.work, c.work_error])));
            pairs.extend(column.fluctuation.map(|_| value(&|c| [c.fluctuation, c.fluctuation_error])));
            record.extend(pairs.into_iter().flatten().map(known));
        }
        record
    }

    /// The range of the coordinate and its rate, and the largest multiplier, over the parameter.
    pub(super) fn figure(&self) -> Figure {
        let description = self.setup.description;
        let given = self.points.first().map(|point| &point.at.motion.start.given);
        let first = given.and_then(|given| given.iter().position(|given| *given));
        let mut panels = Vec::new();
        if let Some(i) = self.phase.or(first) {
            let coordinate = &description.coordinates[i];
            let turns = self.points.iter().any(|point| point.at.motion.turns[i] != 0.0);
            if !turns {
                let [low, high] = [0, 1].map(|end| move |point: &Point| Some(point.ranges[i][end]));
                panels.push(self.panel(coordinate.name, coordinate.unit, &[("largest", &high), ("smallest", &low)]));
            }
            let name = format!("{}_dot", coordinate.name);
            let high = |point: &Point| point.columns.0.get(&name).map(|column| column.max);
            let low = |point: &Point| point.columns.0.get(&name).map(|column| column.min);
            let mean = |point: &Point| point.columns.0.get(&name).map(|column| column.mean);
            let unit = self.columns().iter().find(|(other, _)| *other == name).map_or("", |(_, own)| own.unit.as_str());
            let curves: [Named; 3] = [("largest", &high), ("smallest", &low), ("mean", &mean)];
            panels.push(self.panel(&name, unit, if turns { &curves } else { &curves[..2] }));
        }
        let size = |point: &Point| point.at.motion.multipliers.first().map(|m| m.value.norm());
        panels.push(self.panel("largest multiplier", "", &[("size", &size)]));
        Figure {
            title: format!("{}: steady motion over {}", description.name, self.vary.name),
            abscissa: Abscissa {
                quantity: self.vary.name.clone(),
                unit: self.unit().to_owned(),
                scale: Scale::Linear,
                is_isometric: false,
                has_origin: false,
            },
            panels: panels.into_iter().filter(|panel| !panel.curves.is_empty()).collect(),
        }
    }

    /// A panel of some curves, with the first special points as dots on the first of them.
    fn panel(&self, quantity: &str, unit: &str, curves: &[Named]) -> Panel {
        let pair = |point: &Point, value: &dyn Fn(&Point) -> Option<f64>| {
            value(point).filter(|value| value.is_finite()).map(|value| (point.at.parameter, value))
        };
        let curve = |name: String, points: Vec<(f64, f64)>, has_dots: bool| Curve {
            name,
            doc: String::new(),
            points,
            extremes: None,
            has_dots,
        };
        let all_points = |value| self.points.iter().filter_map(|point| pair(point, value)).collect();
        let mut all: Vec<Curve> =
            curves.iter().map(|(name, value)| curve((*name).to_owned(), all_points(*value), false)).collect();
        if let Some((_, value)) = curves.first() {
            let special = self.points.iter().filter(|point| point.at.kind != PointKind::Regular);
            all.extend(special.take(MOST_MARKED).map(|point| {
                let kind = kind_name(point.at.kind).replace('_', " ");
                let name = format!("{kind} at {}", number(point.at.parameter));
                curve(name, pair(point, *value).into_iter().collect(), true)
            }));
        }
        Panel {
            quantity: quantity.to_owned(),
            unit: unit.to_owned(),
            scale: Scale::Linear,
            curves: all.into_iter().filter(|curve| !curve.points.is_empty()).collect(),
            floor: None,
        }
    }
}
