//! The tree of bodies: their frames in the world, their joints, masses and sites.

use std::ops::Range;

use super::super::plane::{Frame, Vector, norm};
use super::attributes::{Attributes, MAIN};
use super::shape::{Solid, geom, inertial};
use super::xml::{Element, Xml};
use crate::error::Error;

/// The bodies of a model; the world is the first.
pub(super) struct Bodies<'x> {
    pub(super) all: Vec<Body<'x>>,
    left_out: Vec<String>,
    pub(super) has_geoms: bool,
    inertia_from: InertiaFrom,
}

/// The largest number of bodies of a model.
const MAX_BODIES: usize = 1000;

/// The help for a joint that leaves the plane.
pub(super) const PLANE_HELP: &str =
    "a scene is a plane linkage: join bodies by hinges with parallel axes, and by slides across them";

/// A body.
pub(super) struct Body<'x> {
    pub(super) name: String,
    pub(super) frame: Frame,
    /// The number of the body that contains this one.
    pub(super) parent: usize,
    pub(super) joints: Vec<BodyJoint<'x>>,
    /// Masses in the world.
    pub(super) solids: Vec<Solid>,
    /// The masses that could not be carried over.
    left_out: Vec<String>,
    has_shape_of_file: bool,
    /// The element of the body, if it has a mass that only MuJoCo knows.
    pub(super) unknown_mass: Option<&'x Element>,
    pub(super) sites: Vec<(String, Vector)>,
}

/// A joint between a body and the body that contains it.
pub(super) struct BodyJoint<'x> {
    pub(super) element: &'x Element,
    pub(super) class: String,
    pub(super) is_slide: bool,
    /// Its axis and its place in the world.
    pub(super) axis: Vector,
    pub(super) place: Vector,
    pub(super) span: Range<usize>,
}

/// Where masses come from.
#[derive(Clone, Copy, PartialEq)]
enum InertiaFrom {
    Inertial,
    Geoms,
    /// From geoms, where a body has no `inertial`.
    Either,
}

impl<'x> Bodies<'x> {
    pub(super) fn read(attributes: &Attributes<'x>, xml: &'x Xml<'x>) -> Result<Self, Error> {
        let compiler = xml.children(xml.root()).filter(|element| element.name == "compiler");
        let inertia_from = match compiler.filter_map(|element| element.get("inertiafromgeom")).last() {
            Some("true") => InertiaFrom::Geoms,
            Some("false") => InertiaFrom::Inertial,
            _ => InertiaFrom::Either,
        };
        let mut own = Self { all: Vec::new(), left_out: Vec::new(), has_geoms: false, inertia_from };
        own.all.push(Body::new("world", Frame::WORLD, 0));
        for world in xml.children(xml.root()).filter(|element| element.name == "worldbody") {
            let class = world.get("childclass").unwrap_or(MAIN);
            let items = own.content(attributes, xml, world, 0, &Frame::WORLD, class)?;
            own.bodies(attributes, xml, items)?;
        }
        Ok(own)
    }

    /// Reads bodies, and those in them.
    fn bodies(&mut self, attributes: &Attributes<'x>, xml: &'x Xml<'x>, items: Vec<Inner<'x>>) -> Result<(), Error> {
        for Inner { element, frame, class, parent } in items {
            let class = element.get("childclass").unwrap_or(&class).to_owned();
            let frame = frame.then(&attributes.frame(element, "")?);
            let number = self.all.len();
            if number > MAX_BODIES {
                return Err(xml.error(
                    element,
                    "",
                    "the model has too many bodies",
                    "import a model of at most 1000 bodies",
                ));
            }
            self.all.push(Body::new(element.get("name").unwrap_or("body"), frame, parent));
            if element.get("mocap") == Some("true") {
                self.left_out
                    .push(format!("the motion of the mocap body `{}`, which is fixed here", self.all[number].name));
            }
            if attributes.number(element, "", "gravcomp")?.unwrap_or(0.0) != 0.0 {
                self.left_out.push(format!("the compensation of gravity of body `{}`", self.all[number].name));
            }
            let inner = self.content(attributes, xml, element, number, &frame, &class)?;
            let own = &mut self.all[number];
            own.unknown_mass = own.has_shape_of_file.then_some(element);
            self.finish(attributes, xml, element, number)?;
            self.bodies(attributes, xml, inner)?;
        }
        Ok(())
    }

    /// Reads the content of a body or of a `frame` in it; returns the bodies in it.
    fn content(
        &mut self,
        attributes: &Attributes<'x>,
        xml: &'x Xml<'x>,
        element: &'x Element,
        number: usize,
        frame: &Frame,
        class: &str,
    ) -> Result<Vec<Inner<'x>>, Error> {
        let mut inner = Vec::new();
        for item in xml.children(element) {
            match item.name.as_str() {
                "body" => inner.push(Inner { element: item, frame: *frame, class: class.to_owned(), parent: number }),
                "frame" => {
                    let class = item.get("childclass").unwrap_or(class);
                    let outer = frame.then(&attributes.frame(item, class)?);
                    inner.extend(self.content(attributes, xml, item, number, &outer, class)?);
                }
                "joint" => self.joint(attributes, xml, item, number, frame, class)?,
                "freejoint" => return Err(not_plane(xml, item, "a free joint leaves the plane")),
                "geom" => self.geom(attributes, item, number, frame, class)?,
                "site" => {
                    let place = frame.point(attributes.vector(item, class, "pos")?.unwrap_or([0.0; 3]));
                    self.all[number].sites.push((item.get("name").unwrap_or("site").to_owned(), place));
                }
                "composite" | "flexcomp" | "replicate" | "attach" | "include" => {
                    let title = format!("`<{}>` cannot be read", item.name);
                    return Err(xml.error(
                        item,
                        "",
                        &title,
                        "save the compiled model as MJCF, in which it is written out",
                    ));
                }
                _ => {}
            }
        }
        Ok(inner)
    }

    fn joint(
        &mut self,
        attributes: &Attributes<'x>,
        xml: &'x Xml<'x>,
        item: &'x Element,
        number: usize,
        frame: &Frame,
        class: &str,
    ) -> Result<(), Error> {
        let is_slide = match attributes.get(item, class, "type").unwrap_or("hinge") {
            "hinge" => false,
            "slide" => true,
            kind @ ("ball" | "free") => return Err(not_plane(xml, item, &format!("a {kind} joint leaves the plane"))),
            _ => return Err(xml.error(item, "type", "this type of joint is not known", "write `hinge` or `slide`")),
        };
        if number == 0 {
            return Err(xml.error(item, "", "the world has no joints", "put the joint into a body"));
        }
        let axis = attributes.vector(item, class, "axis")?.unwrap_or([0.0, 0.0, 1.0]);
        if norm(axis) < 1e-12 {
            return Err(xml.error(item, "axis", "this axis is zero", "write the direction of the axis"));
        }
        let place = frame.point(attributes.vector(item, class, "pos")?.unwrap_or([0.0; 3]));
        let axis = frame.direction(axis);
        let span = xml.place(item, "axis");
        let joint = BodyJoint { element: item, class: class.to_owned(), is_slide, axis, place, span };
        self.all[number].joints.push(joint);
        Ok(())
    }

    fn geom(
        &mut self,
        attributes: &Attributes<'x>,
        item: &Element,
        number: usize,
        frame: &Frame,
        class: &str,
    ) -> Result<(), Error> {
        let touches = |name: &str| attributes.get(item, class, name).is_none_or(|bits| bits.trim() != "0");
        self.has_geoms |= touches("contype") || touches("conaffinity");
        // The world needs no mass.
        if number == 0 || self.inertia_from == InertiaFrom::Inertial {
            return Ok(());
        }
        if attributes.get(item, class, "shellinertia") == Some("true") {
            let own = &mut self.all[number];
            own.left_out.push(format!("that geoms of body `{}` are hollow: they are solid here", own.name));
        }
        match geom(attributes, item, class)? {
            Some(solid) => self.all[number].solids.push(solid.seen_from(frame)),
            None => {
                let kind = attributes.get(item, class, "type").unwrap_or("mesh").to_owned();
                let Body { name, left_out, has_shape_of_file, .. } = &mut self.all[number];
                *has_shape_of_file = true;
                left_out.push(format!("the mass of a {kind} of body `{name}`: write `mass`, `com` and `inertia`"));
            }
        }
        Ok(())
    }

    /// Replaces the masses of geoms by that of an element `inertial`.
    fn finish(
        &mut self,
        attributes: &Attributes<'x>,
        xml: &'x Xml<'x>,
        element: &'x Element,
        number: usize,
    ) -> Result<(), Error> {
        let given = xml.children(element).find(|child| child.name == "inertial");
        if let Some(given) = given.filter(|_| self.inertia_from != InertiaFrom::Geoms) {
            let own = &mut self.all[number];
            own.solids = vec![inertial(attributes, given)?.seen_from(&own.frame)];
            own.left_out.clear();
            own.unknown_mass = None;
        }
        Ok(())
    }

    /// The parts of bodies that could not be carried over.
    pub(super) fn left_out(&self) -> Vec<String> {
        self.left_out.iter().chain(self.all.iter().flat_map(|body| &body.left_out)).cloned().collect()
    }
}

/// A body that is still to be read, and the frame around it.
struct Inner<'x> {
    element: &'x Element,
    frame: Frame,
    class: String,
    parent: usize,
}

impl Body<'_> {
    fn new(name: &str, frame: Frame, parent: usize) -> Self {
        let name = name.to_owned();
        let (joints, solids, left_out, sites) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        let (has_shape_of_file, unknown_mass) = (false, None);
        Self { name, frame, parent, joints, solids, left_out, has_shape_of_file, unknown_mass, sites }
    }
}

/// The error of a joint that is not in a plane.
fn not_plane(xml: &Xml, element: &Element, title: &str) -> Error {
    xml.error(element, "type", title, PLANE_HELP)
}

#[cfg(test)]
mod tests {
    use super::super::super::imported;

    #[test]
    fn bodies_without_names_keep_their_own_notes() {
        let mesh = "<geom type=\"mesh\" mesh=\"m\"/>";
        let body = |content: &str| format!("<body><joint axis=\"0 1 0\"/>{content}</body>");
        let inertial = "<inertial pos=\"0 0 0\" mass=\"1\" diaginertia=\"1 1 1\"/>";
        let bodies = [body(&format!("{mesh}<geom size=\"0.1\"/>")), body(&format!("{mesh}{inertial}"))].concat();
        let scene = imported(&format!("<mujoco><worldbody>{bodies}</worldbody></mujoco>")).expect("a scene");
        assert_eq!(scene.matches("the mass of a mesh of body `body`").count(), 1, "{scene}");
    }
}
