//! The work-precision diagram.

use qrm_view::figure::{Abscissa, Curve, Figure, Panel, Scale};

use super::study::Study;
use crate::setup::Setup;

impl Study {
    /// Error against run time, a line for each method.
    pub(crate) fn figure(&self, setup: &Setup) -> Figure {
        let floor = self.reference.uncertainty.judged();
        let mut curves: Vec<Curve> = Vec::new();
        for sample in &self.samples {
            let Ok(measured) = &sample.result else { continue };
            // Errors below the floor are unknown: a line ends where it reaches the floor.
            let point = (measured.seconds[1], measured.errors.judged().max(floor));
            match curves.last_mut().filter(|curve| curve.name == sample.method) {
                Some(curve) if curve.points.iter().any(|point| point.1 <= floor) => {}
                Some(curve) => curve.points.push(point),
                None => curves.push(Curve {
                    name: sample.method.clone(),
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
        let units: Vec<&str> = setup.scene.coordinates.iter().map(|c| c.unit.as_str()).collect();
        let first = units.first().copied().unwrap_or_default();
        let unit = if units.iter().all(|unit| *unit == first) { first } else { "rad, m" }.to_owned();
        let floor = Some((floor, "unknown below: the reference is uncertain by this".to_owned()));
        let (quantity, unit) = match &self.of {
            None => ("largest error of a coordinate".to_owned(), unit),
            Some(column) => (format!("largest error of {}", column.name), column.unit.clone()),
        };
        Figure {
            title: format!("{}: error against run time", setup.description.name),
            abscissa: Abscissa {
                quantity: "run time".to_owned(),
                unit: "s".to_owned(),
                scale: Scale::Logarithmic,
                is_isometric: false,
                has_origin: false,
            },
            panels: vec![Panel { quantity, unit, scale: Scale::Logarithmic, curves, floor }],
        }
    }
}
