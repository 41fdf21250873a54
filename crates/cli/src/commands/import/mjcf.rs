//! MJCF, the models of MuJoCo: nested bodies with hinges and slides, equality constraints, springs, actuators.

mod actuators;
mod attributes;
mod bodies;
mod equality;
mod links;
mod shape;
mod xml;

use super::linkage::{Linkage, Load};
use super::names::Names;
use super::numbers::shortest;
use super::plane::{Plane, Vector};
use super::source::Source;
use crate::error::Error;
use attributes::{Attributes, MAIN};
use bodies::Bodies;
use links::Links;
use xml::Xml;

/// The end of the run, which models do not have.
const END_TIME: f64 = 2.0;

/// Whether a text is XML.
pub(super) fn is_of(text: &str) -> bool {
    text.trim_start().starts_with('<')
}

/// Reads a model.
pub(super) fn read(source: &Source) -> Result<Linkage, Error> {
    let xml = Xml::read(source)?;
    let root = xml.root();
    if root.name != "mujoco" {
        let title = format!("`<{}>` is no model of MuJoCo", root.name);
        let help = "import a file with the element `<mujoco>`; MuJoCo saves other models, as URDF, in this form";
        return Err(xml.error(root, "", &title, help));
    }
    if let Some(include) = xml.children(root).find(|element| element.name == "include") {
        let help = "save the compiled model as MJCF, which is one file";
        return Err(xml.error(include, "file", "this model has a part in another file", help));
    }
    let attributes = Attributes::read(&xml)?;
    let bodies = Bodies::read(&attributes, &xml)?;
    let mut linkage = Linkage::new("a model of MuJoCo");
    let mut names = Names::new();
    let plane = plane(&bodies);
    linkage.left_out.clone_from(&bodies.left_out);
    let links = Links::add(&attributes, &bodies, &plane, &mut linkage, &mut names)?;
    if linkage.links.len() == 1 {
        return Err(source.whole("no body of the model moves", "import a model with joints"));
    }
    equality::add(&attributes, &bodies, &links, &plane, &mut linkage, &mut names)?;
    actuators::add(&attributes, &links, &mut linkage, &mut names)?;
    options(&attributes, &xml, &plane, &mut linkage)?;
    forces(&mut linkage, &mut names);
    remarks(&xml, &bodies, &plane, &mut linkage);
    Ok(linkage)
}

/// The plane across the first hinge; without one, that of the slides.
fn plane(bodies: &Bodies) -> Plane {
    let joints = || bodies.all.iter().flat_map(|body| &body.joints);
    let hinge = joints().find(|joint| !joint.is_slide).map(|joint| joint.axis);
    let slides: Vec<Vector> = joints().filter(|joint| joint.is_slide).map(|joint| joint.axis).collect();
    let across = |slides: &[Vector]| {
        let first = *slides.first()?;
        let crossed =
            slides.iter().map(|other| super::plane::cross(first, *other)).find(|axis| super::plane::norm(*axis) > 1e-6);
        // One slide is drawn from the side.
        Some(crossed.unwrap_or_else(|| {
            let across = super::plane::cross(first, [0.0, 0.0, 1.0]);
            if super::plane::norm(across) > 1e-6 { across } else { [0.0, 1.0, 0.0] }
        }))
    };
    Plane::across(hinge.or_else(|| across(&slides)).unwrap_or([0.0, 0.0, 1.0]))
}

/// Time step and gravity.
fn options(attributes: &Attributes, xml: &Xml, plane: &Plane, linkage: &mut Linkage) -> Result<(), Error> {
    let mut gravity = [0.0, 0.0, -9.81];
    linkage.step = 0.002;
    linkage.end_time = END_TIME;
    for option in xml.children(xml.root()).filter(|element| element.name == "option") {
        gravity = attributes.vector(option, MAIN, "gravity")?.unwrap_or(gravity);
        if let Some(step) = attributes.number(option, MAIN, "timestep")? {
            if !(step > 0.0 && step < END_TIME) {
                return Err(xml.error(
                    option,
                    "timestep",
                    "this is no time step",
                    "write a positive time of less than 2 s",
                ));
            }
            linkage.step = step;
        }
        for (name, what) in [("wind", "wind"), ("density", "density"), ("viscosity", "viscosity")] {
            if attributes
                .numbers(option, MAIN, name)?
                .is_some_and(|numbers| numbers.iter().any(|number| *number != 0.0))
            {
                linkage.left_out.push(format!("the {what} of the medium"));
            }
        }
        for flag in xml.children(option).filter(|element| element.name == "flag") {
            if flag.get("gravity") == Some("disable") {
                gravity = [0.0; 3];
            }
            for (name, value) in flag.attributes.iter().filter(|(_, value)| value == "disable") {
                if ["constraint", "equality", "spring", "damper", "passive", "actuation"].contains(&name.as_str()) {
                    linkage.left_out.push(format!("the flag {name}=\"{value}\""));
                }
            }
        }
    }
    let flat = plane.project(gravity);
    if flat != [0.0; 2] {
        linkage.loads.insert(0, Load::Gravity(flat));
    }
    if !plane.contains(gravity) && gravity != [0.0; 3] {
        linkage.left_out.push("gravity across the plane, which joints carry".to_owned());
    }
    Ok(())
}

/// Forces in pins and slides as outputs.
fn forces(linkage: &mut Linkage, names: &mut Names) {
    for joint in linkage.joints.iter().filter(|joint| joint.has_force()) {
        let name = names.unique(&format!("F_{}", joint.name), "force");
        linkage.outputs.push((name, format!("{{ joint = \"{}\" }}", joint.name)));
    }
}

fn remarks(xml: &Xml, bodies: &Bodies, plane: &Plane, linkage: &mut Linkage) {
    let axis = |vector: Vector| format!("({})", vector.map(shortest).join(", "));
    linkage.remarks.push(format!("The axes of the plane, in the world: x {}, y {}.", axis(plane.x), axis(plane.y)));
    linkage.remarks.push("Joints and equality constraints are exact here; those of MuJoCo yield.".to_owned());
    linkage.remarks.push("MJCF has no end of the run: 2 s are a choice.".to_owned());
    let flags = xml.section("option").filter(|element| element.name == "flag");
    if bodies.has_geoms && !flags.into_iter().any(|flag| flag.get("contact") == Some("disable")) {
        linkage.left_out.push("contact between geoms".to_owned());
    }
    for (section, what) in [("tendon", "tendon"), ("keyframe", "keyframe"), ("deformable", "deformable body")] {
        for element in xml.section(section) {
            let name = element.get("name").unwrap_or(&element.name);
            linkage.left_out.push(format!("the {what} `{name}`"));
        }
    }
    for compiler in xml.children(xml.root()).filter(|element| element.name == "compiler") {
        for name in ["settotalmass", "boundmass", "boundinertia", "inertiagrouprange"] {
            if let Some(value) = compiler.get(name) {
                linkage.left_out.push(format!("the setting {name}=\"{value}\" of the compiler"));
            }
        }
    }
}
