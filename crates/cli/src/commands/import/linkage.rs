//! A plane linkage that was read from a model. The readers of all formats return it, the writer makes a scene of it.

mod free_links;
mod outputs;

use super::numbers::{factor, signed_term, snap_rounding, wrap_angle};

/// A linkage that was read from a model. Its first link is the ground.
pub(super) struct ImportedLinkage {
    /// The name of the format.
    pub(super) format: &'static str,
    /// Comments at the head of the scene: what its numbers mean.
    pub(super) remarks: Vec<String>,
    /// The parts of the model that could not be carried over.
    pub(super) left_out: Vec<String>,
    pub(super) step: f64,
    pub(super) end_time: f64,
    pub(super) parameters: Vec<Parameter>,
    pub(super) links: Vec<Link>,
    pub(super) joints: Vec<Joint>,
    pub(super) constraints: Vec<Constraint>,
    pub(super) loads: Vec<Load>,
    /// Outputs: their names and their entries in the scene.
    pub(super) outputs: Vec<(String, String)>,
}

/// A number with a name.
pub(super) struct Parameter {
    pub(super) name: String,
    pub(super) value: f64,
    pub(super) unit: &'static str,
    pub(super) doc: String,
}

/// A link, with the place and the angle of its frame at the start.
pub(super) struct Link {
    pub(super) name: String,
    pub(super) place: [f64; 2],
    pub(super) angle: f64,
    /// Points in its frame, besides those of joints.
    pub(super) points: Vec<(String, [f64; 2])>,
    pub(super) mass: Option<Mass>,
    /// The velocity of its place at the start.
    pub(super) velocity: [f64; 2],
    /// The angular velocity at the start.
    pub(super) rate: f64,
}

impl Link {
    /// A link without points, without mass and at rest.
    pub(super) fn new(name: String, place: [f64; 2], angle: f64) -> Self {
        Self { name, place, angle, points: Vec::new(), mass: None, velocity: [0.0; 2], rate: 0.0 }
    }
}

/// The mass of a link, its centre and its moment of inertia about it.
#[derive(Clone, Copy)]
pub(super) struct Mass {
    pub(super) mass: f64,
    pub(super) com: [f64; 2],
    pub(super) inertia: f64,
}

/// A joint that connects places of links.
pub(super) struct Joint {
    pub(super) name: String,
    /// Its name in the model; empty, where the model does not have this joint.
    pub(super) model_name: String,
    pub(super) kind: Kind,
    pub(super) ends: Vec<End>,
    /// The angle or the place of the joint as a formula of time, if a drive prescribes it.
    pub(super) drive: Option<String>,
}

impl Joint {
    /// Whether the joint has a force, which is an output.
    pub(super) fn has_force(&self) -> bool {
        !matches!(self.kind, Kind::Gear { .. } | Kind::Rack { .. })
    }
}

/// The kind of a joint.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Kind {
    Pin,
    /// The first link slides along a line of the second one, at a direction in its frame and a held angle.
    Slider {
        direction: f64,
        rotation: f64,
    },
    /// The point of the first link is on a line of the second one.
    Slot {
        direction: f64,
    },
    Weld {
        rotation: f64,
    },
    /// The angle of the first link is `ratio` times that of the second one and `phase`, both against the carrier.
    Gear {
        ratio: f64,
        phase: f64,
        carrier: usize,
    },
    /// The first link rolls along a line of the second one.
    Rack {
        radius: f64,
        direction: f64,
    },
}

/// A place of a link, in its frame.
#[derive(Clone, Copy)]
pub(super) struct End {
    pub(super) link: usize,
    pub(super) at: [f64; 2],
}

/// A constraint between joint displacements: `residual` is zero.
pub(super) struct Constraint {
    pub(super) name: String,
    pub(super) residual: String,
    pub(super) unit: &'static str,
    /// The joints, with the derivatives of the residual by their displacements at the start.
    pub(super) gradient: Vec<(usize, f64)>,
}

/// A load.
pub(super) enum Load {
    Gravity([f64; 2]),
    /// A spring, a damper or a force along the displacement of a joint, as the keys that follow `along`.
    Along {
        name: String,
        along: String,
        keys: String,
    },
    /// A force at a point of a link. Its components are in the frame of a link, or of the ground.
    Force {
        name: String,
        force: [f64; 2],
        at: String,
        frame: Option<String>,
    },
}

impl ImportedLinkage {
    /// An empty linkage with its ground.
    pub(super) fn new(format: &'static str) -> Self {
        let ground = Link::new("ground".to_owned(), [0.0; 2], 0.0);
        Self {
            format,
            remarks: Vec::new(),
            left_out: Vec::new(),
            step: 1e-3,
            end_time: 1.0,
            parameters: Vec::new(),
            links: vec![ground],
            joints: Vec::new(),
            constraints: Vec::new(),
            loads: Vec::new(),
            outputs: Vec::new(),
        }
    }

    /// Removes the rounding of differences from all places.
    pub(super) fn tidied(mut self) -> Self {
        let ends = self.joints.iter().flat_map(|joint| &joint.ends).map(|end| end.at);
        let places = self.links.iter().map(|link| link.place).chain(ends);
        let size = places.flatten().fold(0.0, |most: f64, value| most.max(value.abs()));
        let tidy = |at: &mut [f64; 2]| at.iter_mut().for_each(|value| *value = snap_rounding(*value, size));
        self.joints.iter_mut().flat_map(|joint| &mut joint.ends).for_each(|end| tidy(&mut end.at));
        for link in &mut self.links {
            link.points.iter_mut().for_each(|(_, at)| tidy(at));
            link.mass.iter_mut().for_each(|mass| tidy(&mut mass.com));
        }
        self
    }

    /// The place of a point of a link at the start.
    pub(super) fn place(&self, end: End) -> [f64; 2] {
        let link = &self.links[end.link];
        let [x, y] = rotated(end.at, link.angle);
        [link.place[0] + x, link.place[1] + y]
    }

    /// Converts a place at the start into the frame of a link.
    pub(super) fn local(&self, link: usize, place: [f64; 2]) -> [f64; 2] {
        let link = &self.links[link];
        rotated([place[0] - link.place[0], place[1] - link.place[1]], -link.angle)
    }

    /// The names of the points of a joint on its first and its second link. Those of pins and welds are the same.
    pub(super) fn points(joint: &Joint) -> [String; 2] {
        let second = match joint.kind {
            Kind::Pin | Kind::Weld { .. } => joint.name.clone(),
            _ => format!("{}_line", joint.name),
        };
        [joint.name.clone(), second]
    }

    /// For each link: the link whose angle is its coordinate, and the constant angle between both.
    pub(super) fn angles(&self) -> Vec<(usize, f64)> {
        let mut found: Vec<Option<(usize, f64)>> = vec![None; self.links.len()];
        let mut neighbours: Vec<Vec<(usize, f64)>> = vec![Vec::new(); self.links.len()];
        for joint in &self.joints {
            if let Kind::Slider { rotation, .. } | Kind::Weld { rotation } = joint.kind {
                let [first, second] = [joint.ends[0].link, joint.ends[1].link];
                neighbours[second].push((first, rotation));
                neighbours[first].push((second, -rotation));
            }
        }
        for owner in 0..self.links.len() {
            if found[owner].is_some() {
                continue;
            }
            found[owner] = Some((owner, 0.0));
            let mut open = vec![(owner, 0.0)];
            while let Some((link, offset)) = open.pop() {
                for &(other, turn) in &neighbours[link] {
                    if found[other].is_none() {
                        found[other] = Some((owner, offset + turn));
                        open.push((other, offset + turn));
                    }
                }
            }
        }
        found.into_iter().map(|angle| angle.unwrap_or((0, 0.0))).collect()
    }

    /// The formula of the angle of a link minus that of another one, plus an offset.
    pub(super) fn turn(&self, first: usize, second: usize, offset: f64) -> String {
        let angles = self.angles();
        let [(a, a_offset), (b, b_offset)] = [angles[first], angles[second]];
        let text = match (a, b) {
            _ if a == b => "0".to_owned(),
            (0, _) => format!("-phi_{}", self.links[b].name),
            (_, 0) => format!("phi_{}", self.links[a].name),
            _ => format!("phi_{} - phi_{}", self.links[a].name, self.links[b].name),
        };
        text + &signed_term(wrap_angle(a_offset - b_offset + offset))
    }

    /// The formula of the place of a slider along its line, plus an offset.
    pub(super) fn slide(&self, joint: &Joint, direction: f64, offset: f64) -> String {
        let [point, line] = Self::points(joint);
        let (owner, turn) = self.angles()[joint.ends[1].link];
        let sum = wrap_angle(turn + direction);
        let along = |axis: &str, function: &str, number: f64| {
            let difference = format!("({point}.{axis} - {line}.{axis})");
            match owner {
                0 if number.abs() < 1e-15 => None,
                0 if (number - 1.0).abs() < 1e-15 => Some(difference),
                0 => Some(format!("{difference}*{}", factor(number))),
                _ => Some(format!("{difference}*{function}(phi_{}{})", self.links[owner].name, signed_term(sum))),
            }
        };
        let parts = [along("x", "cos", sum.cos()), along("y", "sin", sum.sin())];
        parts.into_iter().flatten().collect::<Vec<_>>().join(" + ") + &signed_term(offset)
    }
}

/// Rotates a vector by an angle.
pub(super) fn rotated([x, y]: [f64; 2], angle: f64) -> [f64; 2] {
    if angle == 0.0 {
        return [x, y];
    }
    let (sine, cosine) = angle.sin_cos();
    [x * cosine - y * sine, x * sine + y * cosine]
}
