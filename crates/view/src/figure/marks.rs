//! Marks the extremes of curves.

use plotters::element::{Circle, PathElement};
use plotters::style::Color;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::chart::{Chart, Drawn, Sheet, corners, units};
use super::label::{self, LabelRequest};
use super::layout::LABEL;
use super::look::{self, letters, pen_of, stroke};
use super::path::Place;
use super::trace::Trace;
use super::{Panel, number, span, text};

/// An extreme of a curve.
struct Mark {
    curve: usize,
    place: Place,
    label: String,
    is_maximum: bool,
}

/// Marks the requested extremes, with labels that avoid the lines.
pub(super) fn draw(sheet: &Sheet<'_>, chart: &Chart<'_>, panel: &Panel, traces: &[Trace]) -> Drawn {
    let marks = marks(chart, panel);
    for mark in &marks {
        sheet.draw(&Circle::new(mark.place, units(4.0), look::PAPER.paper.filled()))?;
        sheet.draw(&Circle::new(mark.place, units(2.8), pen_of(mark.curve).line.paper.filled()))?;
    }
    let wide = |text: &str| units(text::width(text, LABEL));
    let requests: Vec<LabelRequest> =
        marks.iter().map(|mark| (mark.place, wide(&mark.label), mark.is_maximum)).collect();
    let lines: Vec<&[Place]> = traces.iter().flat_map(|trace| &trace.pieces).map(Vec::as_slice).collect();
    for (mark, label) in marks.iter().zip(label::place_labels(&requests, units(15.0), &lines, corners(chart))) {
        let ink = pen_of(mark.curve).ink;
        if let Some(end) = label.leader() {
            sheet.draw(&PathElement::new(vec![mark.place, end], stroke(ink, 60)))?;
        }
        let style = letters(ink, LABEL, false).pos(Pos::new(HPos::Center, VPos::Center));
        sheet.draw_text(&mark.label, &style, label.middle())?;
    }
    Ok(())
}

fn marks(chart: &Chart<'_>, panel: &Panel) -> Vec<Mark> {
    let (times, values) = (chart.x_range(), chart.y_range());
    // A time is shown to a ten-thousandth of the run.
    let decimals = 4 - number::magnitude(times.end - times.start);
    let mut marks = Vec::new();
    for (curve, extremes) in panel.curves.iter().enumerate().filter_map(|(i, curve)| Some((i, curve.extremes?))) {
        let is_constant = extremes.minimum.1 == extremes.maximum.1;
        for (is_maximum, (t, v)) in [(true, extremes.maximum), (false, extremes.minimum)] {
            if !span::is_shown(panel.scale, v) || is_constant && !is_maximum {
                continue;
            }
            let value = number::significant(v, digits(v, values.end - values.start));
            let label = match is_maximum {
                _ if is_constant => format!("constant {value}"),
                true => format!("max {value} at {} s", time(t, decimals)),
                false => format!("min {value} at {} s", time(t, decimals)),
            };
            marks.push(Mark { curve, place: chart.backend_coord(&(t, v)), label, is_maximum });
        }
    }
    marks
}

/// Five digits, or more if a thousandth of the range needs them.
fn digits(value: f64, range: f64) -> usize {
    let needed = if value == 0.0 { 5 } else { number::magnitude(value.abs()) - number::magnitude(range) + 4 };
    needed.clamp(5, 17) as usize
}

/// A time with `decimals` decimals, or with as many digits if these are too many.
fn time(t: f64, decimals: i32) -> String {
    if (-2..=7).contains(&decimals) && t != 0.0 {
        return number::rounded(t, decimals.max(0) as usize);
    }
    let digits = if t == 0.0 { 1 } else { number::magnitude(t.abs()) + decimals + 1 };
    number::significant(t, digits.clamp(1, 17) as usize)
}
