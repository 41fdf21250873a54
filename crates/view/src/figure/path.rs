//! The path of a curve, reduced to distinguishable points.

/// A position in drawing units.
pub(super) type Place = (i32, i32);

/// The largest deviation of a simplified path, in drawing units.
const TOLERANCE: f64 = 0.5;

/// A simplified path that looks like `places`; the highest and the lowest position are kept. If a restless curve has
/// more than `most` positions, each column of the drawing keeps the first and last position and the extremes.
pub(super) fn simplified(places: &[Place], most: usize) -> Vec<Place> {
    let crowded = places.len() > 20_000;
    let thinned = if crowded { thinned(places, 2) } else { places.to_vec() };
    let path = straightened(&thinned);
    if path.len() <= most.max(8) {
        return path;
    }
    let (first, last) = (path[0].0, path[path.len() - 1].0);
    let columns = (most.max(8) / 4) as i32;
    self::thinned(&path, (last - first).max(0) / columns + 1)
}

/// The first, lowest, highest and last position in every column of this width.
fn thinned(places: &[Place], width: i32) -> Vec<Place> {
    let mut kept = Vec::new();
    for column in places.chunk_by(|a, b| a.0.div_euclid(width) == b.0.div_euclid(width)) {
        let (low, high) = extremes(column);
        let mut picks = [0, low, high, column.len() - 1];
        picks.sort_unstable();
        kept.extend(picks.map(|i| column[i]));
    }
    kept.dedup();
    kept
}

/// Omits positions on the straight line between their neighbours. Starting at the last kept position, a cone is
/// narrowed until it contains no line that passes near all positions since; this takes a single pass.
fn straightened(places: &[Place]) -> Vec<Place> {
    let (low, high) = extremes(places);
    let mut kept: Vec<Place> = Vec::new();
    let open = (f64::NEG_INFINITY, f64::INFINITY);
    let mut cone = open;
    for (i, &place) in places.iter().enumerate() {
        let mut is_corner = i == 0 || i == low || i == high || i + 1 == places.len();
        if let (Some(&anchor), Some(previous)) = (kept.last(), i.checked_sub(1).map(|i| places[i])) {
            let mut reach = reach(anchor, place);
            if previous != anchor && !reach.is_some_and(|(slope, _)| (cone.0..=cone.1).contains(&slope)) {
                kept.push(previous);
                (reach, cone) = (self::reach(previous, place), open);
            }
            match reach {
                Some((slope, slack)) => cone = (cone.0.max(slope - slack), cone.1.min(slope + slack)),
                None => is_corner = true,
            }
        }
        if is_corner {
            kept.push(place);
            cone = open;
        }
    }
    kept.dedup();
    kept
}

/// The slope of the line from one position to another on its right, and the tolerance of that slope.
fn reach(from: Place, to: Place) -> Option<(f64, f64)> {
    let (dx, dy) = (f64::from(to.0 - from.0), f64::from(to.1 - from.1));
    (dx > 0.0).then(|| (dy / dx, TOLERANCE / dx))
}

/// The indices of the smallest and the largest ordinate.
fn extremes(places: &[Place]) -> (usize, usize) {
    let mut found = (0, 0);
    for (i, place) in places.iter().enumerate() {
        if place.1 < places[found.0].1 {
            found.0 = i;
        }
        if place.1 > places[found.1].1 {
            found.1 = i;
        }
    }
    found
}
