//! `stability.svg`

use qrm_sim::analysis::Spectrum;
use qrm_view::figure::{Abscissa, Curve, Figure, Panel, Scale};

use super::limit::Limit;
use super::survey::Survey;
use crate::setup::Setup;

/// Rates, steps, condition numbers and singular values along the motion.
pub(super) fn figure(setup: &Setup, survey: &Survey, limit: &Limit) -> Figure {
    let series = |name: &str, doc: &str, number: fn(&Spectrum) -> f64| {
        let points = survey.samples.iter().map(|sample| (sample.t, number(&sample.spectrum)));
        curve(name, doc, points.filter(|(_, value)| value.is_finite() && *value > 0.0).collect())
    };
    let ends = || [survey.samples[0].t, survey.samples[survey.samples.len() - 1].t];
    let level = |name: &str, doc: &str, value: f64| curve(name, doc, ends().map(|t| (t, value)).to_vec());
    let mut steps = vec![series("RK4", "longest stable step", |s| s.longest_step), level("step", "used", setup.step())];
    steps.extend(limit.found.map(|(holds, _)| level("trial", "longest step that held", holds)));
    let panels = [
        (
            "fastest reaction",
            "1/s",
            vec![
                series("rate", "decay", |s| s.rate),
                series("frequency", "oscillation, rad/s", |s| s.frequency),
                series("growth", "", |s| s.growth),
            ],
        ),
        ("step", "s", steps),
        (
            "condition number",
            "",
            vec![series("Mbar", "", |s| s.condition_mass), series("loops", "C_q Mbar^-1 C_q'", |s| s.condition_loops)],
        ),
        ("singular value", "", vec![series("C_q", "smallest", |s| s.smallest_singular_value)]),
    ];
    let panel = |(quantity, unit, curves): (&str, &str, Vec<Curve>)| {
        let curves: Vec<Curve> = curves.into_iter().filter(|curve| !curve.points.is_empty()).collect();
        (!curves.is_empty()).then(|| Panel {
            quantity: quantity.to_owned(),
            unit: unit.to_owned(),
            scale: Scale::Logarithmic,
            curves,
            floor: None,
        })
    };
    Figure {
        title: format!("{}: stability along the motion", setup.description.name),
        abscissa: Abscissa::time(),
        panels: panels.into_iter().filter_map(panel).collect(),
    }
}

fn curve(name: &str, doc: &str, points: Vec<(f64, f64)>) -> Curve {
    Curve { name: name.to_owned(), doc: doc.to_owned(), points, extremes: None, has_dots: false }
}
