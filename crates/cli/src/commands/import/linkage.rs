//! A plane linkage as a model describes it: what the readers of all formats give, and the writer takes.

use super::names::Names;
use super::numbers::{factor, further, tidy_at, within_a_turn};

/// A linkage; its first link is the ground.
pub(super) struct Linkage {
    /// The name of the format.
    pub(super) format: &'static str,
    /// What the numbers of the scene mean, a comment at its head.
    pub(super) remarks: Vec<String>,
    /// What could not be carried over.
    pub(super) left_out: Vec<String>,
    pub(super) step: f64,
    pub(super) end_time: f64,
    pub(super) parameters: Vec<Parameter>,
    pub(super) links: Vec<Link>,
    pub(super) joints: Vec<Joint>,
    pub(super) constraints: Vec<Constraint>,
    pub(super) loads: Vec<Load>,
    /// Outputs: the names and what stands behind them.
    pub(super) outputs: Vec<(String, String)>,
}

/// A number with a name.
pub(super) struct Parameter {
    pub(super) name: String,
    pub(super) value: f64,
    pub(super) unit: &'static str,
    pub(super) doc: String,
}

/// A link, with the pose of its frame at the start.
pub(super) struct Link {
    pub(super) name: String,
    pub(super) place: [f64; 2],
    pub(super) angle: f64,
    /// Points besides those of joints, in its frame.
    pub(super) points: Vec<(String, [f64; 2])>,
    pub(super) mass: Option<Mass>,
    /// The angular velocity at the start.
    pub(super) rate: f64,
}

/// The mass of a link, its centre and its moment of inertia about it.
#[derive(Clone, Copy)]
pub(super) struct Mass {
    pub(super) mass: f64,
    pub(super) com: [f64; 2],
    pub(super) inertia: f64,
}

/// A joint between places of links.
pub(super) struct Joint {
    pub(super) name: String,
    /// Its name in the model.
    pub(super) title: String,
    pub(super) kind: Kind,
    pub(super) ends: Vec<End>,
    /// Angle or place as a formula of time.
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

/// A condition on the displacements of joints: the sum of the factors times powers of them is zero.
pub(super) struct Constraint {
    pub(super) name: String,
    pub(super) residual: String,
    pub(super) unit: &'static str,
    /// The joints, and the derivatives of the residual by their displacements at the start.
    pub(super) slopes: Vec<(usize, f64)>,
}

/// A load.
pub(super) enum Load {
    Gravity([f64; 2]),
    /// Spring, damper and force along the displacement of a joint: keys behind `along`.
    Along {
        name: String,
        along: String,
        keys: String,
    },
    /// A force at a point of a link.
    Force {
        name: String,
        force: String,
        at: String,
    },
}

impl Linkage {
    /// An empty linkage with its ground.
    pub(super) fn new(format: &'static str) -> Self {
        let ground =
            Link { name: "ground".to_owned(), place: [0.0; 2], angle: 0.0, points: Vec::new(), mass: None, rate: 0.0 };
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

    /// Lets links move freely that joints do not lead to from the ground. Those without mass are fixed.
    pub(super) fn with_free_links(&mut self, names: &mut Names) {
        let count = self.links.len();
        let mut is_led = vec![false; count];
        for link in 0..count {
            if is_led[link] {
                continue;
            }
            let component = self.component(link);
            component.iter().for_each(|other| is_led[*other] = true);
            if link == 0 {
                continue;
            }
            if component.iter().any(|other| self.links[*other].mass.is_some()) {
                self.free(link, names);
                continue;
            }
            let Link { name, place, angle, .. } = &self.links[link];
            self.left_out.push(format!("the motion of `{name}`, which has no mass and no joint with the rest"));
            let ends = vec![End { link, at: [0.0; 2] }, End { link: 0, at: *place }];
            let (name, kind) = (names.unique(name, "part"), Kind::Weld { rotation: *angle });
            self.joints.push(Joint { title: String::new(), name, kind, ends, drive: None });
        }
    }

    /// The links that joints connect with a link.
    fn component(&self, link: usize) -> Vec<usize> {
        let mut found = vec![link];
        let mut at = 0;
        while let Some(&own) = found.get(at) {
            for joint in self.joints.iter().filter(|joint| joint.ends.iter().any(|end| end.link == own)) {
                for end in &joint.ends {
                    if !found.contains(&end.link) {
                        found.push(end.link);
                    }
                }
            }
            at += 1;
        }
        found
    }

    /// Joins a link to the ground by two sliders and a pin.
    fn free(&mut self, link: usize, names: &mut Names) {
        let Link { name, place, .. } = &self.links[link];
        let (name, place) = (name.clone(), *place);
        let mut below = End { link: 0, at: place };
        for (axis, direction) in [("x", 0.0), ("y", std::f64::consts::FRAC_PI_2)] {
            let number = self.links.len();
            let own = names.link(&format!("{name}_{axis}"), "part");
            self.links.push(Link { name: own, place, angle: 0.0, points: Vec::new(), mass: None, rate: 0.0 });
            let end = End { link: number, at: [0.0; 2] };
            let own = names.unique(&format!("{name}_{axis}"), "slide");
            let kind = Kind::Slider { direction, rotation: 0.0 };
            self.joints.push(Joint { title: String::new(), name: own, kind, ends: vec![end, below], drive: None });
            below = end;
        }
        let own = names.unique(&format!("{name}_turn"), "turn");
        let ends = vec![End { link, at: [0.0; 2] }, below];
        self.joints.push(Joint { title: String::new(), name: own, kind: Kind::Pin, ends, drive: None });
    }

    /// Removes the rounding of differences from all places.
    pub(super) fn tidied(mut self) -> Self {
        let ends = self.joints.iter().flat_map(|joint| &joint.ends).map(|end| end.at);
        let places = self.links.iter().map(|link| link.place).chain(ends);
        let size = places.flatten().fold(0.0, |most: f64, value| most.max(value.abs()));
        let tidy = |at: &mut [f64; 2]| at.iter_mut().for_each(|value| *value = tidy_at(*value, size));
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
        let [x, y] = turned(end.at, link.angle);
        [link.place[0] + x, link.place[1] + y]
    }

    /// A place at the start, in the frame of a link.
    pub(super) fn local(&self, link: usize, place: [f64; 2]) -> [f64; 2] {
        let link = &self.links[link];
        turned([place[0] - link.place[0], place[1] - link.place[1]], -link.angle)
    }

    /// The names of the two points of a joint. Only links of pins and welds have them in one place.
    pub(super) fn points(joint: &Joint) -> [String; 2] {
        let second = match joint.kind {
            Kind::Pin | Kind::Weld { .. } => joint.name.clone(),
            _ => format!("{}_line", joint.name),
        };
        [joint.name.clone(), second]
    }

    /// The link whose angle coordinate a link shares, and its own angle less that.
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

    /// The angle of a link less that of another one, and an offset, as a formula.
    pub(super) fn turn(&self, first: usize, second: usize, offset: f64) -> String {
        let angles = self.angles();
        let [(a, a_offset), (b, b_offset)] = [angles[first], angles[second]];
        let text = match (a, b) {
            _ if a == b => "0".to_owned(),
            (0, _) => format!("-phi_{}", self.links[b].name),
            (_, 0) => format!("phi_{}", self.links[a].name),
            _ => format!("phi_{} - phi_{}", self.links[a].name, self.links[b].name),
        };
        text + &further(within_a_turn(a_offset - b_offset + offset))
    }

    /// The place of the point of a slider along its line, and an offset, as a formula.
    pub(super) fn slide(&self, joint: &Joint, direction: f64, offset: f64) -> String {
        let [point, line] = Self::points(joint);
        let (owner, turn) = self.angles()[joint.ends[1].link];
        let sum = within_a_turn(turn + direction);
        let along = |axis: &str, function: &str, number: f64| {
            let difference = format!("({point}.{axis} - {line}.{axis})");
            match owner {
                0 if number.abs() < 1e-15 => None,
                0 if (number - 1.0).abs() < 1e-15 => Some(difference),
                0 => Some(format!("{difference}*{}", factor(number))),
                _ => Some(format!("{difference}*{function}(phi_{}{})", self.links[owner].name, further(sum))),
            }
        };
        let parts = [along("x", "cos", sum.cos()), along("y", "sin", sum.sin())];
        parts.into_iter().flatten().collect::<Vec<_>>().join(" + ") + &further(offset)
    }
}

/// A vector that is turned.
pub(super) fn turned([x, y]: [f64; 2], angle: f64) -> [f64; 2] {
    if angle == 0.0 {
        return [x, y];
    }
    let (sine, cosine) = angle.sin_cos();
    [x * cosine - y * sine, x * sine + y * cosine]
}
