//! The placement of the labels of extremes.

use super::look::UNITS;
use super::path::Place;
use super::profile::Profile;

/// The cost of each curve through a label, and of each of its pixels there.
const CROSSING: f64 = 30.0;
const CROSSED: f64 = 3.0;
/// The cost of each pixel between a label and its marker.
const DISTANCE_COST: f64 = 1.2;
/// The costs of covering a marker, of a leader through another label or marker, and of covering another label.
const MARKER: f64 = 300.0;
const LEADER: f64 = 400.0;
const LABEL: f64 = 5000.0;

/// The number of points of a leader that are tested for conflicts.
const PARTS: i32 = 40;

/// The number of times that each label may look for a better position among the others.
const ROUNDS: usize = 6;

/// A label with its box, in drawing units.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Label {
    /// The marker of the label.
    marker: Place,
    pub(super) left: i32,
    pub(super) top: i32,
    pub(super) width: i32,
    pub(super) height: i32,
}

impl Label {
    /// The centre of its text.
    pub(super) fn middle(&self) -> Place {
        (self.left + self.width / 2, self.top + self.height / 2)
    }

    /// The end of a line from the marker, if the label is so far away that it needs one.
    pub(super) fn leader(&self) -> Option<Place> {
        let x = self.marker.0.clamp(self.left + UNITS, self.left + self.width - UNITS);
        let y = self.marker.1.clamp(self.top, self.top + self.height);
        let [dx, dy] = [x - self.marker.0, y - self.marker.1].map(i64::from);
        (dx * dx + dy * dy > i64::from(12 * UNITS).pow(2)).then_some((x, y))
    }

    fn distance(&self) -> f64 {
        let x = self.marker.0.clamp(self.left, self.left + self.width);
        let y = self.marker.1.clamp(self.top, self.top + self.height);
        f64::from(x - self.marker.0).hypot(f64::from(y - self.marker.1)) / f64::from(UNITS)
    }

    /// Whether a position lies in the label or within `rim` of it.
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

    /// Whether the line from the marker passes through the rectangle with these corners.
    fn leads_through(&self, low: Place, high: Place) -> bool {
        let is_apart = |a: i32, b: i32, low: i32, high: i32| a.max(b) < low || a.min(b) > high;
        let between = |a: i32, b: i32, part: i32| a + (b - a) / PARTS * part;
        self.leader().is_some_and(|end| {
            let ((x0, y0), (x1, y1)) = (self.marker, end);
            if is_apart(x0, x1, low.0, high.0) || is_apart(y0, y1, low.1, high.1) {
                return false;
            }
            (1..=PARTS).any(|part| {
                (low.0..=high.0).contains(&between(x0, x1, part)) && (low.1..=high.1).contains(&between(y0, y1, part))
            })
        })
    }

    /// Whether the line from the marker of one of two labels crosses the other label.
    fn is_crossed(&self, other: &Self) -> bool {
        let opposite = |label: &Self| (label.left + label.width, label.top + label.height);
        self.leads_through((other.left, other.top), opposite(other))
            || other.leads_through((self.left, self.top), opposite(self))
    }

    /// Whether the line from its own marker crosses another one.
    fn leads_over(&self, (x, y): Place) -> bool {
        let near = 4 * UNITS - 1;
        let is_near = (self.marker.0 - x).abs().max((self.marker.1 - y).abs()) <= near;
        !is_near && self.leads_through((x - near, y - near), (x + near, y + near))
    }
}

/// The requirements of a label: its marker, its width, and whether it should be above.
pub(super) type LabelRequest = (Place, i32, bool);

/// Places labels, each at the lowest cost: near its marker, clear of labels, markers and curves, and within the
/// plotting area from `corner` to `opposite`. Earlier labels move if later ones obstruct them.
pub(super) fn place_labels(
    requests: &[LabelRequest],
    height: i32,
    paths: &[&[Place]],
    area: (Place, Place),
) -> Vec<Label> {
    let space = LabelSpace {
        markers: requests.iter().map(|request| request.0).collect(),
        profiles: paths.iter().map(|path| Profile::new(path, area.0.0, area.1.0)).collect(),
        height,
        area,
    };
    let candidates: Vec<Vec<Candidate>> = requests.iter().map(|request| space.candidates(request)).collect();
    let mut labels: Vec<Label> = Vec::new();
    for round in 0..ROUNDS {
        let before = labels.clone();
        for (i, (request, candidates)) in requests.iter().zip(&candidates).enumerate() {
            let others: Vec<Label> =
                labels.iter().enumerate().filter(|(other, _)| *other != i).map(|(_, label)| *label).collect();
            let label = space.best(request, candidates, &others);
            match labels.get_mut(i) {
                Some(place) => *place = label,
                None => labels.push(label),
            }
        }
        if round > 0 && labels == before {
            break;
        }
    }
    labels
}

/// A possible position of a label.
struct Candidate {
    label: Label,
    /// The cost of the position itself, without that of conflicts.
    cost: f64,
    /// Its place among positions of equal cost.
    rank: usize,
}

/// The obstacles for labels, and the area for them.
struct LabelSpace {
    markers: Vec<Place>,
    profiles: Vec<Profile>,
    height: i32,
    area: (Place, Place),
}

impl LabelSpace {
    /// The possible positions of a label, by their costs.
    fn candidates(&self, &(marker, width, is_above): &LabelRequest) -> Vec<Candidate> {
        let (corner, opposite) = self.area;
        let height = self.height;
        let rows = (-22..=22).map(|row| row * 6 * UNITS);
        let beside = [8, 14, 20, 36, 60, 90].map(|gap| width / 2 + gap * UNITS);
        let columns = (-6..=6).map(|column| column * width / 12).chain(beside).chain(beside.map(|dx| -dx));
        let mut candidates = Vec::new();
        for (dx, dy) in rows.flat_map(|dy| columns.clone().map(move |dx| (dx, dy))) {
            // Clamping to an area that is too narrow must not panic.
            let left = (marker.0 + dx - width / 2).min(opposite.0 - width).max(corner.0 + 6 * UNITS);
            let top = marker.1 + dy - height / 2;
            if top < corner.1 || top + height > opposite.1 {
                continue;
            }
            let label = Label { marker, left, top, width, height };
            let mut cost = label.distance() * DISTANCE_COST;
            cost += if (dy < 0) == is_above { 0.0 } else { 8.0 };
            // Prefer the middle above or below.
            cost += 4.0 * f64::from((left + width / 2 - marker.0).abs()) / f64::from(width);
            candidates.push(Candidate { label, cost, rank: candidates.len() });
        }
        candidates.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        candidates
    }

    /// The cheapest position of a label among others.
    fn best(&self, &(marker, width, _): &LabelRequest, candidates: &[Candidate], others: &[Label]) -> Label {
        let mut best: Option<(f64, &Candidate)> = None;
        for candidate in candidates {
            let Candidate { label, mut cost, rank } = *candidate;
            let is_worse = |cost: f64| {
                best.is_some_and(|(least, first)| least.total_cmp(&cost).then(first.rank.cmp(&rank)).is_lt())
            };
            if best.is_some_and(|(least, _)| least < cost) {
                break;
            }
            cost += LABEL * others.iter().filter(|other| label.overlaps(other)).count() as f64;
            cost += MARKER * self.markers.iter().filter(|marker| label.covers(**marker, 4 * UNITS)).count() as f64;
            if is_worse(cost) {
                continue;
            }
            cost += LEADER * others.iter().filter(|other| label.is_crossed(other)).count() as f64;
            cost += LEADER * self.markers.iter().filter(|marker| label.leads_over(**marker)).count() as f64;
            if is_worse(cost) {
                continue;
            }
            let covered =
                self.profiles.iter().map(|profile| profile.covered_by(&label)).filter(|covered| *covered > 0.0);
            cost += covered.map(|covered| CROSSING + CROSSED * covered).sum::<f64>();
            if !is_worse(cost) {
                best = Some((cost, candidate));
            }
        }
        let (_, opposite) = self.area;
        let (left, top) = (marker.0.min(opposite.0 - width), marker.1.min(opposite.1 - self.height));
        let unplaced = Label { marker, left, top, width, height: self.height };
        best.map_or(unplaced, |(_, candidate)| candidate.label)
    }
}
