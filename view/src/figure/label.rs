//! Where the labels of extremes go.

use super::look::UNITS;
use super::path::Place;

/// Cost of each pixel of a label's width that a curve runs through, and of each pixel between a label and its marker.
const CROSSED: f64 = 3.0;
const AWAY: f64 = 1.2;
/// Cost of covering a marker, and of covering another label.
const MARKER: f64 = 300.0;
const LABEL: f64 = 5000.0;

/// A label with its box, in drawing units.
#[derive(Clone, Copy, Debug)]
pub(super) struct Label {
    /// The marker it belongs to.
    marker: Place,
    left: i32,
    top: i32,
    width: i32,
    height: i32,
}

impl Label {
    /// Where its text has its middle.
    pub(super) fn middle(&self) -> Place {
        (self.left + self.width / 2, self.top + self.height / 2)
    }

    /// The end of a line from the marker, if the label is too far away to do without.
    pub(super) fn leader(&self) -> Option<Place> {
        let x = self.marker.0.clamp(self.left + UNITS, self.left + self.width - UNITS);
        let y = self.marker.1.clamp(self.top, self.top + self.height);
        let away = f64::from(x - self.marker.0).hypot(f64::from(y - self.marker.1));
        (away > f64::from(12 * UNITS)).then_some((x, y))
    }

    fn distance(&self) -> f64 {
        let x = self.marker.0.clamp(self.left, self.left + self.width);
        let y = self.marker.1.clamp(self.top, self.top + self.height);
        f64::from(x - self.marker.0).hypot(f64::from(y - self.marker.1)) / f64::from(UNITS)
    }

    /// Whether a place lies in the label or within `rim` of it.
    fn covers(&self, place: Place, rim: i32) -> bool {
        (self.left - rim..=self.left + self.width + rim).contains(&place.0)
            && (self.top - rim..=self.top + self.height + rim).contains(&place.1)
    }

    fn overlaps(&self, other: &Self) -> bool {
        self.left < other.left + other.width
            && other.left < self.left + self.width
            && self.top < other.top + other.height
            && other.top < self.top + self.height
    }
}

/// What a label asks for: its marker, its width, and whether it belongs above.
pub(super) type Wish = (Place, i32, bool);

/// Places labels one after the other, each where it costs least: near its marker, clear of labels, markers and curves,
/// and within the plotting area from `corner` to `opposite`.
pub(super) fn placed(
    wishes: &[Wish],
    height: i32,
    paths: &[&[Place]],
    (corner, opposite): (Place, Place),
) -> Vec<Label> {
    let profiles: Vec<Profile> = paths.iter().map(|path| Profile::new(path, corner.0, opposite.0)).collect();
    let mut labels: Vec<Label> = Vec::new();
    for &(marker, width, is_above) in wishes {
        let mut best: Option<(f64, Label)> = None;
        let rows = (-17..=17).map(|row| row * 6 * UNITS);
        let beside = [8, 20, 36].map(|gap| width / 2 + gap * UNITS);
        let columns = (-6..=6).map(|column| column * width / 12).chain(beside).chain(beside.map(|dx| -dx));
        for (dx, dy) in rows.flat_map(|dy| columns.clone().map(move |dx| (dx, dy))) {
            // Clamping against an area that is too narrow must not panic.
            let left = (marker.0 + dx - width / 2).min(opposite.0 - width).max(corner.0 + 6 * UNITS);
            let top = marker.1 + dy - height / 2;
            if top < corner.1 || top + height > opposite.1 {
                continue;
            }
            let label = Label { marker, left, top, width, height };
            let mut cost = label.distance() * AWAY;
            cost += if (dy < 0) == is_above { 0.0 } else { 8.0 };
            // In the middle above or below looks best.
            cost += 4.0 * f64::from((left + width / 2 - marker.0).abs()) / f64::from(width);
            cost += LABEL * labels.iter().filter(|other| label.overlaps(other)).count() as f64;
            cost += MARKER * wishes.iter().filter(|wish| label.covers(wish.0, 4 * UNITS)).count() as f64;
            if best.is_some_and(|(least, _)| least <= cost) {
                continue;
            }
            cost += CROSSED * profiles.iter().map(|profile| profile.crossed(&label)).sum::<usize>() as f64;
            if best.is_none_or(|(least, _)| cost < least) {
                best = Some((cost, label));
            }
        }
        let (left, top) = (marker.0.min(opposite.0 - width), marker.1.min(opposite.1 - height));
        labels.push(best.map_or(Label { marker, left, top, width, height }, |(_, label)| label));
    }
    labels
}

/// From where to where a curve reaches in each pixel column.
struct Profile {
    start: i32,
    columns: Vec<(i32, i32)>,
}

impl Profile {
    fn new(path: &[Place], start: i32, end: i32) -> Self {
        let mut columns = vec![(i32::MAX, i32::MIN); ((end - start) / UNITS).max(0) as usize + 1];
        for pair in path.windows(2) {
            let ((x0, y0), (x1, y1)) = if pair[0].0 <= pair[1].0 { (pair[0], pair[1]) } else { (pair[1], pair[0]) };
            let slope = if x1 > x0 { f64::from(y1 - y0) / f64::from(x1 - x0) } else { 0.0 };
            let (from, to) = ((x0 - start) / UNITS, (x1 - start) / UNITS);
            for column in from.max(0)..=to {
                let Some(reach) = columns.get_mut(column as usize) else { break };
                let left = start + column * UNITS;
                let at = |x: i32| y0 + (slope * f64::from(x.clamp(x0, x1) - x0)) as i32;
                let ends = if x1 > x0 { [at(left), at(left + UNITS)] } else { [y0, y1] };
                reach.0 = reach.0.min(ends[0]).min(ends[1]);
                reach.1 = reach.1.max(ends[0]).max(ends[1]);
            }
        }
        Self { start, columns }
    }

    /// Through how many pixel columns of a label, and of a narrow rim around it, the curve runs.
    fn crossed(&self, label: &Label) -> usize {
        let rim = 2 * UNITS;
        let column = |x: i32| ((x - self.start) / UNITS).clamp(0, self.columns.len() as i32 - 1) as usize;
        let (top, bottom) = (label.top - rim, label.top + label.height + rim);
        let under = &self.columns[column(label.left - rim)..=column(label.left + label.width + rim)];
        under.iter().filter(|reach| reach.0 < bottom && reach.1 > top).count()
    }
}
