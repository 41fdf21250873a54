//! The approximate positions of links at the start, from values read off a drawing.

use std::collections::HashMap;

use super::angles::Angles;
use super::cams;
use super::graph::{Graph, Joint, PointId};
use super::places::{origin_names, slide};
use super::start::StartValue;
use super::terms::{
    add, at_time_zero, call, difference, direction, divide, dot, is_positive, is_zero, multiply, negate, rotated,
    subtract, sum, whole,
};
use super::tree::{Placement, Tree};
use crate::document::{JointKind, LinkSyntax};
use crate::function::Function;
use crate::parser::Formula;

/// The known positions of links at the start.
pub(super) struct StartPositions<'g, 'd> {
    graph: &'g Graph<'d>,
    angles: &'g Angles,
    tree: &'g Tree,
    /// The values of the angle coordinates, by their numbers.
    of_classes: Vec<Option<Formula>>,
    points: HashMap<PointId, [Formula; 2]>,
}

impl<'g, 'd> StartPositions<'g, 'd> {
    /// Propagates the given values until nothing further follows.
    pub(super) fn new(graph: &'g Graph<'d>, angles: &'g Angles, tree: &'g Tree) -> Self {
        let of_classes = vec![None; angles.coordinates.len() + 1];
        let mut known = Self { graph, angles, tree, of_classes, points: HashMap::new() };
        known.of_classes[0] = Some(whole(0));
        for link in 1..graph.links.len() {
            if let Some(angle) = graph.links[link].and_then(|link| link.angle.clone()) {
                known.set_angle(link, angle);
            }
        }
        for joint in &graph.joints {
            if let Some(near) = &joint.syntax.near {
                let ends = if joint.syntax.kind.is_pin() { &joint.ends[..] } else { &joint.ends[..1] };
                known.points.extend(ends.iter().map(|end| (*end, near.clone())));
            }
        }
        while known.follow() {}
        known
    }

    /// Propagates once; returns whether a new value was found.
    fn follow(&mut self) -> bool {
        let before = (self.points.len(), self.of_classes.iter().flatten().count());
        for joint in self.graph.joints.iter().filter(|joint| joint.syntax.kind.is_pin()) {
            if let Some(place) = joint.ends.iter().find_map(|end| self.points.get(end).cloned()) {
                for end in &joint.ends {
                    self.points.entry(*end).or_insert_with(|| place.clone());
                }
            }
        }
        for joint in &self.graph.joints {
            match joint.syntax.kind {
                JointKind::Gear => self.follow_gears(joint),
                JointKind::Revolute => self.follow_drive(joint),
                kind if kind.is_slider() => self.follow_slider(joint),
                _ => {}
            }
        }
        for link in 0..self.graph.links.len() {
            let own = (0..self.graph.points(link).len()).map(|point| PointId { link, point });
            let known: Vec<PointId> = own.clone().filter(|id| self.points.contains_key(id)).collect();
            if let (None, [a, b, ..]) = (self.angle(link), &known[..]) {
                let there = difference(self.points[b].clone(), self.points[a].clone());
                let here = difference(self.graph.local(*b), self.graph.local(*a));
                self.set_angle(link, angle_between(here, there));
            }
            let Some(angle) = self.angle(link) else { continue };
            let base = match known.first() {
                Some(id) => (self.graph.local(*id), self.points[id].clone()),
                None if link == 0 => ([whole(0), whole(0)], [whole(0), whole(0)]),
                None => continue,
            };
            for id in own {
                let local = difference(self.graph.local(id), base.0.clone());
                self.points.entry(id).or_insert_with(|| sum(base.1.clone(), rotated(local, &angle)));
            }
        }
        before != (self.points.len(), self.of_classes.iter().flatten().count())
    }

    /// Finds the angle of a gear from that of the other one.
    fn follow_gears(&mut self, joint: &Joint) {
        let [first, second] = [joint.ends[0].link, joint.ends[1].link];
        let (Some(carrier), Some(ratio)) = (self.angle(joint.carrier), &joint.syntax.size) else { return };
        let phase = joint.syntax.phase.clone().unwrap_or_else(|| whole(0));
        match (self.angle(first), self.angle(second)) {
            (None, Some(angle)) => {
                let turned = multiply(ratio.clone(), subtract(angle, carrier.clone()));
                self.set_angle(first, add(carrier, add(turned, phase)));
            }
            (Some(angle), None) => {
                let turned = divide(subtract(subtract(angle, carrier.clone()), phase), ratio.clone());
                self.set_angle(second, add(carrier, turned));
            }
            _ => {}
        }
    }

    /// Finds the angle of a link from the driven angle at time zero.
    fn follow_drive(&mut self, joint: &Joint) {
        let Some(drive) = &joint.syntax.drive else { return };
        let angle = at_time_zero(drive);
        let [first, second] = [joint.ends[0].link, joint.ends[1].link];
        match (self.angle(first), self.angle(second)) {
            (None, Some(other)) => self.set_angle(first, add(other, angle)),
            (Some(own), None) => self.set_angle(second, subtract(own, angle)),
            _ => {}
        }
    }

    /// Finds the angle of a slider's line from two points on it, and the second point from that angle and the slider's
    /// length.
    fn follow_slider(&mut self, joint: &Joint) {
        let [own, on] = [joint.ends[0], joint.ends[1]];
        let Some(base) = self.points.get(&on).cloned() else { return };
        let direction_of_line = joint.syntax.direction.clone().unwrap_or_else(|| whole(0));
        match (self.points.get(&own).cloned(), self.angle(on.link)) {
            (Some(place), None) => {
                let angle = angle_between([whole(1), whole(0)], difference(place, base));
                self.set_angle(on.link, subtract(angle, direction_of_line));
            }
            (None, Some(angle)) => {
                let Some(length) = start_of_slider(joint) else { return };
                let way = direction(&add(angle, direction_of_line)).map(|part| multiply(length.clone(), part));
                self.points.insert(own, sum(base, way));
            }
            _ => {}
        }
    }

    fn set_angle(&mut self, link: usize, angle: Formula) {
        let own = self.angles.angle(link);
        if self.of_classes[own.class].is_none() {
            self.of_classes[own.class] = Some(subtract(angle, own.offset.clone()));
        }
    }

    fn angle(&self, link: usize) -> Option<Formula> {
        let own = self.angles.angle(link);
        Some(add(self.of_classes[own.class].clone()?, own.offset.clone()))
    }

    /// The start values of all coordinates, in their order.
    pub(super) fn values(&self) -> Vec<StartValue> {
        let mut values = Vec::new();
        for (place, (name, _)) in self.angles.coordinates.iter().enumerate() {
            let members = (1..self.graph.links.len()).filter(|link| self.angles.angle(*link).class == place + 1);
            let members: Vec<&LinkSyntax> = members.filter_map(|link| self.graph.links[link]).collect();
            values.push(StartValue {
                name: name.clone(),
                value: self.of_classes[place + 1].clone(),
                is_written: members.iter().any(|link| link.angle.is_some()),
                rate: members.iter().find_map(|link| link.rate.clone()),
            });
        }
        for &link in &self.tree.order {
            match self.tree.placements[link] {
                Placement::Slider { joint, .. } => values.push(self.slider(joint)),
                Placement::Free => {
                    let angle = self.angle(link);
                    let known = (0..self.graph.points(link).len()).map(|point| PointId { link, point });
                    let known = known.filter(|id| self.points.contains_key(id)).collect::<Vec<_>>();
                    let origin = known
                        .first()
                        .zip(angle)
                        .map(|(id, angle)| difference(self.points[id].clone(), rotated(self.graph.local(*id), &angle)));
                    let origin = origin.unwrap_or([whole(0), whole(0)]);
                    values.extend(
                        origin_names(self.graph, link).into_iter().zip(origin).map(|(name, value)| StartValue {
                            name,
                            value: Some(value),
                            is_written: false,
                            rate: None,
                        }),
                    );
                }
                Placement::Ground | Placement::Pin { .. } => {}
            }
        }
        values.extend(cams::coordinates(self.graph).map(|(joint, name)| self.contact(joint, name)));
        values
    }

    /// The start value of a cam's contact angle, from the position of its follower.
    fn contact(&self, joint: usize, name: String) -> StartValue {
        let Joint { syntax, ends, .. } = &self.graph.joints[joint];
        let seen = || {
            let cam = self.angle(ends[1].link)?;
            if let Some(face) = &syntax.face {
                return Some(subtract(add(self.angle(ends[0].link)?, face.clone()), cam));
            }
            let way = difference(self.points.get(&ends[0])?.clone(), self.points.get(&ends[1])?.clone());
            Some(subtract(angle_between([whole(1), whole(0)], way), cam))
        };
        let is_written = syntax.start.is_some();
        StartValue { name, value: syntax.start.clone().or_else(seen), is_written, rate: None }
    }

    fn slider(&self, joint: usize) -> StartValue {
        let syntax = self.graph.joints[joint].syntax;
        let ends = &self.graph.joints[joint].ends;
        let seen = || {
            let way = difference(self.points.get(&ends[0])?.clone(), self.points.get(&ends[1])?.clone());
            let angle = self.angle(ends[1].link)?;
            let angle = syntax.direction.clone().map_or(angle.clone(), |own| add(angle, own));
            Some(dot(way, direction(&angle)))
        };
        StartValue {
            name: slide(self.graph, joint),
            value: start_of_slider(&self.graph.joints[joint]).or_else(seen),
            is_written: syntax.start.is_some(),
            rate: syntax.rate.clone(),
        }
    }
}

/// The position along the line of a slider at the start, as far as the slider gives it.
fn start_of_slider(joint: &Joint) -> Option<Formula> {
    joint.syntax.start.clone().or_else(|| joint.syntax.drive.as_ref().map(at_time_zero))
}

/// The angle from one vector to another, from -pi to pi.
fn angle_between(from: [Formula; 2], to: [Formula; 2]) -> Formula {
    let [x, y] = from;
    // The second vector in a frame aligned with the first one, up to a factor.
    let [along, across] = match (is_positive(&x), is_zero(&y)) {
        (true, true) => to,
        _ => [dot([x.clone(), y.clone()], to.clone()), dot([negate(y), x], to)],
    };
    if is_zero(&across) && is_positive(&along) {
        return whole(0);
    }
    call(Function::Atan2, [across, along])
}
