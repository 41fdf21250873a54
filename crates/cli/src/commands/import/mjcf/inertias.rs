//! The inertia that each joint of a tree feels while the others are free.

use super::super::linkage::{ImportedLinkage, Kind, rotated};
use super::bodies::Bodies;
use super::links::Links;

impl Links {
    /// The inertia of each joint at the start: the reciprocal of its number on the diagonal of the inverse mass matrix.
    /// It is `None` where a mass is not known. Equality constraints do not count, as in MuJoCo.
    pub(super) fn inertias(
        &self,
        bodies: &Bodies,
        linkage: &ImportedLinkage,
        armatures: &[f64],
    ) -> Option<Vec<Option<f64>>> {
        if bodies.all.iter().any(|body| body.unknown_mass.is_some()) {
            return None;
        }
        let factor = cholesky(self.mass_matrix(linkage, armatures))?;
        let count = factor.len();
        let inertia = |own: usize| {
            let mut solved = vec![0.0; count];
            for row in own..count {
                let known: f64 = (own..row).map(|i| factor[row][i] * solved[i]).sum();
                solved[row] = (f64::from(u8::from(row == own)) - known) / factor[row][row];
            }
            Some(1.0 / solved.iter().map(|part| part * part).sum::<f64>()).filter(|inertia| inertia.is_finite())
        };
        Some((0..count).map(inertia).collect())
    }

    /// The mass matrix of the joints.
    fn mass_matrix(&self, linkage: &ImportedLinkage, armatures: &[f64]) -> Vec<Vec<f64>> {
        let count = self.joints.len();
        let mut matrix = vec![vec![0.0; count]; count];
        for (number, armature) in armatures.iter().enumerate().take(count) {
            matrix[number][number] = *armature;
        }
        for (link, own) in linkage.links.iter().enumerate().skip(1) {
            let Some(mass) = own.mass else { continue };
            let [x, y] = rotated(mass.com, own.angle);
            let com = [own.place[0] + x, own.place[1] + y];
            // The velocities of the mass that each joint above it gives.
            let rates: Vec<(usize, [f64; 3])> =
                self.above(linkage, link).into_iter().map(|joint| (joint, self.rate(linkage, joint, com))).collect();
            for (i, [ax, ay, a_turn]) in &rates {
                for (k, [bx, by, b_turn]) in &rates {
                    matrix[*i][*k] += mass.mass * (ax * bx + ay * by) + mass.inertia * a_turn * b_turn;
                }
            }
        }
        matrix
    }

    /// The joints between a link and the ground.
    pub(super) fn above(&self, linkage: &ImportedLinkage, link: usize) -> Vec<usize> {
        let mut found = Vec::new();
        let mut link = link;
        // Each link that was made of a body has one joint above it.
        let above =
            |link: usize| self.joints.iter().position(|joint| linkage.joints[joint.number].ends[0].link == link);
        while let Some(joint) = above(link).filter(|_| link > 0 && found.len() < self.joints.len()) {
            found.push(joint);
            link = linkage.joints[self.joints[joint].number].ends[1].link;
        }
        found
    }

    /// The velocity of a place, and the angular velocity, for a unit rate of a joint.
    fn rate(&self, linkage: &ImportedLinkage, joint: usize, place: [f64; 2]) -> [f64; 3] {
        let joint = &linkage.joints[self.joints[joint].number];
        if let Kind::Slider { direction, .. } = joint.kind {
            let [x, y] = rotated([1.0, 0.0], linkage.links[joint.ends[1].link].angle + direction);
            return [x, y, 0.0];
        }
        let [x, y] = linkage.place(joint.ends[0]);
        [y - place[1], place[0] - x, 1.0]
    }
}

/// The lower factor of a positive matrix; `None` for another one.
fn cholesky(mut matrix: Vec<Vec<f64>>) -> Option<Vec<Vec<f64>>> {
    for row in 0..matrix.len() {
        for column in 0..=row {
            let known: f64 = (0..column).map(|i| matrix[row][i] * matrix[column][i]).sum();
            let rest = matrix[row][column] - known;
            if column < row {
                matrix[row][column] = rest / matrix[column][column];
            } else if rest > 1e-12 * matrix[row][row].abs() {
                matrix[row][row] = rest.sqrt();
            } else {
                return None;
            }
        }
    }
    Some(matrix)
}
