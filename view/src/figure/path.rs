//! The path of a curve, with no more points than can be told apart.

/// A place in drawing units.
pub(super) type Place = (i32, i32);

/// How far a path may stray from what was drawn, in drawing units.
const TOLERANCE: f64 = 0.5;

/// A path that cannot be told from `places`; the highest and the lowest place stay. If there are more than `most`
/// places of a restless curve, each column of the drawing keeps where it enters, its extremes and where it leaves.
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

/// First, lowest, highest and last place of every column of this width.
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

/// Leaves out what lies on the straight line between its neighbours (Ramer, Douglas and Peucker).
fn straightened(places: &[Place]) -> Vec<Place> {
    let mut places = places.to_vec();
    places.dedup();
    if places.len() < 3 {
        return places;
    }
    let end = places.len() - 1;
    let (low, high) = extremes(&places);
    let mut is_kept = vec![false; places.len()];
    let mut corners = [0, low, high, end];
    corners.sort_unstable();
    corners.iter().for_each(|&i| is_kept[i] = true);
    let mut spans: Vec<(usize, usize)> = corners.windows(2).map(|pair| (pair[0], pair[1])).collect();
    while let Some((a, b)) = spans.pop() {
        let mut farthest = (TOLERANCE, None);
        for i in a + 1..b {
            let distance = distance(places[i], places[a], places[b]);
            if distance > farthest.0 {
                farthest = (distance, Some(i));
            }
        }
        if let Some(i) = farthest.1 {
            is_kept[i] = true;
            spans.extend([(a, i), (i, b)]);
        }
    }
    places.iter().zip(is_kept).filter_map(|(place, kept)| kept.then_some(*place)).collect()
}

/// Where the ordinate is smallest and where it is largest.
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

/// From a place to the line from `a` to `b`.
fn distance(place: Place, a: Place, b: Place) -> f64 {
    let vector = |from: Place, to: Place| (f64::from(to.0 - from.0), f64::from(to.1 - from.1));
    let ((x, y), (dx, dy)) = (vector(a, place), vector(a, b));
    let length = dx.hypot(dy);
    let along = if length > 0.0 { ((x * dx + y * dy) / (length * length)).clamp(0.0, 1.0) } else { 0.0 };
    (x - along * dx).hypot(y - along * dy)
}
