//! The line of a curve in the drawing.

use super::chart::Chart;
use super::look;
use super::path::{Place, simplified};
use super::{Curve, Scale, span};

/// The largest number of points in a figure of acceptable file size.
const MOST_POINTS: usize = 10_000;
/// The largest number of pieces in a figure of acceptable file size.
const MOST_PIECES: usize = 1_200;

/// The line of a curve.
#[derive(Clone, Debug)]
pub(super) struct Trace {
    /// The unbroken pieces of the line.
    pub(super) pieces: Vec<Vec<Place>>,
    is_restless: bool,
}

impl Trace {
    /// Creates the line of one of `curves` curves in a figure.
    pub(super) fn new(chart: &Chart<'_>, scale: Scale, curve: &Curve, curves: usize) -> Self {
        let points = with_extremes(curve);
        let share = MOST_POINTS / curves.max(1);
        let shown = points.chunk_by(|a, b| span::is_shown(scale, a.1) == span::is_shown(scale, b.1));
        let drawn = shown.filter(|piece| span::is_shown(scale, piece[0].1)).map(|piece| {
            let places: Vec<Place> = piece.iter().map(|point| chart.backend_coord(point)).collect();
            let mut path = simplified(&places, share * piece.len() / points.len());
            if path.len() == 1 {
                // The round ends of a line without length form a dot.
                path.push(path[0]);
            }
            path
        });
        let pieces = sparse(drawn.collect(), MOST_PIECES / curves.max(1));
        let is_restless = is_restless(&pieces);
        Self { pieces, is_restless }
    }

    /// The width of the line, in hundredths of a pixel.
    pub(super) fn width(&self) -> u32 {
        if self.is_restless { look::THIN } else { look::CURVE }
    }
}

/// If a curve has more than `most` pieces, those that end close to another one are omitted.
fn sparse(pieces: Vec<Vec<Place>>, most: usize) -> Vec<Vec<Place>> {
    if pieces.len() <= most {
        return pieces;
    }
    let end = |piece: &[Place]| piece.last().map_or(0, |place| place.0);
    let start = pieces[0][0].0;
    let gap = (end(&pieces[pieces.len() - 1]) - start) / most.max(1) as i32;
    let mut reached = start - gap - 1;
    let is_kept = |piece: &Vec<Place>| {
        let is_far = end(piece) > reached + gap;
        reached = if is_far { end(piece) } else { reached };
        is_far
    };
    pieces.into_iter().filter(is_kept).collect()
}

/// The points of a curve, and its extremes between them.
fn with_extremes(curve: &Curve) -> Vec<(f64, f64)> {
    let mut points = curve.points.clone();
    for extreme in curve.extremes.iter().flat_map(|e| [e.minimum, e.maximum]) {
        let at = points.partition_point(|point| point.0 < extreme.0);
        if 0 < at && at < points.len() && points[at].0 > extreme.0 {
            points.insert(at, extreme);
        }
    }
    points
}

/// Whether a curve oscillates so often that a line of the usual width would blacken the area.
fn is_restless(pieces: &[Vec<Place>]) -> bool {
    let steps = || pieces.iter().flat_map(|piece| piece.windows(2));
    let across: f64 = steps().map(|step| f64::from((step[1].0 - step[0].0).abs())).sum();
    let climbed: f64 = steps().map(|step| f64::from((step[1].1 - step[0].1).abs())).sum();
    climbed > 8.0 * across && steps().count() > 200
}
