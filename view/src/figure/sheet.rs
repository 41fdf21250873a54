//! Draws a figure, panel by panel.

use plotters::backend::SVGBackend;
use plotters::chart::{ChartBuilder, ChartContext, LabelAreaPosition};
use plotters::coord::Shift;
use plotters::coord::cartesian::Cartesian2d;
use plotters::drawing::{DrawingArea, DrawingAreaErrorKind, IntoDrawingArea};
use plotters::element::{Circle, PathElement};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{Color, TextStyle};

use super::axis::Axis;
use super::label::{self, Wish};
use super::layout::{self, HEADER, LABEL, MARGIN, RIGHT, SAMPLE, TICK, TIME_AXIS, TITLE, WIDTH};
use super::look::{self, UNITS, letters, stroke};
use super::path::{Place, simplified};
use super::{Curve, Figure, NoPicture, Panel, Scale, markup, number, span, text};

/// More points than this make a file too large.
const MOST_POINTS: usize = 10_000;

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type Chart<'a> = ChartContext<'a, SVGBackend<'a>, Cartesian2d<Axis, Axis>>;

pub(super) fn draw(figure: &Figure) -> Result<String, NoPicture> {
    let time = time_axis(figure)?;
    let height = layout::height_of(figure);
    let axes = figure.panels.iter().map(|panel| value_axis(panel, height)).collect::<Result<Vec<_>, _>>()?;
    let describe = |(panel, axis): (&Panel, &Option<Axis>)| {
        let plain = || Axis::linear(0.0, 1.0, 2).description(&panel.quantity, &panel.unit);
        let said = axis.as_ref().map_or_else(plain, |axis| axis.description(&panel.quantity, &panel.unit));
        text::cut(&text::clean(&said), HEADER, WIDTH - 2.0 * MARGIN)
    };
    let descriptions: Vec<String> = figure.panels.iter().zip(&axes).map(describe).collect();
    let (height, places) = layout::divided(figure, &descriptions);
    let labels = axes.iter().flatten().flat_map(Axis::labels);
    let left = (MARGIN + labels.map(|label| text::width(label, TICK)).fold(16.0, f64::max) + 10.0).ceil();
    let curves: usize = figure.panels.iter().map(|panel| panel.curves.len()).sum();

    let mut svg = String::new();
    let mut panels = String::new();
    {
        let size = (units(WIDTH) as u32, units(height) as u32);
        let sheet = SVGBackend::with_string(&mut svg, size).into_drawing_area();
        sheet.fill(&look::PAPER.paper).map_err(not_written)?;
        write_title(&sheet, &figure.title).map_err(not_written)?;
        for (i, (panel, place)) in figure.panels.iter().zip(&places).enumerate() {
            write_at(&sheet, &descriptions[i], &letters(look::TEXT, HEADER, false), (MARGIN, place.header), HPos::Left)
                .map_err(not_written)?;
            write_legend(&sheet, place).map_err(not_written)?;
            let is_last = i + 1 == figure.panels.len();
            let axis = axes[i].clone();
            let chart = open(&sheet, place, left, is_last, &time, axis.clone()).map_err(not_written)?;
            panels += &markup::panel(panel, &time, axis.as_ref(), corners(&chart));
            let most = MOST_POINTS / curves.max(1);
            if axis.is_some() {
                draw_curves(&sheet, &chart, panel, most).map_err(not_written)?;
            } else {
                let (from, to) = corners(&chart);
                let said = if panel.curves.iter().all(|c| c.points.is_empty()) { "no points" } else { "all zero" };
                let style = letters(look::MUTED, HEADER, false).pos(Pos::new(HPos::Center, VPos::Center));
                sheet.draw_text(said, &style, ((from.0 + to.0) / 2, (from.1 + to.1) / 2)).map_err(not_written)?;
            }
        }
        sheet.present().map_err(not_written)?;
    }
    Ok(markup::finished(&svg, figure, height, &panels))
}

fn time_axis(figure: &Figure) -> Result<Axis, NoPicture> {
    let curves = || figure.panels.iter().flat_map(|panel| &panel.curves);
    for curve in curves() {
        let marked = curve.extremes.iter().flat_map(|e| [e.minimum, e.maximum]);
        if !curve.points.iter().copied().chain(marked).all(|(t, v)| t.is_finite() && v.is_finite()) {
            return Err(NoPicture::NotFinite(curve.name.clone()));
        }
    }
    let times = span::of(curves().flat_map(|curve| curve.points.iter().map(|point| point.0)));
    let (first, last) = span::widened(times.ok_or(NoPicture::Empty)?);
    let is_finite = (last - first).is_finite();
    if is_finite { Ok(Axis::linear(first, last, 9)) } else { Err(NoPicture::TooFarApart("t".to_owned())) }
}

/// The ordinate of a panel; nothing if it has no value to show.
fn value_axis(panel: &Panel, height: f64) -> Result<Option<Axis>, NoPicture> {
    let Some((low, high)) = span::of_panel(panel) else { return Ok(None) };
    if panel.scale == Scale::Logarithmic {
        return Ok(Some(Axis::logarithmic(low, high, (height / 24.0) as usize)));
    }
    let room = if panel.curves.iter().any(|curve| curve.extremes.is_some()) { 24.0 } else { 6.0 };
    let (low, high) = span::padded(span::widened((low, high)), room, height);
    if !(high - low).is_finite() {
        return Err(NoPicture::TooFarApart(panel.quantity.clone()));
    }
    Ok(Some(Axis::linear(low, high, (height / 42.0) as usize)))
}

type Drawn<T = ()> = Result<T, DrawingAreaErrorKind<std::io::Error>>;

fn not_written(e: DrawingAreaErrorKind<std::io::Error>) -> NoPicture {
    NoPicture::NotWritten(e.to_string())
}

fn units(pixels: f64) -> i32 {
    (pixels * f64::from(UNITS)).round() as i32
}

fn write_title(sheet: &Area<'_>, title: &str) -> Drawn {
    let title = text::clean(title);
    // A long title is written smaller before it is cut.
    let room = WIDTH - 2.0 * MARGIN;
    let size = (TITLE * room / text::width(&title, TITLE).max(room)).max(12.0);
    let title = text::cut(&title, size, room);
    write_at(sheet, &title, &letters(look::TEXT, size, true), (MARGIN, 21.0), HPos::Left)
}

fn write_legend(sheet: &Area<'_>, place: &layout::Place) -> Drawn {
    for (curve, x, y, name) in &place.entries {
        let line = vec![(units(*x), units(*y)), (units(x + SAMPLE), units(*y))];
        sheet.draw(&PathElement::new(line, stroke(look::pen_of(*curve).line, 200)))?;
        write_at(sheet, name, &letters(look::TEXT, TICK, false), (x + SAMPLE + 7.0, *y), HPos::Left)?;
    }
    Ok(())
}

/// Writes around the height `y`.
fn write_at(sheet: &Area<'_>, text: &str, style: &TextStyle<'_>, (x, y): (f64, f64), side: HPos) -> Drawn {
    if text.is_empty() {
        return Ok(());
    }
    sheet.draw_text(text, &style.pos(Pos::new(side, VPos::Center)), (units(x), units(y)))
}

/// Draws the axes and the grid of a panel.
fn open<'a>(
    sheet: &Area<'a>,
    place: &layout::Place,
    left: f64,
    is_last: bool,
    time: &Axis,
    axis: Option<Axis>,
) -> Drawn<Chart<'a>> {
    let below = if is_last { TIME_AXIS } else { 0.0 };
    let size = (units(WIDTH - RIGHT), units(place.bottom + below - place.top));
    let area = sheet.clone().shrink((0, units(place.top)), size);
    let has_values = axis.is_some();
    let mut chart = ChartBuilder::on(&area)
        .set_label_area_size(LabelAreaPosition::Left, units(left))
        .set_label_area_size(LabelAreaPosition::Bottom, units(below))
        .build_cartesian_2d(time.clone(), axis.unwrap_or_else(|| Axis::linear(0.0, 1.0, 2)))?;
    let has_zero = has_values && chart.plotting_area().as_coord_spec().y_spec().has_zero_inside();
    let (from, to) = corners(&chart);
    let mut mesh = chart.configure_mesh();
    mesh.bold_line_style(stroke(look::GRID, 80))
        .light_line_style(stroke(look::LIGHT_GRID, 80))
        .axis_style(stroke(look::AXIS, 100))
        .label_style(letters(look::MUTED, TICK, false))
        .axis_desc_style(letters(look::TEXT, HEADER, false))
        .set_all_tick_mark_size(4 * UNITS);
    if is_last {
        mesh.x_desc(time.description("t", "s"));
    }
    if !has_values {
        mesh.disable_y_axis().disable_y_mesh();
    }
    mesh.draw()?;
    if has_zero {
        let zero = chart.plotting_area().map_coordinate(&(0.0, 0.0)).1;
        sheet.draw(&PathElement::new(vec![(from.0, zero), (to.0, zero)], stroke(look::ZERO, 100)))?;
    }
    // Where plotters has no room for labels it draws no axis.
    sheet.draw(&PathElement::new(vec![from, (from.0, to.1), to], stroke(look::AXIS, 100)))?;
    Ok(chart)
}

/// Where the plotting area begins, at the left above, and where it ends.
fn corners(chart: &Chart<'_>) -> (Place, Place) {
    let (x, y) = chart.plotting_area().get_pixel_range();
    ((x.start, y.start), (x.end, y.end))
}

fn draw_curves(sheet: &Area<'_>, chart: &Chart<'_>, panel: &Panel, most: usize) -> Drawn {
    let paths: Vec<Vec<Vec<Place>>> =
        panel.curves.iter().map(|curve| pieces(chart, panel.scale, curve, most)).collect();
    // The first curve is the most important one: it lies on top.
    for (i, pieces) in paths.iter().enumerate().rev() {
        for piece in pieces {
            sheet.draw(&PathElement::new(piece.clone(), stroke(look::pen_of(i).line, 180)))?;
        }
    }
    let marks = marks(chart, panel);
    for (i, place, _, _) in &marks {
        sheet.draw(&Circle::new(*place, 4 * UNITS as u32, look::PAPER.paper.filled()))?;
        sheet.draw(&Circle::new(*place, (2.8 * f64::from(UNITS)) as u32, look::pen_of(*i).line.paper.filled()))?;
    }
    let wide = |text: &str| units(text::width(text, LABEL));
    let wishes: Vec<Wish> = marks.iter().map(|(_, place, text, is_above)| (*place, wide(text), *is_above)).collect();
    let lines: Vec<Vec<Place>> = paths.into_iter().flatten().collect();
    for (mark, label) in marks.iter().zip(label::placed(&wishes, 15 * UNITS, &lines, corners(chart))) {
        let ink = look::pen_of(mark.0).ink;
        if let Some(end) = label.leader() {
            sheet.draw(&PathElement::new(vec![mark.1, end], stroke(ink, 60)))?;
        }
        let middle = label.top + 15 * UNITS / 2;
        sheet.draw_text(
            &mark.2,
            &letters(ink, LABEL, false).pos(Pos::new(HPos::Left, VPos::Center)),
            (label.left, middle),
        )?;
    }
    Ok(())
}

/// The unbroken pieces of a curve.
fn pieces(chart: &Chart<'_>, scale: Scale, curve: &Curve, most: usize) -> Vec<Vec<Place>> {
    let mut points = curve.points.clone();
    // Between its points a curve reaches its extremes.
    for extreme in curve.extremes.iter().flat_map(|e| [e.minimum, e.maximum]) {
        let at = points.partition_point(|point| point.0 < extreme.0);
        if 0 < at && at < points.len() && points[at].0 > extreme.0 {
            points.insert(at, extreme);
        }
    }
    let shown = points.chunk_by(|a, b| span::is_shown(scale, a.1) == span::is_shown(scale, b.1));
    let drawn = shown.filter(|piece| span::is_shown(scale, piece[0].1)).map(|piece| {
        let places: Vec<Place> = piece.iter().map(|point| chart.backend_coord(point)).collect();
        let share = most * piece.len() / curve.points.len().max(1);
        let mut path = simplified(&places, share);
        if path.len() == 1 {
            // The round ends of a line without length make a dot.
            path.push(path[0]);
        }
        path
    });
    drawn.collect()
}

/// The extremes to mark: curve, place, label, and whether the label belongs above.
fn marks(chart: &Chart<'_>, panel: &Panel) -> Vec<(usize, Place, String, bool)> {
    let times = chart.x_range();
    let decimals = 4 - number::magnitude(times.end - times.start);
    let values = chart.y_range();
    let mut marks = Vec::new();
    for (i, curve) in panel.curves.iter().enumerate() {
        let Some(extremes) = curve.extremes else { continue };
        let is_constant = extremes.minimum.1 == extremes.maximum.1;
        let names = if is_constant { ["", "constant"] } else { ["min", "max"] };
        for (name, (t, v), is_above) in [(names[1], extremes.maximum, true), (names[0], extremes.minimum, false)] {
            if name.is_empty() || !span::is_shown(panel.scale, v) {
                continue;
            }
            let value = number::significant(v, digits(v, values.end - values.start));
            let text = if is_constant {
                format!("{name} {value}")
            } else {
                format!("{name} {value} at {} s", time(t, decimals))
            };
            marks.push((i, chart.backend_coord(&(t, v)), text, is_above));
        }
    }
    marks
}

/// Five, or more if a thousandth of the range could not be told otherwise.
fn digits(value: f64, range: f64) -> usize {
    let needed = if value == 0.0 { 5 } else { number::magnitude(value.abs()) - number::magnitude(range) + 4 };
    needed.clamp(5, 17) as usize
}

/// A time with so many decimals, or as many digits if these are too many to write out.
fn time(t: f64, decimals: i32) -> String {
    if t == 0.0 || !(-2..=7).contains(&decimals) {
        let digits = if t == 0.0 { 1 } else { number::magnitude(t.abs()) + decimals + 1 };
        return number::significant(t, digits.clamp(1, 17) as usize);
    }
    format!("{:.*}", decimals.max(0) as usize, t).replace('-', "−")
}
