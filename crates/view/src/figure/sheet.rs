//! Draws a figure, panel by panel.

use plotters::backend::SVGBackend;
use plotters::chart::{ChartBuilder, LabelAreaPosition};
use plotters::drawing::{DrawingAreaErrorKind, IntoDrawingArea};
use plotters::element::{Circle, PathElement, Rectangle};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{Color, TextStyle};

use super::axis::Axis;
use super::chart::{Chart, Drawn, Sheet, corners, units};
use super::layout::{self, HEADER, MARGIN, RIGHT, SAMPLE, TICK, TIME_AXIS, TITLE, WIDTH};
use super::look::{self, UNITS, letters, pen_of, stroke};
use super::trace::Trace;
use super::{Abscissa, Figure, NoPicture, Panel, marks, markup, span, text};

/// The approximate room to the left of the plotting area.
const LEFT: f64 = 70.0;

/// The whole figure as SVG.
pub(super) fn draw(figure: &Figure) -> Result<String, NoPicture> {
    let mut time = span::time_axis(figure)?;
    let height = layout::height_of(figure);
    let mut axes = figure.panels.iter().map(|panel| span::value_axis(panel, height)).collect::<Result<Vec<_>, _>>()?;
    if let (true, [Some(values)]) = (figure.abscissa.is_isometric, &mut axes[..]) {
        span::equalize([&mut time, values], [WIDTH - RIGHT - LEFT, height], figure.abscissa.has_origin);
    }
    let descriptions: Vec<String> = figure.panels.iter().zip(&axes).map(|(p, a)| description(p, a.as_ref())).collect();
    let (height, places) = layout::divided(figure, &descriptions);
    let labels = axes.iter().flatten().flat_map(Axis::labels);
    let left = (MARGIN + labels.map(|label| text::width(label, TICK)).fold(16.0, f64::max) + 10.0).ceil();
    let curves = figure.panels.iter().map(|panel| panel.curves.len()).sum();

    let (mut svg, mut numbers) = (String::new(), String::new());
    let mut drawn = || {
        let sheet = SVGBackend::with_string(&mut svg, (units(WIDTH) as u32, units(height) as u32)).into_drawing_area();
        sheet.fill(&look::PAPER.paper)?;
        write_title(&sheet, &figure.title)?;
        for (i, (panel, place)) in figure.panels.iter().zip(&places).enumerate() {
            let header = letters(look::TEXT, HEADER, false);
            write(&sheet, &descriptions[i], &header, (MARGIN, place.header))?;
            let axis = axes[i].as_ref();
            let below = (i + 1 == figure.panels.len()).then_some(&figure.abscissa);
            let chart = open(&sheet, place, left, below, (&time, axis))?;
            numbers += &markup::panel(panel, &time, axis, corners(&chart));
            draw_panel(&sheet, &chart, panel, place, curves)?;
        }
        sheet.present()
    };
    drawn().map_err(|e: DrawingAreaErrorKind<_>| NoPicture::NotWritten(e.to_string()))?;
    Ok(markup::finished(&svg, figure, height, &numbers))
}

/// The title of the ordinate of a panel.
fn description(panel: &Panel, axis: Option<&Axis>) -> String {
    let plain = || Axis::linear(0.0, 1.0, 2).description(&panel.quantity, &panel.unit);
    let said = axis.map_or_else(plain, |axis| axis.description(&panel.quantity, &panel.unit));
    text::cut(&text::clean(&said), HEADER, WIDTH - 2.0 * MARGIN)
}

fn write_title(sheet: &Sheet<'_>, title: &str) -> Drawn {
    let title = text::clean(title);
    // A long title is first reduced in size, then truncated.
    let room = WIDTH - 2.0 * MARGIN;
    let size = (TITLE * room / text::width(&title, TITLE).max(room)).max(12.0);
    write(sheet, &text::cut(&title, size, room), &letters(look::TEXT, size, true), (MARGIN, 21.0))
}

/// Writes text to the right of `x`, vertically centred at `y`.
fn write(sheet: &Sheet<'_>, text: &str, style: &TextStyle<'_>, (x, y): (f64, f64)) -> Drawn {
    if text.is_empty() {
        return Ok(());
    }
    sheet.draw_text(text, &style.pos(Pos::new(HPos::Left, VPos::Center)), (units(x), units(y)))
}

/// Draws the axes and the grid of a panel; the abscissa is described below the last panel only.
fn open<'a>(
    sheet: &Sheet<'a>,
    place: &layout::Place,
    left: f64,
    abscissa: Option<&Abscissa>,
    (time, axis): (&Axis, Option<&Axis>),
) -> Drawn<Chart<'a>> {
    let below = if abscissa.is_some() { TIME_AXIS } else { 0.0 };
    let size = (units(WIDTH - RIGHT), units(place.bottom + below - place.top));
    let area = sheet.clone().shrink((0, units(place.top)), size);
    let mut chart = ChartBuilder::on(&area)
        .set_label_area_size(LabelAreaPosition::Left, units(left))
        .set_label_area_size(LabelAreaPosition::Bottom, units(below))
        .build_cartesian_2d(time.clone(), axis.cloned().unwrap_or_else(|| Axis::linear(0.0, 1.0, 2)))?;
    let mut mesh = chart.configure_mesh();
    mesh.bold_line_style(stroke(look::GRID, 80))
        .light_line_style(stroke(look::LIGHT_GRID, 80))
        .axis_style(stroke(look::AXIS, 100))
        .label_style(letters(look::MUTED, TICK, false))
        .axis_desc_style(letters(look::TEXT, HEADER, false))
        .set_all_tick_mark_size(4 * UNITS);
    if let Some(Abscissa { quantity, unit, .. }) = abscissa {
        mesh.x_desc(text::clean(&time.description(quantity, unit)));
    }
    if axis.is_none() {
        mesh.disable_y_axis().disable_y_mesh();
    }
    mesh.draw()?;
    let (from, to) = corners(&chart);
    if axis.is_some_and(Axis::has_zero_inside) {
        let zero = chart.backend_coord(&(0.0, 0.0)).1;
        sheet.draw(&PathElement::new(vec![(from.0, zero), (to.0, zero)], stroke(look::ZERO, 100)))?;
    }
    // Plotters draws no axis if there is no room for labels.
    sheet.draw(&PathElement::new(vec![from, (from.0, to.1), to], stroke(look::AXIS, 100)))?;
    Ok(chart)
}

/// Shades the area below the floor of a panel.
fn draw_floor(sheet: &Sheet<'_>, chart: &Chart<'_>, panel: &Panel) -> Drawn {
    let Some((value, why)) = panel.floor.as_ref().filter(|(value, _)| span::is_shown(panel.scale, *value)) else {
        return Ok(());
    };
    let (from, to) = corners(chart);
    let top = chart.backend_coord(&(chart.x_range().start, *value)).1;
    sheet.draw(&Rectangle::new([(from.0, top), to], look::GRID.paper.filled()))?;
    // Text that does not fit below the edge is written above it.
    let fits = to.1 - top >= units(TICK + 6.0);
    let (side, y) = if fits { (VPos::Top, top + units(4.0)) } else { (VPos::Bottom, top - units(4.0)) };
    let style = letters(look::MUTED, TICK, false).pos(Pos::new(HPos::Right, side));
    sheet.draw_text(&text::clean(why), &style, (to.0 - units(6.0), y))
}

/// Draws the curves of a panel, their legend and their extremes. All panels together have `curves` curves.
fn draw_panel(sheet: &Sheet<'_>, chart: &Chart<'_>, panel: &Panel, place: &layout::Place, curves: usize) -> Drawn {
    draw_floor(sheet, chart, panel)?;
    let traces: Vec<Trace> = panel.curves.iter().map(|curve| Trace::new(chart, panel.scale, curve, curves)).collect();
    for (curve, x, y, name) in &place.entries {
        let line = vec![(units(*x), units(*y)), (units(x + SAMPLE), units(*y))];
        sheet.draw(&PathElement::new(line, stroke(pen_of(*curve).line, traces[*curve].width())))?;
        write(sheet, name, &letters(look::TEXT, TICK, false), (x + SAMPLE + 7.0, *y))?;
    }
    if traces.iter().all(|trace| trace.pieces.is_empty()) {
        let (from, to) = corners(chart);
        let said = if panel.curves.iter().all(|curve| curve.points.is_empty()) { "no points" } else { "all zero" };
        let style = letters(look::MUTED, HEADER, false).pos(Pos::new(HPos::Center, VPos::Center));
        return sheet.draw_text(said, &style, ((from.0 + to.0) / 2, (from.1 + to.1) / 2));
    }
    // The first curve is the most important one, and is drawn on top.
    for (i, trace) in traces.iter().enumerate().rev() {
        for piece in &trace.pieces {
            sheet.draw(&PathElement::new(piece.clone(), stroke(pen_of(i).line, trace.width())))?;
        }
    }
    for (i, curve) in panel.curves.iter().enumerate().rev().filter(|(_, curve)| curve.has_dots) {
        for point in curve.points.iter().filter(|point| span::is_shown(panel.scale, point.1)) {
            let dot = Circle::new(chart.backend_coord(point), units(3.4), pen_of(i).line.paper.filled());
            sheet.draw(&dot)?;
        }
    }
    marks::draw(sheet, chart, panel, &traces)
}
