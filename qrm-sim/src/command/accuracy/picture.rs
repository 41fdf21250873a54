//! The work-precision diagram.

use qrm_view::figure::{Abscissa, Curve, Figure, Panel, Scale};

use super::super::reference::Reference;
use super::super::setup::Setup;
use super::ladder::Rung;

/// Error against run time, a line for each method.
pub(super) fn figure(setup: &Setup, rungs: &[Rung], reference: &Reference) -> Figure {
    let floor = reference.uncertainty.position;
    let mut curves: Vec<Curve> = Vec::new();
    for rung in rungs {
        let Ok(measured) = &rung.result else { continue };
        // What is below the floor is not known: a line ends where it gets there.
        let point = (measured.seconds[1], measured.errors.position.max(floor));
        let is_drawn = |curve: &Curve| curve.name == rung.method && curve.points.iter().any(|point| point.1 <= floor);
        if curves.last().is_some_and(is_drawn) {
            continue;
        }
        match curves.last_mut().filter(|curve| curve.name == rung.method) {
            Some(curve) => curve.points.push(point),
            None => curves.push(Curve {
                name: rung.method.to_owned(),
                doc: String::new(),
                points: vec![point],
                extremes: None,
                has_dots: true,
            }),
        }
    }
    for curve in &mut curves {
        curve.points.sort_by(|a, b| a.0.total_cmp(&b.0));
    }
    let units: Vec<&str> = setup.text.coordinates.iter().map(|c| c.unit.as_str()).collect();
    let is_same = units.iter().all(|unit| *unit == units[0]);
    let unit = if is_same { units[0].to_owned() } else { "rad, m".to_owned() };
    let floor = Some((floor, "not to be told: the reference is uncertain by this".to_owned()));
    let quantity = "largest error of a coordinate".to_owned();
    Figure {
        title: format!("{}: error against run time", setup.description.name),
        abscissa: Abscissa { quantity: "run time".to_owned(), unit: "s".to_owned(), scale: Scale::Logarithmic },
        panels: vec![Panel { quantity, unit, scale: Scale::Logarithmic, curves, floor }],
    }
}
