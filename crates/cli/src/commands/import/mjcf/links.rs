//! Makes links of bodies, and joints of the plane of their joints.

use super::super::linkage::{End, ImportedLinkage, Joint, Kind, Link, Load, Mass};
use super::super::names::Names;
use super::super::numbers::{factor, shortest, signed_term, wrap_angle};
use super::super::plane::{Plane, Vector};
use super::attributes::Attributes;
use super::bodies::{Bodies, Body, BodyJoint, PLANE_HELP};
use super::shape::joined;
use crate::error::Error;

/// The links and joints that were made of the bodies of a model.
pub(super) struct Links {
    /// The link of each body. A body without joints belongs to the link of the body that contains it.
    of_bodies: Vec<usize>,
    pub(super) joints: Vec<ImportedJoint>,
}

/// A joint of the model, and its counterpart in the linkage.
pub(super) struct ImportedJoint {
    pub(super) name: String,
    pub(super) number: usize,
    pub(super) is_slide: bool,
    /// 1, or -1 where the hinge of the model turns clockwise in the plane.
    pub(super) axis_sign: f64,
    /// The position of the joint in the model at the start.
    pub(super) reference: f64,
}

impl Links {
    /// Makes links of bodies, each with its joints.
    pub(super) fn add(
        attributes: &Attributes,
        bodies: &Bodies,
        plane: &Plane,
        linkage: &mut ImportedLinkage,
        names: &mut Names,
    ) -> Result<Self, Error> {
        let mut own = Self { of_bodies: vec![0; bodies.all.len()], joints: Vec::new() };
        for (number, body) in bodies.all.iter().enumerate().skip(1) {
            let parent = own.of_bodies[body.parent];
            own.of_bodies[number] = if body.joints.is_empty() {
                parent
            } else {
                own.chain(attributes, body, plane, parent, linkage, names)?
            };
        }
        own.masses(bodies, plane, linkage);
        own.sites(bodies, plane, linkage, names);
        Ok(own)
    }

    /// Makes a link for each joint of a body; all but the last have no mass.
    fn chain(
        &mut self,
        attributes: &Attributes,
        body: &Body,
        plane: &Plane,
        parent: usize,
        linkage: &mut ImportedLinkage,
        names: &mut Names,
    ) -> Result<usize, Error> {
        let mut parent = parent;
        let place = plane.project(body.frame.place);
        let angle = plane.body(&body.frame).angle;
        let last = names.link(&body.name, "body");
        for (i, joint) in body.joints.iter().enumerate() {
            let is_last = i + 1 == body.joints.len();
            let name = if is_last { last.clone() } else { names.link(&format!("{last}_{}", i + 1), "body") };
            let link = linkage.links.len();
            linkage.links.push(Link::new(name, place, angle));
            self.joint(attributes, body, joint, plane, [link, parent], linkage, names)?;
            parent = link;
        }
        Ok(parent)
    }

    #[expect(clippy::too_many_arguments, reason = "a joint has two links and a body, and needs a name")]
    fn joint(
        &mut self,
        attributes: &Attributes,
        body: &Body,
        joint: &BodyJoint,
        plane: &Plane,
        [link, parent]: [usize; 2],
        linkage: &mut ImportedLinkage,
        names: &mut Names,
    ) -> Result<(), Error> {
        let refuse = |title: &str| {
            let [x, y, z] = plane.normal.map(shortest);
            let label = format!("the linkage moves across the axis ({x}, {y}, {z})");
            attributes.xml.source.error(title, joint.span.clone(), &label, PLANE_HELP)
        };
        let angle = linkage.links[parent].angle;
        let (kind, axis_sign) = if joint.is_slide {
            if !plane.contains(joint.axis) {
                return Err(refuse("this slide leaves the plane"));
            }
            let [x, y] = plane.project(joint.axis);
            let rotation = wrap_angle(linkage.links[link].angle - angle);
            (Kind::Slider { direction: wrap_angle(y.atan2(x) - angle), rotation }, 1.0)
        } else {
            let Some(side) = plane.normal_sign(joint.axis) else {
                return Err(refuse("this hinge turns out of the plane"));
            };
            (Kind::Pin, side)
        };
        let at = plane.project(joint.place);
        let ends = [link, parent].map(|link| End { link, at: linkage.local(link, at) }).to_vec();
        let model_name = joint.element.get("name").unwrap_or_default().to_owned();
        let wanted = if model_name.is_empty() { format!("{}_joint", body.name) } else { model_name.clone() };
        let name = names.unique(&wanted, "joint");
        let number = linkage.joints.len();
        linkage.joints.push(Joint { name, model_name: model_name.clone(), kind, ends, drive: None });
        let value = |name: &str| attributes.number(joint.element, &joint.class, name);
        let reference = value("ref")?.unwrap_or(0.0);
        let reference = if joint.is_slide { reference } else { attributes.angle(reference) };
        self.joints.push(ImportedJoint { name: model_name, number, is_slide: joint.is_slide, axis_sign, reference });
        self.spring_damper(attributes, joint, [link, parent], linkage, names)
    }

    /// Adds the spring and the damper of a joint, and notes what is left out of it.
    fn spring_damper(
        &self,
        attributes: &Attributes,
        joint: &BodyJoint,
        [link, parent]: [usize; 2],
        linkage: &mut ImportedLinkage,
        names: &mut Names,
    ) -> Result<(), Error> {
        let Some(moved) = self.joints.last() else { return Ok(()) };
        let values = |name: &str| attributes.numbers(joint.element, &joint.class, name);
        let value = |name: &str| Ok::<_, Error>(values(name)?.map_or(0.0, |numbers| numbers[0]));
        let own = linkage.joints[moved.number].name.clone();
        let mut keys = Vec::new();
        let stiffness = value("stiffness")?;
        if stiffness != 0.0 {
            let rest = value("springref")?;
            let rest = if moved.is_slide { rest } else { attributes.angle(rest) } - moved.reference;
            let unit = if moved.is_slide { "m" } else { "rad" };
            keys.push(format!("spring = {}", shortest(stiffness)));
            if rest != 0.0 {
                keys.push(format!("rest = '{} {unit}'", shortest(rest)));
            }
        }
        let damping = value("damping")?;
        if damping != 0.0 {
            keys.push(format!("damper = {}", shortest(damping)));
        }
        if !keys.is_empty() {
            let along = moved.displacement(linkage);
            let name = names.unique(&format!("passive_{own}"), "spring");
            linkage.loads.push(Load::Along { name, along, keys: keys.join(", ") });
        }
        for name in ["stiffness", "damping"] {
            if values(name)?.is_some_and(|numbers| numbers[1..].iter().any(|number| *number != 0.0)) {
                linkage.left_out.push(format!("the nonlinear part of the {name} of joint `{own}`"));
            }
        }
        let armature = value("armature")?;
        if armature != 0.0
            && !moved.is_slide
            && parent == 0
            && !linkage.joints[..moved.number].iter().any(|other| other.ends[0].link == link)
        {
            // The rotor of a joint on the ground turns with its link.
            let mass = linkage.links[link].mass.get_or_insert(Mass { mass: 0.0, com: [0.0; 2], inertia: 0.0 });
            mass.inertia += armature;
        } else if armature != 0.0 {
            linkage.left_out.push(format!("the armature of joint `{own}`"));
        }
        if value("frictionloss")? != 0.0 {
            linkage.left_out.push(format!("the dry friction of joint `{own}`"));
        }
        let limited = attributes.get(joint.element, &joint.class, "limited");
        let has_range = attributes.get(joint.element, &joint.class, "range").is_some();
        if limited == Some("true") || has_range && limited != Some("false") {
            linkage.left_out.push(format!("the range of joint `{own}`"));
        }
        Ok(())
    }

    /// Adds up the masses of each link.
    fn masses(&self, bodies: &Bodies, plane: &Plane, linkage: &mut ImportedLinkage) {
        for link in 1..linkage.links.len() {
            let of_link = bodies.all.iter().enumerate().filter(|(number, _)| self.of_bodies[*number] == link);
            let solids: Vec<_> = of_link.flat_map(|(_, body)| &body.solids).collect();
            let (mass, com, inertia) = joined(&solids, plane.normal);
            if mass == 0.0 && inertia == 0.0 {
                continue;
            }
            let com = linkage.local(link, plane.project(com));
            let rotor = linkage.links[link].mass.map_or(0.0, |rotor| rotor.inertia);
            linkage.links[link].mass = Some(Mass { mass, com, inertia: inertia + rotor });
        }
    }

    /// Adds sites as points, and their coordinates as outputs.
    fn sites(&self, bodies: &Bodies, plane: &Plane, linkage: &mut ImportedLinkage, names: &mut Names) {
        for (number, body) in bodies.all.iter().enumerate() {
            let link = self.of_bodies[number];
            for (site, place) in &body.sites {
                let name = names.unique(site, "site");
                let at = linkage.local(link, plane.project(*place));
                linkage.links[link].points.push((name.clone(), at));
                if link > 0 {
                    linkage.trace_point(&name, names);
                }
            }
        }
    }

    /// Finds a body by its name, and its link. Without a name it is the world.
    pub(super) fn of_body(&self, bodies: &Bodies, name: Option<&str>) -> Option<(usize, usize)> {
        let Some(name) = name else { return Some((0, 0)) };
        let number = bodies.all.iter().position(|body| body.name == name)?;
        Some((number, self.of_bodies[number]))
    }

    /// Finds the link and the place of a site.
    pub(super) fn of_site(&self, bodies: &Bodies, name: &str) -> Option<(usize, Vector)> {
        bodies.all.iter().enumerate().find_map(|(number, body)| {
            let (_, place) = body.sites.iter().find(|(own, _)| own == name)?;
            Some((self.of_bodies[number], *place))
        })
    }
}

impl ImportedJoint {
    /// The formula of the displacement of the joint from the start.
    pub(super) fn displacement(&self, linkage: &ImportedLinkage) -> String {
        let joint = &linkage.joints[self.number];
        let [link, parent] = [joint.ends[0].link, joint.ends[1].link];
        if let Kind::Slider { direction, .. } = joint.kind {
            return linkage.slide(joint, direction, 0.0);
        }
        let [a, b] = [link, parent].map(|link| linkage.links[link].angle);
        if self.axis_sign > 0.0 { linkage.turn(link, parent, b - a) } else { linkage.turn(parent, link, a - b) }
    }
}

/// Writes the polynomial of a formula. The first coefficient is the constant.
pub(super) fn polynomial(coefficients: &[f64], of: &str) -> String {
    let mut text = String::new();
    for (power, coefficient) in coefficients.iter().enumerate().skip(1).filter(|(_, coefficient)| **coefficient != 0.0)
    {
        let sign = if text.is_empty() { "" } else { " + " };
        let exponent = if power > 1 { format!("^{power}") } else { String::new() };
        text.push_str(&format!("{sign}{}*({of}){exponent}", factor(*coefficient)));
    }
    let constant = coefficients.first().copied().unwrap_or(0.0);
    if text.is_empty() { shortest(constant) } else { text + &signed_term(constant) }
}
