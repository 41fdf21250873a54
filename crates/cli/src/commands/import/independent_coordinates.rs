//! The independent coordinates of a linkage at its start: the angles and places whose rates may be given there.

use super::linkage::{ImportedLinkage, Kind, rotated};

/// The coordinates that are chosen as independent.
pub(super) struct IndependentCoordinates {
    /// Links, by their angle.
    pub(super) links: Vec<usize>,
    /// Joints, by the place of their slider.
    pub(super) joints: Vec<usize>,
}

impl IndependentCoordinates {
    /// Chooses as many independent angles and places as there are degrees of freedom, angles first.
    pub(super) fn choose(linkage: &ImportedLinkage) -> Self {
        let mut chosen = Self { links: Vec::new(), joints: Vec::new() };
        let jacobian = Jacobian(linkage);
        let size = jacobian.size();
        let mut space = RowSpace::new(size);
        let mut rows = jacobian.constraints();
        rows.extend(jacobian.drives());
        // Drives may prescribe all motion, also from a position in which their conditions depend on each other.
        let is_driven = linkage.joints.iter().any(|joint| joint.drive.is_some());
        let most = if is_driven { size.saturating_sub(rows.len()) } else { size };
        for row in &rows {
            space.add(row);
        }
        for (link, (owner, _)) in linkage.angles().into_iter().enumerate().skip(1) {
            if chosen.links.len() < most && owner == link && space.add(&jacobian.angle(&[(link, 1.0)])) {
                chosen.links.push(link);
            }
        }
        for (i, joint) in linkage.joints.iter().enumerate() {
            if chosen.links.len() + chosen.joints.len() < most
                && matches!(joint.kind, Kind::Slider { .. } | Kind::Slot { .. })
                && jacobian.displacement(i).is_some_and(|row| space.add(&row))
            {
                chosen.joints.push(i);
            }
        }
        chosen
    }
}

/// The degrees of freedom that the joints and constraints leave at the start. Drives do not count.
pub(super) fn freedom(linkage: &ImportedLinkage) -> usize {
    let jacobian = Jacobian(linkage);
    let mut space = RowSpace::new(jacobian.size());
    let rank = jacobian.constraints().iter().filter(|row| space.add(row)).count();
    jacobian.size() - rank
}

/// Whether a drive of a joint can move the linkage from its start.
pub(super) fn can_be_driven(linkage: &ImportedLinkage, joint: usize) -> bool {
    let jacobian = Jacobian(linkage);
    let mut space = RowSpace::new(jacobian.size());
    for row in &jacobian.constraints() {
        space.add(row);
    }
    jacobian.displacement(joint).is_some_and(|row| space.add(&row))
}

/// The joints whose drives prescribe what the joints and other drives determine. The drive of `first` counts first.
pub(super) fn repeated_drives(linkage: &ImportedLinkage, first: usize) -> Vec<usize> {
    let jacobian = Jacobian(linkage);
    let mut space = RowSpace::new(jacobian.size());
    for row in jacobian.constraints().iter().chain(&jacobian.displacement(first)) {
        space.add(row);
    }
    let driven = (0..linkage.joints.len()).filter(|joint| *joint != first && linkage.joints[*joint].drive.is_some());
    // At a dead centre more drives than freedoms seem possible.
    let mut rest = freedom(linkage).saturating_sub(1);
    let mut is_repeated = |joint: &usize| {
        let is_new = rest > 0 && jacobian.displacement(*joint).is_some_and(|row| space.add(&row));
        rest -= usize::from(is_new);
        !is_new
    };
    driven.filter(|joint| is_repeated(joint)).collect()
}

/// The rate of the place of a slider at the start, from the velocities of its links.
pub(super) fn slider_rate(linkage: &ImportedLinkage, joint: usize) -> f64 {
    rates(linkage, Jacobian(linkage).displacement(joint).unwrap_or_default()).sum()
}

/// Whether the velocities of the links at the start agree with the joints. Drives are not looked at.
pub(super) fn has_possible_velocities(linkage: &ImportedLinkage) -> bool {
    Jacobian(linkage).constraints().into_iter().all(|row| {
        let parts: Vec<f64> = rates(linkage, row).collect();
        parts.iter().sum::<f64>().abs() <= 1e-6 * parts.iter().map(|part| part.abs()).sum::<f64>()
    })
}

/// The numbers of a row times the rates of their columns.
fn rates(linkage: &ImportedLinkage, row: Row) -> impl Iterator<Item = f64> {
    row.into_iter().map(|(column, factor)| {
        let link = &linkage.links[column / 3 + 1];
        factor * [link.velocity[0], link.velocity[1], link.rate][column % 3]
    })
}

/// A row of a sparse matrix: columns and numbers. The numbers of a column that is there more than once are added.
type Row = Vec<(usize, f64)>;

/// Linearly independent rows in echelon form.
struct RowSpace {
    /// The pivot column and the row, which is 1 there and at most 1 elsewhere. Later rows are 0 in this column.
    rows: Vec<(usize, Row)>,
    /// The row that is being added, with all columns.
    dense: Vec<f64>,
}

impl RowSpace {
    fn new(size: usize) -> Self {
        Self { rows: Vec::new(), dense: vec![0.0; size] }
    }

    /// Adds a row, unless it depends on the others.
    fn add(&mut self, row: &Row) -> bool {
        let dense = &mut self.dense;
        dense.fill(0.0);
        row.iter().for_each(|(column, value)| dense[*column] += value);
        let (_, length) = largest(dense);
        for (pivot, other) in &self.rows {
            let factor = dense[*pivot];
            if factor != 0.0 {
                other.iter().for_each(|(column, value)| dense[*column] -= factor * value);
                dense[*pivot] = 0.0;
            }
        }
        let (pivot, rest) = largest(dense);
        let is_new = rest > 1e-7 * length;
        if is_new {
            let scale = dense[pivot];
            // Smaller numbers are rounding, and would fill the rows.
            let kept = dense.iter().map(|value| value / scale).enumerate().filter(|(_, value)| value.abs() > 1e-14);
            self.rows.push((pivot, kept.collect()));
        }
        is_new
    }
}

/// The column with the largest number, and its size.
fn largest(dense: &[f64]) -> (usize, f64) {
    let pairs = dense.iter().map(|value| value.abs()).enumerate();
    pairs.fold((0, 0.0), |best, pair| if pair.1 > best.1 { pair } else { best })
}

/// Derivatives by the places and angles of all links but the ground. Each link has three columns: x, y and its angle.
struct Jacobian<'l>(&'l ImportedLinkage);

impl Jacobian<'_> {
    fn size(&self) -> usize {
        3 * (self.0.links.len() - 1)
    }

    /// The derivatives of the angles and places that drives prescribe.
    fn drives(&self) -> impl Iterator<Item = Row> {
        let joints = self.0.joints.iter().enumerate();
        joints.filter(|(_, joint)| joint.drive.is_some()).filter_map(|(i, _)| self.displacement(i))
    }

    /// The derivatives of the conditions of joints and constraints.
    fn constraints(&self) -> Vec<Row> {
        let mut all = Vec::new();
        for (i, joint) in self.0.joints.iter().enumerate() {
            let first = joint.ends[0].link;
            for second in joint.ends.iter().skip(1).map(|end| end.link) {
                self.joint(i, joint.kind, first, second, &mut all);
            }
        }
        for constraint in &self.0.constraints {
            let parts = constraint.gradient.iter().flat_map(|&(joint, factor)| {
                let row = self.displacement(joint).unwrap_or_default();
                row.into_iter().map(move |(column, value)| (column, factor * value))
            });
            all.push(parts.collect());
        }
        all
    }

    /// Adds the conditions of a joint between two links.
    fn joint(&self, number: usize, kind: Kind, first: usize, second: usize, all: &mut Vec<Row>) {
        let difference = |axis: [f64; 2]| self.difference(first, second, number, axis);
        let line = |direction: f64, axis: [f64; 2]| rotated(axis, self.0.links[second].angle + direction);
        let angle = || self.angle(&[(first, 1.0), (second, -1.0)]);
        match kind {
            Kind::Pin => all.extend(AXES.map(difference)),
            Kind::Weld { .. } => {
                all.extend(AXES.map(difference));
                all.push(angle());
            }
            Kind::Slider { direction, .. } => {
                all.push(difference(line(direction, [0.0, 1.0])));
                all.push(angle());
            }
            Kind::Slot { direction } => all.push(difference(line(direction, [0.0, 1.0]))),
            Kind::Gear { ratio, carrier, .. } => {
                all.push(self.angle(&[(first, 1.0), (second, -ratio), (carrier, ratio - 1.0)]));
            }
            Kind::Rack { radius, direction } => {
                let mut row = difference(line(direction, [1.0, 0.0]));
                row.extend(self.angle(&[(first, radius), (second, -radius)]));
                all.push(row);
            }
        }
    }

    /// The derivative of the angle of a pin, or of the place of a slider.
    fn displacement(&self, joint: usize) -> Option<Row> {
        let own = &self.0.joints[joint];
        let [first, second] = [own.ends.first()?.link, own.ends.get(1)?.link];
        match own.kind {
            Kind::Pin => Some(self.angle(&[(first, 1.0), (second, -1.0)])),
            Kind::Slider { direction, .. } | Kind::Slot { direction } => {
                let angle = self.0.links[second].angle + direction;
                Some(self.difference(first, second, joint, rotated([1.0, 0.0], angle)))
            }
            _ => None,
        }
    }

    /// The derivative of a sum of angles.
    fn angle(&self, parts: &[(usize, f64)]) -> Row {
        parts.iter().filter(|(link, _)| *link > 0).map(|&(link, factor)| (3 * (link - 1) + 2, factor)).collect()
    }

    /// The derivative of the distance of the points of a joint along an axis of the second link. The line turns with
    /// that link: the point of the first one counts for both.
    fn difference(&self, first: usize, second: usize, joint: usize, axis: [f64; 2]) -> Row {
        let mut row = Row::new();
        let own = &self.0.joints[joint];
        let place = own.ends.iter().find(|end| end.link == first).map_or([0.0; 2], |end| self.0.place(*end));
        for (link, sign) in [(first, 1.0), (second, -1.0)] {
            if link > 0 {
                let [x, y] = self.0.links[link].place;
                let arm = [-(place[1] - y), place[0] - x];
                let at = 3 * (link - 1);
                let turn = axis[0] * arm[0] + axis[1] * arm[1];
                row.extend([(at, sign * axis[0]), (at + 1, sign * axis[1]), (at + 2, sign * turn)]);
            }
        }
        row
    }
}

const AXES: [[f64; 2]; 2] = [[1.0, 0.0], [0.0, 1.0]];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_that_depend_on_others_are_not_added() {
        let mut space = RowSpace::new(3);
        assert!(space.add(&vec![(0, 1.0), (1, 2.0)]));
        assert!(space.add(&vec![(1, 1.0), (2, 1e-3)]));
        assert!(!space.add(&vec![(0, 3.0), (1, 7.0), (2, 1e-3)]));
        assert!(!space.add(&vec![(0, 1.0), (0, -1.0)]));
        assert!(space.add(&vec![(2, 1e-6)]));
        assert!(!space.add(&vec![(0, 1.0)]));
    }
}
