//! Cams and followers: the angle of contact in the frame of the cam is a coordinate.

use super::angles::Angles;
use super::graph::{Graph, Joint};
use super::places::Places;
use super::terms::{add, difference, direction, dot, name, negate, substituted, subtract, whole};
use crate::document::JointKind;
use crate::parser::Formula;

/// The name of the angle in a cam profile.
pub(super) const THETA: &str = "theta";

/// The suffix that turns the name of a cam into the name of the constraint of its contact angle.
pub(super) const CONTACT: &str = "_contact";

/// A cam in an expanded scene.
pub(super) struct Cam<'c> {
    joint: &'c Joint<'c>,
    angles: &'c Angles,
    /// The vector from the point of the cam to that of the follower.
    offset: [Formula; 2],
    /// The angle of contact in the frame of the cam.
    theta: Formula,
}

/// The coordinates of all cams with the numbers of their joints.
pub(super) fn coordinates<'g>(graph: &'g Graph) -> impl Iterator<Item = (usize, String)> + 'g {
    let cams = graph.joints.iter().enumerate().filter(|(_, joint)| joint.syntax.kind == JointKind::Cam);
    cams.map(|(number, joint)| (number, coordinate(joint)))
}

/// The name of the coordinate of a cam.
fn coordinate(joint: &Joint) -> String {
    format!("{THETA}_{}", joint.syntax.identifier.name)
}

impl<'c> Cam<'c> {
    pub(super) fn new(joint: &'c Joint<'c>, angles: &'c Angles, places: &Places) -> Self {
        let span = &joint.syntax.identifier.span;
        let [point, centre] = [0, 1].map(|end: usize| places.components(joint.ends[end], span));
        Self { joint, angles, offset: difference(point, centre), theta: name(coordinate(joint), span) }
    }

    fn angle(&self, end: usize) -> Formula {
        self.angles.formula(self.joint.ends[end].link, &self.joint.syntax.identifier.span)
    }

    /// The direction in which the profile is measured, and its perpendicular. The direction runs from the centre to the
    /// point, or normal to the face of the follower.
    pub(super) fn directions(&self) -> [[Formula; 2]; 2] {
        let angle = match &self.joint.syntax.face {
            Some(face) => add(self.angle(0), face.clone()),
            None => add(self.angle(1), self.theta.clone()),
        };
        let [cos, sin] = direction(&angle);
        [[cos.clone(), sin.clone()], [negate(sin), cos]]
    }

    /// The distance of the follower from the profile, with its derivatives with respect to the angles of links.
    pub(super) fn distance(&self) -> (Formula, Vec<(usize, Formula)>) {
        let [along, across] = self.directions();
        let profile = self.joint.syntax.profile.clone().unwrap_or_else(|| whole(0));
        let residual = subtract(dot(self.offset.clone(), along), substituted(&profile, THETA, &self.theta));
        // The end whose link turns the direction.
        let end = if self.joint.syntax.face.is_some() { 0 } else { 1 };
        (residual, vec![(self.joint.ends[end].link, dot(self.offset.clone(), across))])
    }

    /// The residual that determines the contact angle, with its unit and its derivatives with respect to the angles of
    /// links.
    pub(super) fn contact(&self) -> (Formula, &'static str, Vec<(usize, Formula)>) {
        let [follower, cam] = [self.joint.ends[0].link, self.joint.ends[1].link];
        match &self.joint.syntax.face {
            Some(face) => {
                let seen = subtract(add(self.angle(0), face.clone()), self.angle(1));
                let slopes = vec![(follower, whole(-1)), (cam, whole(1))];
                (subtract(self.theta.clone(), seen), "rad", slopes)
            }
            None => {
                let [along, across] = self.directions();
                (dot(self.offset.clone(), across), "m", vec![(cam, negate(dot(self.offset.clone(), along)))])
            }
        }
    }
}
