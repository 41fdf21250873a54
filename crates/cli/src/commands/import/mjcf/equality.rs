//! Equality constraints: pins, welds and couplings of joints.

use super::super::linkage::{Constraint, End, ImportedLinkage, Joint, Kind};
use super::super::names::Names;
use super::super::numbers::wrap_angle;
use super::super::plane::Plane;
use super::attributes::{Attributes, MAIN};
use super::bodies::Bodies;
use super::links::{Links, polynomial};
use super::repetition::repeats;
use super::xml::Element;
use crate::error::Error;

/// Adds the equality constraints of a model.
pub(super) fn add(
    attributes: &Attributes,
    bodies: &Bodies,
    links: &Links,
    plane: &Plane,
    linkage: &mut ImportedLinkage,
    names: &mut Names,
) -> Result<(), Error> {
    let mut flags = attributes.xml.section("option").filter(|element| element.name == "flag");
    let is_disabled = flags.any(|flag| ["equality", "constraint"].iter().any(|name| flag.get(name) == Some("disable")));
    for element in attributes.xml.section("equality") {
        let name = element.get("name").unwrap_or("equality").to_owned();
        if is_disabled || !attributes.is_active(element) {
            linkage.left_out.push(format!("the equality `{name}`, which is not active"));
            continue;
        }
        match element.name.as_str() {
            "connect" | "weld" => {
                let joint = pin(attributes, bodies, links, plane, element, linkage)?;
                if repeats(links, &joint, &name, linkage, names) {
                    continue;
                }
                let name = names.unique(&name, "joint");
                linkage.joints.push(Joint { model_name: name.clone(), name, ..joint });
            }
            "joint" => couple(attributes, links, element, linkage, names)?,
            other => {
                linkage.left_out.push(format!("the equality `{name}` of a {other}, which lets the linkage move freely"))
            }
        }
    }
    Ok(())
}

/// Makes a pin or a weld between two bodies, or two sites.
fn pin(
    attributes: &Attributes,
    bodies: &Bodies,
    links: &Links,
    plane: &Plane,
    element: &Element,
    linkage: &ImportedLinkage,
) -> Result<Joint, Error> {
    let xml = attributes.xml;
    let unknown = |attribute: &str, what: &str| {
        xml.error(
            element,
            attribute,
            &format!("`{attribute}` is not a {what} of the model"),
            "write the name of one that is there",
        )
    };
    let get = |attribute: &str| attributes.get(element, MAIN, attribute);
    let places = if let (Some(first), Some(second)) = (get("site1"), get("site2")) {
        let first = links.link_of_site(bodies, first).ok_or_else(|| unknown("site1", "site"))?;
        [first, links.link_of_site(bodies, second).ok_or_else(|| unknown("site2", "site"))?]
    } else {
        let first = get("body1").ok_or_else(|| unknown("body1", "body"))?;
        let (body, first) = links.link_of_body(bodies, Some(first)).ok_or_else(|| unknown("body1", "body"))?;
        let (_, second) = links.link_of_body(bodies, get("body2")).ok_or_else(|| unknown("body2", "body"))?;
        let anchor = attributes.vector(element, MAIN, "anchor")?.unwrap_or([0.0; 3]);
        let place = bodies.all[body].frame.point(anchor);
        [(first, place), (second, place)]
    };
    if places[0].0 == places[1].0 {
        let title = "this equality joins bodies that do not move against each other";
        return Err(xml.error(element, "body2", title, "join two bodies that joints let move"));
    }
    let relative = attributes.numbers(element, MAIN, "relpose")?;
    if relative.is_some_and(|pose| pose.iter().skip(3).any(|part| *part != 0.0)) {
        let help = "leave `relpose` out, and give the bodies the pose in which they are held";
        return Err(xml.error(element, "relpose", "a pose that differs from that of the bodies cannot be read", help));
    }
    let mut ends = places.map(|(link, place)| End { link, at: linkage.local(link, plane.project(place)) });
    if ends[0].link == 0 {
        ends.swap(0, 1);
    }
    let kind = if element.name == "weld" {
        let [a, b] = ends.map(|end| linkage.links[end.link].angle);
        Kind::Weld { rotation: wrap_angle(a - b) }
    } else {
        Kind::Pin
    };
    Ok(Joint { name: String::new(), model_name: String::new(), kind, ends: ends.to_vec(), drive: None })
}

/// Adds a constraint: the displacement of a joint is a polynomial of that of another one.
fn couple(
    attributes: &Attributes,
    links: &Links,
    element: &Element,
    linkage: &mut ImportedLinkage,
    names: &mut Names,
) -> Result<(), Error> {
    let xml = attributes.xml;
    let find = |attribute: &str| {
        let name = attributes.get(element, MAIN, attribute)?;
        Some(links.joints.iter().find(|joint| joint.name == name && !name.is_empty()).ok_or_else(|| {
            xml.error(
                element,
                attribute,
                &format!("`{attribute}` is not a joint of the model"),
                "write the name of one that is there",
            )
        }))
    };
    let first =
        find("joint1").unwrap_or_else(|| Err(xml.error(element, "joint1", "`joint1` is missing", "name a joint")))?;
    let second = find("joint2").transpose()?;
    let mut coefficients = [0.0, 1.0, 0.0, 0.0, 0.0];
    let given = attributes.numbers(element, MAIN, "polycoef")?.unwrap_or_default();
    coefficients.iter_mut().zip(given).for_each(|(own, value)| *own = value);
    let mut gradient = vec![(first.number, first.axis_sign)];
    let side = match second {
        Some(second) => {
            gradient.push((second.number, -coefficients[1] * second.axis_sign));
            polynomial(&coefficients, &second.displacement(linkage))
        }
        None => polynomial(&coefficients[..1], ""),
    };
    let residual = format!("{} - ({side})", first.displacement(linkage));
    let unit = if first.is_slide { "m" } else { "rad" };
    let name = names.unique(element.get("name").unwrap_or("coupling"), "coupling");
    linkage.constraints.push(Constraint { name, residual, unit, gradient });
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::super::super::imported;

    /// The residual of a coupling of two hinges.
    fn residual(polycoef: &str) -> String {
        let body = |name: &str| {
            format!("<body name=\"{name}\"><joint name=\"{name}\" axis=\"0 -1 0\"/><geom size=\"0.1\"/></body>")
        };
        let text = format!(
            "<mujoco><worldbody>{}{}</worldbody>\
             <equality><joint joint1=\"a\" joint2=\"b\" {polycoef}/></equality></mujoco>",
            body("a"),
            body("b")
        );
        let scene = imported(&text).expect("a scene");
        let begin = scene.find("residual = '").expect("a constraint") + "residual = '".len();
        scene[begin..].split('\'').next().expect("a formula").to_owned()
    }

    #[test]
    fn equalities_that_are_not_active_are_left_out() {
        let body = "<worldbody><body><joint name=\"j\" axis=\"0 1 0\"/><geom size=\"0.1\"/></body></worldbody>";
        let note = "# - the equality `e`, which is not active";
        for (settings, attributes) in [
            ("", "active=\"false\""),
            ("<default><equality active=\"false\"/></default>", ""),
            ("<default><default class=\"c\"><equality active=\"false\"/></default></default>", "class=\"c\""),
            ("<option><flag equality=\"disable\"/></option>", ""),
        ] {
            let equality = format!("<equality><joint name=\"e\" joint1=\"j\" {attributes}/></equality>");
            let scene = imported(&format!("<mujoco>{settings}{body}{equality}</mujoco>")).expect("a scene");
            assert!(scene.contains(note) && !scene.contains("[constraints]"), "{scene}");
        }
    }

    #[test]
    fn missing_coefficients_are_those_of_mujoco() {
        assert_eq!(residual(""), "phi_a - (1*(phi_b))");
        assert_eq!(residual("polycoef=\"0.5\""), "phi_a - (1*(phi_b) + 0.5)");
        assert_eq!(residual("polycoef=\"1 2 3\""), "phi_a - (2*(phi_b) + 3*(phi_b)^2 + 1)");
    }
}
