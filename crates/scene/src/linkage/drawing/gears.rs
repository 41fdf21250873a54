//! The drawing of gears, racks and belts.

use crate::document::{DrawnSyntax, Identifier, JointKind, Position};
use crate::function::Function;
use crate::linkage::angles::Angles;
use crate::linkage::constants::Constants;
use crate::linkage::gears::{Mesh, axis};
use crate::linkage::graph::{Graph, Joint, PointId};
use crate::linkage::terms::{add, call, difference, divide, is_zero, multiply, negate, subtract, whole};
use crate::parser::Formula;

/// Draws all gears, racks and belts whose axes are known.
pub(super) fn gears(
    graph: &Graph,
    angles: &Angles,
    constants: &Constants,
    at: &dyn Fn(PointId) -> Position,
) -> Vec<(Identifier, DrawnSyntax)> {
    let mut wheels = Wheels { graph, angles, constants, at, gears: Vec::new(), drawn: Vec::new() };
    for joint in &graph.joints {
        match joint.syntax.kind {
            JointKind::Gear => wheels.pair(joint),
            JointKind::Rack => wheels.rack(joint),
            _ => {}
        }
    }
    wheels.drawn
}

struct Wheels<'w, 'd> {
    graph: &'w Graph<'d>,
    angles: &'w Angles,
    constants: &'w Constants<'w>,
    at: &'w dyn Fn(PointId) -> Position,
    /// The link, the axis and the radius of each gear already drawn.
    gears: Vec<(usize, PointId, f64)>,
    drawn: Vec<(Identifier, DrawnSyntax)>,
}

impl Wheels<'_, '_> {
    /// Draws two gears, a gear in a ring, or two pulleys with a belt.
    fn pair(&mut self, joint: &Joint) {
        let Some(ratio) = &joint.syntax.size else { return };
        let size = self.constants.value(ratio);
        let links = [joint.ends[0].link, joint.ends[1].link];
        if let Some(Mesh { axes, ring }) = Mesh::new(self.graph, self.constants, joint) {
            let Some(apart) = self.distance(axes[0], axes[1]) else { return };
            let less = match ring {
                Some(1) => subtract(ratio.clone(), whole(1)),
                _ => subtract(whole(1), ratio.clone()),
            };
            let radius = divide(apart, less);
            let other = multiply(if ring.is_none() { negate(ratio.clone()) } else { ratio.clone() }, radius.clone());
            // The gear inside the ring is drawn on top of it.
            let mut both = [(0, radius), (1, other)];
            both.rotate_left(ring.unwrap_or(0));
            for (gear, radius) in both {
                self.gear(links[gear], axes[gear], radius, ring == Some(gear));
            }
            return;
        }
        let axes = links.map(|link| axis(self.graph, self.constants, link, joint.carrier));
        let [Some(first), Some(second)] = axes else { return };
        if let Some(radii) = &joint.syntax.radii {
            self.belt(joint, [first, second], radii.clone(), size < 0.0);
        } else if size == 1.0
            && let Some(apart) = self.distance(first, second)
        {
            let radius = divide(apart, whole(5));
            self.belt(joint, [first, second], [radius.clone(), radius], false);
        }
    }

    /// Draws a belt over pulleys on the links of a joint; the axes are points of the carrier.
    fn belt(&mut self, joint: &Joint, axes: [PointId; 2], radii: [Formula; 2], is_crossed: bool) {
        let span = &joint.syntax.identifier.span;
        let [first, carrier] = [joint.ends[0].link, joint.carrier].map(|link| self.angles.formula(link, span));
        let angle = Some(subtract(first, carrier));
        let belt = DrawnSyntax::Belt { at: axes.map(self.at), radii, is_crossed, angle };
        self.drawn.push((joint.syntax.identifier.clone(), belt));
    }

    /// Draws a gear on a rack.
    fn rack(&mut self, joint: &Joint) {
        let Some(radius) = &joint.syntax.size else { return };
        let span = &joint.syntax.identifier.span;
        let [wheel, on] = [joint.ends[0], joint.ends[1]];
        let own = joint.syntax.direction.clone().unwrap_or_else(|| whole(0));
        let angle = Some(add(self.angles.formula(on.link, span), own));
        let rack = DrawnSyntax::Rack { on: (self.at)(on), wheel: (self.at)(wheel), radius: radius.clone(), angle };
        let identifier = match on.link {
            0 => joint.syntax.identifier.clone(),
            link => self.identifier(link, joint),
        };
        self.drawn.push((identifier, rack));
        self.gear(wheel.link, wheel, positive(radius.clone(), self.constants.value(radius)), false);
    }

    /// Draws a gear, unless it is already drawn.
    fn gear(&mut self, link: usize, axis: PointId, radius: Formula, is_internal: bool) {
        let size = self.constants.value(&radius);
        let is_same = |(other, at, own): &(usize, PointId, f64)| {
            (*other, *at) == (link, axis) && (own - size).abs() <= 1e-9 * size.abs()
        };
        if self.gears.iter().any(is_same) {
            return;
        }
        self.gears.push((link, axis, size));
        let span = self.graph.span(link);
        let angle = Some(self.angles.formula(link, &span));
        let identifier = Identifier { name: self.graph.name(link).to_owned(), span };
        let gear = DrawnSyntax::Gear { at: (self.at)(axis), radius, angle, is_internal };
        // Rings lie below everything else.
        let place = if is_internal { 0 } else { self.drawn.len() };
        self.drawn.insert(place, (identifier, gear));
    }

    fn identifier(&self, link: usize, joint: &Joint) -> Identifier {
        let own = self.graph.links[link].map(|link| &link.identifier);
        own.unwrap_or(&joint.syntax.identifier).clone()
    }

    /// The distance of two points of a link, if they differ.
    fn distance(&self, a: PointId, b: PointId) -> Option<Formula> {
        if a.link != b.link {
            return None;
        }
        let [x, y] = difference(self.graph.local(b), self.graph.local(a));
        let (along, across) = (self.constants.value(&x), self.constants.value(&y));
        if !(along.hypot(across) > 0.0) {
            return None;
        }
        Some(match (is_zero(&x), is_zero(&y)) {
            (_, true) => positive(x, along),
            (true, _) => positive(y, across),
            _ => call(Function::Hypot, [x, y]),
        })
    }
}

fn positive(formula: Formula, value: f64) -> Formula {
    if value < 0.0 { negate(formula) } else { formula }
}

#[cfg(test)]
mod tests {
    use crate::document::{Document, DrawnSyntax};
    use crate::linkage::expand;
    use crate::printer::print_formula;

    /// The drawing of links and joints, in words.
    fn drawn(links: &str, joints: &str) -> Vec<String> {
        let run = "run = { step = 1e-3, end_time = 1 }";
        let (mut document, mut findings) =
            Document::parse(&format!("name = \"drawn\"\n{run}\n[links]\n{links}\n[joints]\n{joints}\n"));
        expand(&mut document, &mut findings);
        let words = |(identifier, own): &(crate::document::Identifier, DrawnSyntax)| {
            let name = &identifier.name;
            match own {
                DrawnSyntax::Gear { radius, is_internal, .. } => {
                    format!("{} {name} {}", if *is_internal { "ring" } else { "gear" }, print_formula(radius))
                }
                DrawnSyntax::Belt { radii, is_crossed, .. } => {
                    let [first, second] = radii.each_ref().map(print_formula);
                    format!("belt {name} {first} {second} {is_crossed}")
                }
                DrawnSyntax::Rack { radius, .. } => format!("rack {name} {}", print_formula(radius)),
                DrawnSyntax::Link(places) => format!("link {name} {}", places.len()),
                DrawnSyntax::Rod(_) => format!("rod {name}"),
                DrawnSyntax::Block { on, .. } => format!("block {name} {}", on.is_some()),
                DrawnSyntax::Pivot(_) => format!("pivot {name}"),
                other => format!("{other:?}"),
            }
        };
        document.drawing.iter().map(words).collect()
    }

    const PAIR: &str = "ground = { points = { A = [0, 0], B = [0.3, 0] } }
a = { points = { A = [0, 0] }, mass = 1, com = \"A\", inertia = 1, angle = 0 }
b = { points = { B = [0, 0] }, mass = 1, com = \"B\", inertia = 1 }";
    const PINS: &str = "A = { revolute = [\"a\", \"ground\"] }\nB = { revolute = [\"b\", \"ground\"] }";

    #[test]
    fn a_negative_ratio_is_a_pair_of_gears() {
        let drawn = drawn(PAIR, &format!("{PINS}\nmesh = {{ gear = [\"a\", \"b\"], ratio = -2 }}"));
        assert_eq!(drawn, ["gear a 0.3/(1 + 2)", "gear b 2*(0.3/(1 + 2))", "pivot A", "pivot B"]);
    }

    #[test]
    fn a_positive_ratio_is_a_gear_in_a_ring() {
        let drawn = drawn(PAIR, &format!("{PINS}\nmesh = {{ gear = [\"a\", \"b\"], ratio = 0.5 }}"));
        assert_eq!(drawn, ["ring a 0.3/(1 - 0.5)", "gear b 0.5*(0.3/(1 - 0.5))", "pivot A", "pivot B"]);
    }

    #[test]
    fn a_ratio_of_one_is_a_belt() {
        let drawn = drawn(PAIR, &format!("{PINS}\nstrap = {{ gear = [\"a\", \"b\"], ratio = 1 }}"));
        assert_eq!(drawn, ["belt strap 0.3/5 0.3/5 false", "pivot A", "pivot B"]);
    }

    #[test]
    fn gears_on_one_axis_have_no_radii() {
        let ground = "ground = { points = { A = [0, 0], B = [0, 0] } }";
        let links = PAIR.replace(PAIR.lines().next().unwrap_or_default(), ground);
        let drawn = drawn(&links, &format!("{PINS}\nmesh = {{ gear = [\"a\", \"b\"], ratio = -2 }}"));
        assert_eq!(drawn, ["pivot A", "pivot B"]);
    }

    #[test]
    fn a_planet_rolls_in_the_ring_and_on_the_sun() {
        let links = "ground = { points = { O = [0, 0] } }
sun = { points = { O = [0, 0] }, mass = 1, com = \"O\", inertia = 1, angle = 0 }
arm = { bar = [\"O\", \"P\"], length = 0.3, mass = 1, angle = 0 }
planet = { points = { P = [0, 0] }, mass = 1, com = \"P\", inertia = 1, angle = 0 }";
        let joints = "S = { revolute = [\"sun.O\", \"ground.O\"] }
O = { revolute = [\"arm\", \"ground\"] }
P = { revolute = [\"planet\", \"arm\"] }
outer = { gear = [\"planet\", \"ground\"], ratio = 4, carrier = \"arm\" }
inner = { gear = [\"planet\", \"sun\"], ratio = -2, carrier = \"arm\" }";
        let drawn = drawn(links, joints);
        let gears = ["ring ground 4*(0.3/(4 - 1))", "gear planet 0.3/(4 - 1)", "gear sun 2*(0.3/(1 + 2))"];
        assert_eq!(drawn, [&gears[..], &["link arm 2", "pivot S", "pivot O"]].concat());
    }

    #[test]
    fn a_wheel_on_a_rack_needs_no_guide() {
        let links = "ground = { points = { O = [0, 0] } }
disc = { points = { C = [0, 0] }, mass = 1, com = \"C\", inertia = 1, angle = 0 }";
        let joints = "keep = { pin_in_slot = [\"disc.C\", \"ground.O\"], start = 0 }
roll = { rack = [\"disc.C\", \"ground.O\"], radius = -0.2 }";
        assert_eq!(drawn(links, joints), ["rack roll -0.2", "gear disc 0.2"]);
    }

    #[test]
    fn welded_links_are_one_and_rods_are_thin() {
        let links = "ground = { points = { O = [0, 0], G = [1, 0] } }
lower = { bar = [\"O\", \"A\"], length = 0.3, mass = 1, angle = 0, rate = 0 }
upper = { bar = [\"A\", \"B\"], length = 0.3, mass = 1 }
block = { points = { C = [0, 0] }, mass = 1, com = \"C\" }";
        let joints = "O = { revolute = [\"lower\", \"ground\"] }
A = { weld = [\"lower\", \"upper\"], rotation = 1 }
tie = { rod = [\"upper.B\", \"block.C\"], length = 0.5 }
guide = { prismatic = [\"block.C\", \"ground.G\"], start = 0 }";
        assert_eq!(drawn(links, joints), ["link lower 3", "pivot O", "rod tie", "block block true"]);
    }
}
