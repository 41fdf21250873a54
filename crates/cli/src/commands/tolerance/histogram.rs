//! Histograms of samples.

use qrm_view::figure::{Abscissa, Curve, Figure, Panel, Scale};

use super::quantity::Quantity;

/// The number of standard deviations on each side of the mean, and of bins in each.
const REACH: i32 = 4;
const BINS: i32 = 5;

/// A histogram of each quantity in units of its standard deviation, with the normal distribution.
pub(super) fn figure(scene: &str, quantities: &[Quantity], values: &[Vec<f64>]) -> Figure {
    let panels = quantities.iter().zip(values).filter(|(quantity, _)| quantity.statistics.deviation > 0.0);
    Figure {
        title: format!("{scene}: quantities within tolerances"),
        abscissa: Abscissa {
            quantity: "difference from the mean, in standard deviations".to_owned(),
            unit: String::new(),
            scale: Scale::Linear,
            is_isometric: false,
            has_origin: false,
        },
        panels: panels.map(|(quantity, values)| panel(quantity, values)).collect(),
    }
}

fn panel(quantity: &Quantity, values: &[f64]) -> Panel {
    let statistics = &quantity.statistics;
    let mut counts = vec![0_u32; (2 * REACH * BINS) as usize];
    for value in values.iter().filter(|value| value.is_finite()) {
        let place = ((value - statistics.mean) / statistics.deviation + f64::from(REACH)) * f64::from(BINS);
        if place >= 0.0
            && let Some(count) = counts.get_mut(place as usize)
        {
            *count += 1;
        }
    }
    let edge = |i: usize| i as f64 / f64::from(BINS) - f64::from(REACH);
    let density = |count: u32| f64::from(count) * f64::from(BINS) / statistics.count as f64;
    // Bars drawn as a step curve.
    let bars = counts.iter().enumerate().flat_map(|(i, count)| [edge(i), edge(i + 1)].map(|x| (x, density(*count))));
    let normal = |x: f64| (-0.5 * x * x).exp() / std::f64::consts::TAU.sqrt();
    let bell = (0..=8 * REACH * BINS).map(|i| f64::from(i) / f64::from(4 * BINS) - f64::from(REACH));
    let curve = |name: &str, doc: String, points: Vec<(f64, f64)>| Curve {
        name: name.to_owned(),
        doc,
        points,
        extremes: None,
        has_dots: false,
    };
    let unit = if quantity.unit.is_empty() { String::new() } else { format!(" {}", quantity.unit) };
    let doc = format!("mean {:.6}{unit}, standard deviation {:.2e}{unit}", statistics.mean, statistics.deviation);
    Panel {
        quantity: "density".to_owned(),
        unit: String::new(),
        scale: Scale::Linear,
        curves: vec![
            curve(&quantity.name, doc, bars.collect()),
            curve("normal", "distribution".to_owned(), bell.map(|x| (x, normal(x))).collect()),
        ],
        floor: None,
    }
}
