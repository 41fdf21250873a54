//! Makes links of bodies, and joints of the plane of their joints.

use super::super::linkage::{End, ImportedLinkage, Joint, Kind, Link, Mass};
use super::super::names::Names;
use super::super::numbers::{factor, shortest, signed_term, wrap_angle};
use super::super::plane::{Plane, Vector};
use super::attributes::Attributes;
use super::bodies::{Bodies, Body, BodyJoint, PLANE_HELP};
use super::shape::joined;
use crate::error::Error;

/// The largest angle between axes that count as parallel. Models have numbers with 6 digits.
const PARALLEL: f64 = 1e-4;

/// The links and joints that were made of the bodies of a model.
pub(super) struct Links {
    /// The link of each body. A body without joints belongs to the link of the body that contains it.
    of_bodies: Vec<usize>,
    pub(super) joints: Vec<ImportedJoint>,
    /// The largest angle between an axis of the model and that of the plane. All axes are exact in the linkage.
    pub(super) deviation: f64,
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
        let mut own = Self { of_bodies: vec![0; bodies.all.len()], joints: Vec::new(), deviation: 0.0 };
        for (number, body) in bodies.all.iter().enumerate().skip(1) {
            let parent = own.of_bodies[body.parent];
            own.of_bodies[number] = if body.joints.is_empty() {
                parent
            } else {
                own.chain(attributes, body, plane, parent, linkage, names)?
            };
        }
        own.masses(attributes, bodies, plane, linkage)?;
        own.passive(attributes, bodies, linkage, names)?;
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
            let deviation = plane.deviation_of_slide(joint.axis);
            if deviation > PARALLEL {
                return Err(refuse("this slide leaves the plane"));
            }
            self.deviation = self.deviation.max(deviation);
            let [x, y] = plane.project(joint.axis);
            let rotation = wrap_angle(linkage.links[link].angle - angle);
            (Kind::Slider { direction: wrap_angle(y.atan2(x) - angle), rotation }, 1.0)
        } else {
            let (deviation, side) = plane.deviation_of_hinge(joint.axis);
            if deviation > PARALLEL {
                return Err(refuse("this hinge turns out of the plane"));
            }
            self.deviation = self.deviation.max(deviation);
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
        Ok(())
    }

    /// Adds up the masses of each link.
    fn masses(
        &self,
        attributes: &Attributes,
        bodies: &Bodies,
        plane: &Plane,
        linkage: &mut ImportedLinkage,
    ) -> Result<(), Error> {
        for link in 1..linkage.links.len() {
            let of_link = || {
                let all = bodies.all.iter().enumerate().filter(|(number, _)| self.of_bodies[*number] == link);
                all.map(|(_, body)| body)
            };
            let solids: Vec<_> = of_link().flat_map(|body| &body.solids).collect();
            let (mass, com, inertia) = joined(&solids, plane.normal);
            if mass == 0.0 && inertia == 0.0 {
                if let Some((body, element)) = of_link().find_map(|body| Some((body, body.unknown_mass?))) {
                    let title = format!("the mass of body `{}` is that of a mesh or a height field", body.name);
                    let help = "add `<inertial>` to the body: only MuJoCo reads the file of the shape";
                    return Err(attributes.xml.error(element, "name", &title, help));
                }
                continue;
            }
            let com = linkage.local(link, plane.project(com));
            linkage.links[link].mass = Some(Mass { mass, com, inertia });
        }
        Ok(())
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
    pub(super) fn link_of_body(&self, bodies: &Bodies, name: Option<&str>) -> Option<(usize, usize)> {
        let Some(name) = name else { return Some((0, 0)) };
        let number = bodies.all.iter().position(|body| body.name == name)?;
        Some((number, self.of_bodies[number]))
    }

    /// Finds the link and the place of a site.
    pub(super) fn link_of_site(&self, bodies: &Bodies, name: &str) -> Option<(usize, Vector)> {
        bodies.all.iter().enumerate().find_map(|(number, body)| {
            let (_, place) = body.sites.iter().find(|(own, _)| own == name)?;
            Some((self.of_bodies[number], *place))
        })
    }
}

impl ImportedJoint {
    /// The name of the joint in the model, or that in the scene.
    pub(super) fn title<'n>(&'n self, linkage: &'n ImportedLinkage) -> &'n str {
        if self.name.is_empty() { &linkage.joints[self.number].name } else { &self.name }
    }

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

#[cfg(test)]
mod tests {
    use super::super::super::imported;

    const JOINT: &str = "<joint name=\"s\" axis=\"0 1 0\" range=\"0 1\"/>";
    const GEOM: &str = "<geom size=\"0.1\"/>";

    #[test]
    fn axes_of_six_digits_are_parallel() {
        let text = |euler: &str, inner: &str| {
            let inner = format!("<body pos=\"0.3 0 0\" euler=\"{euler} 0 0\"><joint axis=\"{inner}\"/>{GEOM}</body>");
            format!(
                "<mujoco><compiler angle=\"radian\"/><worldbody><body>{JOINT}{GEOM}{inner}</body></worldbody>\
                 <actuator><motor name=\"m\" joint=\"s\"/></actuator></mujoco>"
            )
        };
        let scene = imported(&text("1.5708", "0 0 1")).expect("a scene");
        let remark = "# Axes of the model differ from those of the plane by up to 3.7e-6 rad; here they are exact.";
        assert!(scene.contains(remark), "{scene}");
        // Controls are zero and may be set; names are those of the model.
        assert!(scene.contains("ctrl_m = { value = 0, unit = \"N m\", runtime = true,"), "{scene}");
        assert!(scene.contains("# - the range of joint `s`\n"), "{scene}");
        assert!(!imported(&text("0", "0 1 0")).expect("a scene").contains("differ from those"));
        assert!(imported(&text("1.571", "0 0 1")).expect_err("no scene").contains("turns out of the plane"));
    }
}
