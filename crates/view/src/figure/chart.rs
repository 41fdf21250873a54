//! The plotting area of a panel.

use plotters::backend::SVGBackend;
use plotters::chart::ChartContext;
use plotters::coord::Shift;
use plotters::coord::cartesian::Cartesian2d;
use plotters::drawing::{DrawingArea, DrawingAreaErrorKind};

use super::axis::Axis;
use super::look::UNITS;
use super::path::Place;

pub(super) type Sheet<'a> = DrawingArea<SVGBackend<'a>, Shift>;
pub(super) type Chart<'a> = ChartContext<'a, SVGBackend<'a>, Cartesian2d<Axis, Axis>>;
pub(super) type Drawn<T = ()> = Result<T, DrawingAreaErrorKind<std::io::Error>>;

/// Converts pixels to drawing units.
pub(super) fn units(pixels: f64) -> i32 {
    (pixels * f64::from(UNITS)).round() as i32
}

/// The upper left and lower right corners of the plotting area.
pub(super) fn corners(chart: &Chart<'_>) -> (Place, Place) {
    let (times, values) = (chart.x_range(), chart.y_range());
    (chart.backend_coord(&(times.start, values.end)), chart.backend_coord(&(times.end, values.start)))
}
