//! `frequency_response.svg`

use qrm_view::figure::{Abscissa, Curve, Figure, Panel, Scale};

use super::report::LinearReport;
use super::response::{FrequencyResponse, ResponseCurve};

/// Gain and phase of each output over the frequency.
pub(super) fn figure(report: &LinearReport, response: &FrequencyResponse) -> Figure {
    let inputs = report.inputs.len();
    let curve = |place: usize, numbers: fn(&ResponseCurve) -> &Vec<f64>, is_drawn: fn(f64) -> bool| {
        let [_, input] = response.names(report, place);
        let points = response.frequencies.iter().zip(numbers(&response.curves[place]));
        Curve {
            name: format!("by {input}"),
            doc: String::new(),
            points: points.filter(|(_, value)| is_drawn(**value)).map(|(x, y)| (*x, *y)).collect(),
            extremes: None,
            has_dots: false,
        }
    };
    let mut panels = Vec::new();
    for (row, output) in report.outputs.iter().enumerate() {
        let own = || row * inputs..(row + 1) * inputs;
        let unit = if let [input] = &report.inputs[..] { per(&output.unit, &input.unit) } else { String::new() };
        let gains = own().map(|place| curve(place, |curve| &curve.gains, |gain| gain > 0.0 && gain.is_finite()));
        let phases = own().map(|place| curve(place, |curve| &curve.phases, f64::is_finite));
        panels.push(panel(format!("gain of {}", output.name), unit, Scale::Logarithmic, gains.collect()));
        panels.push(panel(format!("phase of {}", output.name), "deg".to_owned(), Scale::Linear, phases.collect()));
    }
    Figure {
        title: format!("{}: frequency response about an equilibrium", report.scene),
        abscissa: Abscissa {
            quantity: "frequency".to_owned(),
            unit: "Hz".to_owned(),
            scale: Scale::Logarithmic,
            is_isometric: false,
            has_origin: false,
        },
        panels: panels.into_iter().filter(|panel| !panel.curves.is_empty()).collect(),
    }
}

fn panel(quantity: String, unit: String, scale: Scale, mut curves: Vec<Curve>) -> Panel {
    curves.retain(|curve| !curve.points.is_empty());
    Panel { quantity, unit, scale, curves, floor: None }
}

/// The unit of an output by an input.
fn per(output: &str, input: &str) -> String {
    let output = if output.is_empty() { "1" } else { output };
    match input {
        "" => output.to_owned(),
        input if input.contains([' ', '/']) => format!("{output}/({input})"),
        input => format!("{output}/{input}"),
    }
}
