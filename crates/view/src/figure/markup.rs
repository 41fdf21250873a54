//! The parts of the SVG that plotters does not write: the root element, the style sheet, a text description for screen
//! readers, and the numbers for reading the figure back.

use plotters::coord::ranged1d::Ranged;

use super::axis::Axis;
use super::layout::WIDTH;
use super::look::{UNITS, hex, pen_of, style_sheet};
use super::path::Place;
use super::text::escaped;
use super::{Figure, Panel, Scale};

/// The data attributes of a panel.
pub(super) fn panel(panel: &Panel, time: &Axis, axis: Option<&Axis>, (from, to): (Place, Place)) -> String {
    let (times, scale) = (time.range(), if panel.scale == Scale::Linear { "linear" } else { "logarithmic" });
    let values = axis.map(Axis::range).unwrap_or(0.0..1.0);
    let mut svg = format!(
        "<g class=\"panel\" data-left=\"{}\" data-right=\"{}\" data-top=\"{}\" data-bottom=\"{}\" data-t0=\"{:e}\" \
         data-t1=\"{:e}\" data-low=\"{:e}\" data-high=\"{:e}\" data-scale=\"{scale}\">",
        from.0, to.0, from.1, to.1, times.start, times.end, values.start, values.end
    );
    for (i, curve) in panel.curves.iter().enumerate() {
        let pen = pen_of(i);
        svg += &format!(
            "<g class=\"curve\" data-name=\"{}\" data-stroke=\"{}\" data-ink=\"{}\"",
            escaped(&curve.name),
            hex(pen.line.paper),
            hex(pen.ink.paper)
        );
        if let Some(e) = curve.extremes {
            svg += &format!(" data-minimum=\"{:e} {:e}\"", e.minimum.0, e.minimum.1);
            svg += &format!(" data-maximum=\"{:e} {:e}\"", e.maximum.0, e.maximum.1);
        }
        svg += "/>";
    }
    svg + "</g>\n"
}

/// The complete SVG: the drawing by plotters and all other parts.
pub(super) fn finished(drawn: &str, figure: &Figure, height: f64, panels: &str) -> String {
    let inside = drawn.split_once('>').map_or("", |(_, inside)| inside);
    // Quotes are escaped in text, so these patterns occur only in and around tags.
    let surplus = [("opacity=\"1\" ", ""), (" \"/>", "\"/>"), ("\">\n", "\">"), ("\n</text>", "</text>")];
    let inside = surplus.iter().fold(inside.to_owned(), |svg, (long, short)| svg.replace(long, short));
    let scale = f64::from(UNITS);
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"qrm\" role=\"img\" width=\"{WIDTH}\" height=\"{height}\" \
         viewBox=\"0 0 {} {}\">\n<style>{}</style>\n<title>{}</title>\n<desc>{}</desc>\n{panels}{inside}",
        WIDTH * scale,
        (height * scale).round(),
        style_sheet(),
        escaped(&figure.title),
        escaped(&description(figure)),
    )
}

/// Describes the figure in words, panel by panel.
fn description(figure: &Figure) -> String {
    let abscissa = match figure.abscissa.quantity.as_str() {
        "t" => "time",
        quantity => quantity,
    };
    let of_panel = |panel: &Panel| {
        let unit = if panel.unit.is_empty() { String::new() } else { format!(" in {}", panel.unit) };
        let name = |curve: &super::Curve| match curve.doc.as_str() {
            "" => curve.name.clone(),
            doc => format!("{} ({doc})", curve.name),
        };
        let names: Vec<String> = panel.curves.iter().map(name).collect();
        format!("{}{unit} over {abscissa}: {}.", panel.quantity, names.join(", "))
    };
    figure.panels.iter().map(of_panel).collect::<Vec<_>>().join(" ")
}
