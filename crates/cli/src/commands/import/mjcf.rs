//! MJCF, the models of MuJoCo: nested bodies with hinges and slides, equality constraints, springs, actuators.

mod actuators;
mod attributes;
mod bodies;
mod equality;
mod inertias;
mod known;
mod links;
mod repetition;
mod shape;
mod springs;
mod xml;

use super::linkage::ImportedLinkage;
use super::names::Names;
use super::plane::{Plane, Vector};
use super::source::Source;
use crate::error::Error;
use attributes::{Attributes, MAIN};
use bodies::Bodies;
use links::Links;
use xml::Xml;

/// The end time of the run. Models do not have one.
const END_TIME: f64 = 2.0;

/// Whether a text is XML.
pub(super) fn recognizes(text: &str) -> bool {
    text.trim_start().starts_with('<')
}

/// Reads a model.
pub(super) fn read(source: &Source) -> Result<ImportedLinkage, Error> {
    let xml = Xml::read(source)?;
    let root = xml.root();
    if root.name != "mujoco" {
        let title = format!("`<{}>` is not a model of MuJoCo", root.name);
        let help = "import a file with the element `<mujoco>`; MuJoCo saves other models, as URDF, in this form";
        return Err(xml.error(root, "", &title, help));
    }
    if let Some(include) = xml.children(root).find(|element| element.name == "include") {
        let help = "save the compiled model as MJCF, which is one file";
        return Err(xml.error(include, "file", "this model has a part in another file", help));
    }
    let attributes = Attributes::read(&xml)?;
    known::check(&attributes, &xml)?;
    let bodies = Bodies::read(&attributes, &xml)?;
    let mut linkage = ImportedLinkage::new("a model of MuJoCo");
    let mut names = Names::new();
    let plane = plane(&bodies);
    linkage.left_out = bodies.left_out();
    let links = Links::add(&attributes, &bodies, &plane, &mut linkage, &mut names)?;
    if linkage.links.len() == 1 {
        return Err(source.whole("no body of the model moves", "import a model with joints"));
    }
    equality::add(&attributes, &bodies, &links, &plane, &mut linkage, &mut names)?;
    actuators::add(&attributes, &links, &mut linkage, &mut names)?;
    options(&attributes, &xml, &plane, &mut linkage)?;
    linkage.add_joint_forces(&mut names);
    remarks(&xml, &bodies, &plane, &mut linkage);
    if links.deviation > 1e-9 {
        let deviation = format!("{:.1e}", links.deviation);
        let text =
            format!("Axes of the model differ from those of the plane by up to {deviation} rad; here they are exact.");
        linkage.remarks.push(text);
    }
    Ok(linkage)
}

/// The plane in which the model moves: across the first hinge, or that of the slides.
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
    let axis = super::plane::unit(hinge.or_else(|| across(&slides)).unwrap_or([0.0, 0.0, 1.0]));
    // An axis that differs from one of the world by the rounding of 6 digits is that one.
    let near =
        super::plane::IDENTITY.into_iter().find(|own| super::plane::norm(super::plane::cross(*own, axis)) < 1e-5);
    Plane::across(near.unwrap_or(axis))
}

/// Reads the time step and gravity.
fn options(attributes: &Attributes, xml: &Xml, plane: &Plane, linkage: &mut ImportedLinkage) -> Result<(), Error> {
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
                    "this is not a time step",
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
                if ["constraint", "spring", "damper", "passive", "actuation"].contains(&name.as_str()) {
                    linkage.left_out.push(format!("the flag {name}=\"{value}\""));
                }
            }
        }
    }
    linkage.add_gravity(gravity, plane);
    Ok(())
}

/// Adds remarks, and notes what the importer does not read.
fn remarks(xml: &Xml, bodies: &Bodies, plane: &Plane, linkage: &mut ImportedLinkage) {
    linkage.remarks.push(format!("The axes of the plane, in the world: {}.", plane.axes_text()));
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
    for (section, what) in [
        ("sensor", "the sensors"),
        ("custom", "the custom data"),
        ("extension", "the extensions, which are plugins"),
        ("contact", "the settings of contact"),
    ] {
        if xml.section(section).next().is_some() {
            linkage.left_out.push(what.to_owned());
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

#[cfg(test)]
mod tests {
    use super::super::imported;

    fn model(bodies: &str, rest: &str) -> String {
        format!("<mujoco><worldbody>{bodies}</worldbody>{rest}</mujoco>")
    }

    /// The value of a key in the line of an entry.
    fn number(scene: &str, entry: &str, key: &str) -> f64 {
        let line = scene.lines().find(|line| line.split_whitespace().next() == Some(entry)).expect("an entry");
        let rest = &line[line.find(&format!("{key} = ")).expect("a key") + key.len() + 3..];
        rest[..rest.find([',', ' ']).expect("an end")].parse().expect("a number")
    }

    #[test]
    fn geoms_have_the_masses_that_mujoco_gives_them() {
        let arm = include_str!("../../../../../tests/import/arm.xml");
        let scene = imported(arm).expect("a scene");
        // From MuJoCo 4.0.0; the armature of the shoulder is part of the first inertia.
        let expected = [
            ("upper", 3.732212072464675, 0.06122298064203948 + 0.01),
            ("lower", 2.64814150222053, 0.04035094729171653),
            ("rail", 0.6, 0.02),
        ];
        for (link, mass, inertia) in expected {
            assert!((number(&scene, link, "mass") / mass - 1.0).abs() < 1e-14, "{scene}");
            assert!((number(&scene, link, "inertia") / inertia - 1.0).abs() < 1e-13, "{scene}");
        }
        assert!(scene.contains("shoulder = { revolute = [\"upper\", \"ground\"] }"), "{scene}");
        assert!(scene.contains("force = '4*ctrl_p1 - 4*s - 0.3*s_dot - 1.0471975511965976'"), "{scene}");
    }

    #[test]
    fn hinges_of_both_senses_turn_their_springs() {
        let body = |axis: &str| {
            let joint = format!("<joint name=\"j\" axis=\"{axis}\" stiffness=\"2\" springref=\"90\" damping=\"0.1\"/>");
            model(&format!("<body name=\"b\">{joint}<geom size=\"0.1\"/></body>"), "")
        };
        // The plane x-z is seen along y.
        let spring = "spring = 2, rest = '1.5707963267948966 rad', damper = 0.1 }";
        for (axis, along) in [("0 -1 0", "phi_b"), ("0 1 0", "-phi_b"), ("0 0 1", "phi_b"), ("-3 0 0", "-phi_b")] {
            let scene = imported(&body(axis)).expect("a scene");
            assert!(scene.contains(&format!("passive_j = {{ along = '{along}', {spring}")), "{axis}: {scene}");
        }
    }

    #[test]
    fn defaults_frames_and_static_bodies_are_resolved() {
        let text = model(
            "<body name=\"a\" childclass=\"thin\"><joint name=\"j\"/><frame pos=\"0 1 0\"><geom/></frame>\
             <body pos=\"1 0 0\"><geom class=\"main\" size=\"0.2\" mass=\"3\"/></body>\
             <site name=\"tip\" pos=\"2 0 0\"/></body>",
            "<default><geom size=\"0.1\" mass=\"1\"/>\
             <default class=\"thin\"><joint damping=\"4\"/></default></default>",
        );
        let scene = imported(&text).expect("a scene");
        assert!(scene.contains("mass = 4, com = [0.75, 0.25], "), "{scene}");
        // Spheres of 0.1 and 0.2 m, at a distance of the square root of 2.
        let inertia = 0.4 * 0.01 + 0.4 * 3.0 * 0.04 + 0.75 * 2.0;
        assert!((number(&scene, "a", "inertia") / inertia - 1.0).abs() < 1e-14, "{scene}");
        assert!(scene.contains("damper = 4") && scene.contains("x_tip = { value = 'tip.x', unit = \"m\" }"), "{scene}");
    }

    #[test]
    fn what_is_left_out_is_listed() {
        let text = model(
            "<body name=\"a\"><joint name=\"j\" axis=\"0 1 0\" range=\"-90 90\" frictionloss=\"0.1\"/>\
             <geom type=\"mesh\" mesh=\"m\"/>\
             <geom size=\"0.1\"/></body>",
            "<actuator><muscle name=\"m\" joint=\"j\"/></actuator><tendon><fixed name=\"t\"/></tendon>\
             <equality><tendon name=\"e\" tendon1=\"t\"/></equality>",
        );
        let scene = imported(&text).expect("a scene");
        for item in [
            "the range of joint `j`",
            "the dry friction of joint `j`",
            "the mass of a mesh of body `a`",
            "the actuator `m` (muscle)",
            "the tendon `t`",
            "the equality `e` of a tendon",
            "contact between geoms",
        ] {
            assert!(scene.contains(&format!("# - {item}")), "{item}: {scene}");
        }
    }

    #[test]
    fn errors_name_their_attribute() {
        let hinge = "<joint axis=\"0 1 0\"/><geom size=\"0.1\"/>";
        let body = |content: &str| model(&format!("<body name=\"a\">{hinge}<body>{content}</body></body>"), "");
        for (text, said) in [
            (body("<joint axis=\"1 0 0\"/>"), "this hinge turns out of the plane"),
            (body("<joint type=\"slide\" axis=\"0 1 0\"/>"), "this slide leaves the plane"),
            (body("<joint type=\"ball\"/>"), "a ball joint leaves the plane"),
            (body("<freejoint/>"), "a free joint leaves the plane"),
            (body("<geom size=\"1e400\"/>"), "not a list of finite numbers"),
            (body("<geom/>"), "this sphere has no size"),
            (body("<inertial mass=\"-1\" pos=\"0 0 0\"/>"), "this mass is negative"),
            (body("<joint axis=\"0 0 0\"/>"), "this axis is zero"),
            (body("<site pos=\"1e300 0 0\"/>"), "`pos` has a number that is too large"),
            (body("<joint axis=\"0 1 0\"/><geom type=\"mesh\" mesh=\"m\"/>"), "is that of a mesh or a height field"),
            (model("", "<actuator><motor joint=\"x\"/></actuator>"), "no body of the model moves"),
            (body("<site pos=\"1 2\"/>"), "`pos` has three numbers"),
            (body("<replicate count=\"3\"/>"), "`<replicate>` cannot be read"),
            (model("<body><geom size=\"1\"/></body>", ""), "no body of the model moves"),
            ("<robot/>".to_owned(), "is not a model of MuJoCo"),
            ("<mujoco><worldbody>".to_owned(), "`<worldbody>` is not closed"),
            ("<mujoco><a></b></mujoco>".to_owned(), "this is not valid XML"),
            (format!("<mujoco>{}", "<body>".repeat(100_000)), "nested too deeply"),
        ] {
            let error = imported(&text).expect_err("no scene");
            assert!(error.contains(said), "{error}");
        }
    }
}
