//! The degrees of freedom of a linkage at its start: which angles and places may be given there.

use super::linkage::{Kind, Linkage, turned};

/// What is given at the start: links by their angle, joints by the place of their slider.
pub(super) struct Given {
    pub(super) links: Vec<usize>,
    pub(super) joints: Vec<usize>,
}

/// The largest number of links whose freedom is looked at.
const MOST_LINKS: usize = 200;

/// Chooses as many independent angles and places as there are degrees of freedom, angles first.
pub(super) fn given(linkage: &Linkage) -> Given {
    let mut given = Given { links: Vec::new(), joints: Vec::new() };
    if linkage.links.len() > MOST_LINKS {
        return given;
    }
    let size = 3 * (linkage.links.len() - 1);
    let mut span = Span { size, rows: Vec::new() };
    let rows = constraint_rows(linkage);
    // Drives may prescribe all motion, also from a position in which their conditions depend on each other.
    let is_driven = linkage.joints.iter().any(|joint| joint.drive.is_some());
    let most = if is_driven { size.saturating_sub(rows.len()) } else { size };
    for row in rows {
        span.add(row);
    }
    for (link, (owner, _)) in linkage.angles().into_iter().enumerate().skip(1) {
        if given.links.len() < most && owner == link && span.add(unit(size, 3 * (link - 1) + 2)) {
            given.links.push(link);
        }
    }
    for (i, joint) in linkage.joints.iter().enumerate() {
        if given.links.len() + given.joints.len() < most
            && let Some(row) = displacement_row(linkage, i)
            && matches!(joint.kind, Kind::Slider { .. } | Kind::Slot { .. })
            && span.add(row)
        {
            given.joints.push(i);
        }
    }
    given
}

/// Rows that are orthonormal.
struct Span {
    size: usize,
    rows: Vec<Vec<f64>>,
}

impl Span {
    /// Adds a row, unless it depends on the others.
    fn add(&mut self, mut row: Vec<f64>) -> bool {
        let length = norm(&row);
        if length == 0.0 || self.rows.len() == self.size {
            return false;
        }
        // Twice is enough to be orthogonal to the last digits.
        for _ in 0..2 {
            for other in &self.rows {
                let part: f64 = row.iter().zip(other).map(|(a, b)| a * b).sum();
                row.iter_mut().zip(other).for_each(|(a, b)| *a -= part * b);
            }
        }
        let rest = norm(&row);
        let is_new = rest > 1e-7 * length;
        if is_new {
            row.iter_mut().for_each(|value| *value /= rest);
            self.rows.push(row);
        }
        is_new
    }
}

fn norm(row: &[f64]) -> f64 {
    row.iter().map(|value| value * value).sum::<f64>().sqrt()
}

fn unit(size: usize, index: usize) -> Vec<f64> {
    let mut row = vec![0.0; size];
    row[index] = 1.0;
    row
}

/// The derivatives of the conditions of joints, drives and constraints by the places and angles of links.
fn constraint_rows(linkage: &Linkage) -> Vec<Vec<f64>> {
    let rows = Rows::of(linkage);
    let mut all = Vec::new();
    for (i, joint) in linkage.joints.iter().enumerate() {
        let first = joint.ends[0];
        for second in joint.ends.iter().skip(1) {
            match joint.kind {
                Kind::Pin => all.extend(axes().map(|axis| rows.difference(first.link, second.link, i, axis))),
                Kind::Weld { .. } => {
                    all.extend(axes().map(|axis| rows.difference(first.link, second.link, i, axis)));
                    all.push(rows.angle(&[(first.link, 1.0), (second.link, -1.0)]));
                }
                Kind::Slider { direction, .. } | Kind::Slot { direction } => {
                    let angle = linkage.links[second.link].angle + direction;
                    all.push(rows.difference(first.link, second.link, i, turned([0.0, 1.0], angle)));
                    if matches!(joint.kind, Kind::Slider { .. }) {
                        all.push(rows.angle(&[(first.link, 1.0), (second.link, -1.0)]));
                    }
                }
                Kind::Gear { ratio, carrier, .. } => {
                    all.push(rows.angle(&[(first.link, 1.0), (second.link, -ratio), (carrier, ratio - 1.0)]));
                }
                Kind::Rack { radius, direction } => {
                    let angle = linkage.links[second.link].angle + direction;
                    let slide = rows.difference(first.link, second.link, i, turned([1.0, 0.0], angle));
                    let roll = rows.angle(&[(first.link, radius), (second.link, -radius)]);
                    all.push(slide.iter().zip(&roll).map(|(a, b)| a + b).collect());
                }
            }
        }
        if joint.drive.is_some() {
            all.extend(displacement_row(linkage, i));
        }
    }
    for constraint in &linkage.constraints {
        let mut sum = vec![0.0; rows.size()];
        for &(joint, slope) in &constraint.slopes {
            let row = displacement_row(linkage, joint).unwrap_or_default();
            sum.iter_mut().zip(&row).for_each(|(value, part)| *value += slope * part);
        }
        all.push(sum);
    }
    all
}

fn axes() -> [[f64; 2]; 2] {
    [[1.0, 0.0], [0.0, 1.0]]
}

/// The derivative of the angle of a pin, or of the place of a slider, by the places and angles of links.
fn displacement_row(linkage: &Linkage, joint: usize) -> Option<Vec<f64>> {
    let rows = Rows::of(linkage);
    let own = &linkage.joints[joint];
    let [first, second] = [own.ends.first()?.link, own.ends.get(1)?.link];
    match own.kind {
        Kind::Pin => Some(rows.angle(&[(first, 1.0), (second, -1.0)])),
        Kind::Slider { direction, .. } | Kind::Slot { direction } => {
            let angle = linkage.links[second].angle + direction;
            Some(rows.difference(first, second, joint, turned([1.0, 0.0], angle)))
        }
        _ => None,
    }
}

/// Rows for the links but the ground, three numbers each.
struct Rows<'l>(&'l Linkage);

impl<'l> Rows<'l> {
    fn of(linkage: &'l Linkage) -> Self {
        Self(linkage)
    }

    fn size(&self) -> usize {
        3 * (self.0.links.len() - 1)
    }

    /// The derivative of a sum of angles.
    fn angle(&self, parts: &[(usize, f64)]) -> Vec<f64> {
        let mut row = vec![0.0; self.size()];
        for &(link, factor) in parts {
            if link > 0 {
                row[3 * (link - 1) + 2] += factor;
            }
        }
        row
    }

    /// The derivative of the distance of the points of a joint along an axis of the second link. The line turns with
    /// that link: the point of the first one counts for both.
    fn difference(&self, first: usize, second: usize, joint: usize, axis: [f64; 2]) -> Vec<f64> {
        let mut row = vec![0.0; self.size()];
        let own = &self.0.joints[joint];
        let place = own.ends.iter().find(|end| end.link == first).map_or([0.0; 2], |end| self.0.place(*end));
        for (link, sign) in [(first, 1.0), (second, -1.0)] {
            if link > 0 {
                let [x, y] = self.0.links[link].place;
                let arm = [-(place[1] - y), place[0] - x];
                let at = 3 * (link - 1);
                row[at] += sign * axis[0];
                row[at + 1] += sign * axis[1];
                row[at + 2] += sign * (axis[0] * arm[0] + axis[1] * arm[1]);
            }
        }
        row
    }
}
