//! The path of a curve in bounded memory.

/// The largest number of points.
const MOST: usize = 40_000;

/// The largest deviation of the simplified path, relative to its width and height, unless memory is exhausted.
const TOLERANCE: f64 = 1e-4;

/// The largest number of consecutive points that are omitted.
const MOST_PENDING: usize = 64;

/// The corners of a path: points on the line between their neighbours are omitted.
pub(super) struct Path {
    kept: Vec<(f64, f64)>,
    /// The points since the last stored one.
    pending: Vec<(f64, f64)>,
    low: (f64, f64),
    high: (f64, f64),
    tolerance: f64,
}

impl Default for Path {
    fn default() -> Self {
        let (low, high) = ((f64::INFINITY, f64::INFINITY), (f64::NEG_INFINITY, f64::NEG_INFINITY));
        Self { kept: Vec::new(), pending: Vec::new(), low, high, tolerance: TOLERANCE }
    }
}

impl Path {
    /// Extends the path to a point.
    pub(super) fn push(&mut self, point: (f64, f64)) {
        self.low = (self.low.0.min(point.0), self.low.1.min(point.1));
        self.high = (self.high.0.max(point.0), self.high.1.max(point.1));
        self.add(point);
        if self.kept.len() > MOST {
            self.tolerance *= 2.0;
            let points = self.points();
            self.kept.clear();
            self.pending.clear();
            points.into_iter().for_each(|point| self.add(point));
        }
    }

    /// The corners of the path, from the first point to the last.
    pub(super) fn points(&self) -> Vec<(f64, f64)> {
        self.kept.iter().chain(self.pending.last()).copied().collect()
    }

    fn add(&mut self, point: (f64, f64)) {
        let Some(corner) = self.kept.last() else { return self.kept.push(point) };
        let is_straight = || self.pending.iter().all(|other| self.distance(*other, *corner, point) <= self.tolerance);
        if self.pending.len() == MOST_PENDING || !is_straight() {
            self.kept.extend(self.pending.last());
            self.pending.clear();
        }
        self.pending.push(point);
    }

    /// The distance of a point from the segment between two others, relative to the width and height.
    fn distance(&self, point: (f64, f64), from: (f64, f64), to: (f64, f64)) -> f64 {
        let size = (self.high.0 - self.low.0, self.high.1 - self.low.1);
        let part = |length: f64, size: f64| if size > 0.0 { length / size } else { 0.0 };
        let vector = |to: (f64, f64)| (part(to.0 - from.0, size.0), part(to.1 - from.1, size.1));
        let (way, off) = (vector(to), vector(point));
        let along = part(off.0 * way.0 + off.1 * way.1, way.0 * way.0 + way.1 * way.1).clamp(0.0, 1.0);
        (off.0 - along * way.0).hypot(off.1 - along * way.1)
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    /// A path of `turns` turns around a circle, with `each` points in each.
    fn turns(turns: usize, each: usize) -> Path {
        let mut path = Path::default();
        let angles = (0..=turns * each).map(|i| i as f64 * TAU / each as f64);
        angles.for_each(|angle| path.push((angle.cos(), 3.0 + angle.sin())));
        path
    }

    /// The largest distance of a segment between two corners from the circle.
    fn off(points: &[(f64, f64)]) -> f64 {
        let middles = points.windows(2).map(|pair| ((pair[0].0 + pair[1].0) / 2.0, (pair[0].1 + pair[1].1) / 2.0));
        middles.map(|(x, y)| 1.0 - x.hypot(y - 3.0)).fold(0.0, f64::max)
    }

    #[test]
    fn a_path_keeps_its_shape() {
        let points = turns(3, 1000).points();
        assert!((100..1000).contains(&points.len()), "{}", points.len());
        assert!(off(&points) < 4e-4, "{}", off(&points));
        let (first, last) = (points[0], points[points.len() - 1]);
        assert!((first.0 - last.0).hypot(first.1 - last.1) < 1e-9);
    }

    #[test]
    fn a_long_path_takes_bounded_memory() {
        let points = turns(2000, 500).points();
        assert!((MOST / 4..=MOST + 1).contains(&points.len()), "{}", points.len());
        // At least ten corners in a turn.
        assert!(off(&points) < 0.06, "{}", off(&points));
    }

    #[test]
    fn what_stands_still_is_a_point() {
        let mut path = Path::default();
        (0..1000).for_each(|_| path.push((1.0, 2.0)));
        assert!(path.points().len() < 20 && path.points().iter().all(|point| *point == (1.0, 2.0)));
    }

    #[test]
    fn every_peak_is_kept() {
        let mut path = Path::default();
        (0..100_000).for_each(|i| path.push((f64::from(i), f64::from(u8::from(i % 9973 == 5000)))));
        assert_eq!(path.points().iter().filter(|point| point.1 == 1.0).count(), 10);
    }
}
