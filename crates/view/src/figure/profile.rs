//! The area of the drawing that a curve covers.

use super::label::Label;
use super::look::UNITS;
use super::path::Place;

/// The vertical extent of a curve in each pixel column.
pub(super) struct Profile {
    start: i32,
    columns: Vec<(i32, i32)>,
}

impl Profile {
    /// The profile of a curve between two columns of the drawing.
    pub(super) fn new(path: &[Place], start: i32, end: i32) -> Self {
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

    /// The approximate number of pixels of the curve in a label or in a narrow rim around it.
    pub(super) fn covered_by(&self, label: &Label) -> f64 {
        let rim = 2 * UNITS;
        let column = |x: i32| ((x - self.start) / UNITS).clamp(0, self.columns.len() as i32 - 1) as usize;
        let (top, bottom) = (label.top - rim, label.top + label.height + rim);
        let under = &self.columns[column(label.left - rim)..=column(label.left + label.width + rim)];
        let crossed = under.iter().filter(|reach| reach.0 < bottom && reach.1 > top);
        // A steep piece hides as much text as it is long.
        let length = |reach: &(i32, i32)| 1.0 + f64::from(reach.1.min(bottom) - reach.0.max(top)) / f64::from(UNITS);
        crossed.map(length).sum()
    }
}
