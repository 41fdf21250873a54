//! Actuators of joints: forces with a control, which is a parameter of the scene.

use super::super::linkage::{Linkage, Load, Parameter};
use super::super::names::Names;
use super::super::numbers::{factor, further};
use super::attributes::{Attributes, MAIN};
use super::links::{Links, Moved};
use super::xml::Element;
use crate::error::Error;

/// Adds the actuators that act on joints. The others are noted.
pub(super) fn add(
    attributes: &Attributes,
    links: &Links,
    linkage: &mut Linkage,
    names: &mut Names,
) -> Result<(), Error> {
    for element in attributes.xml.section("actuator") {
        let title = element.get("name").unwrap_or(element.name.as_str()).to_owned();
        let joint = attributes.get(element, MAIN, "joint").or(attributes.get(element, MAIN, "jointinparent"));
        let moved = joint.and_then(|name| links.joints.iter().find(|joint| joint.name == name));
        match (moved, law(attributes, element)?) {
            (Some(moved), Some(law)) => actuator(attributes, element, moved, &law, &title, linkage, names)?,
            _ => linkage.left_out.push(format!("the actuator `{title}` ({})", element.name)),
        }
        for range in ["ctrlrange", "forcerange"] {
            if attributes.get(element, MAIN, range).is_some() {
                linkage.left_out.push(format!("the {range} of actuator `{title}`"));
            }
        }
    }
    Ok(())
}

/// The force of an actuator: the gain times the control, and a bias with parts by length and velocity.
struct Law {
    gain: f64,
    bias: [f64; 3],
    /// The unit of the control, for a hinge and for a slide.
    unit: [&'static str; 2],
}

fn law(attributes: &Attributes, element: &Element) -> Result<Option<Law>, Error> {
    let get = |name: &str| attributes.get(element, MAIN, name);
    let number =
        |name: &str, otherwise: f64| Ok::<_, Error>(attributes.number(element, MAIN, name)?.unwrap_or(otherwise));
    let first = |name: &str| Ok::<_, Error>(attributes.numbers(element, MAIN, name)?.unwrap_or_default());
    Ok(match element.name.as_str() {
        "motor" => Some(Law { gain: 1.0, bias: [0.0; 3], unit: ["N m", "N"] }),
        "position" if get("dampratio").is_none() && number("timeconst", 0.0)? == 0.0 => {
            let kp = number("kp", 1.0)?;
            Some(Law { gain: kp, bias: [0.0, -kp, -number("kv", 0.0)?], unit: ["rad", "m"] })
        }
        "velocity" => {
            let kv = number("kv", 1.0)?;
            Some(Law { gain: kv, bias: [0.0, 0.0, -kv], unit: ["rad/s", "m/s"] })
        }
        "general" => {
            let gain = first("gainprm")?.first().copied().unwrap_or(1.0);
            let bias = first("biasprm")?;
            let is_plain =
                matches!(get("dyntype"), None | Some("none")) && matches!(get("gaintype"), None | Some("fixed"));
            let part = |i: usize| bias.get(i).copied().unwrap_or(0.0);
            match get("biastype") {
                None | Some("none") if is_plain => Some(Law { gain, bias: [0.0; 3], unit: ["", ""] }),
                Some("affine") if is_plain => Some(Law { gain, bias: [part(0), part(1), part(2)], unit: ["", ""] }),
                _ => None,
            }
        }
        _ => None,
    })
}

fn actuator(
    attributes: &Attributes,
    element: &Element,
    moved: &Moved,
    law: &Law,
    title: &str,
    linkage: &mut Linkage,
    names: &mut Names,
) -> Result<(), Error> {
    let gear = attributes.numbers(element, MAIN, "gear")?.map_or(1.0, |gear| gear[0]);
    let control = names.unique(&format!("ctrl_{title}"), "ctrl");
    let name = names.unique(title, "actuator");
    let [constant, by_length, by_velocity] = law.bias;
    // The length of the actuator is that of the joint times the gear.
    let mut force = format!("{}*{control}", factor(gear * law.gain));
    let constant = gear * constant + gear * gear * by_length * moved.reference;
    for (value, of) in [(gear * gear * by_length, "s"), (gear * gear * by_velocity, "s_dot")] {
        if value != 0.0 {
            force.push_str(&format!("{}*{of}", further(value)));
        }
    }
    force.push_str(&further(constant));
    let doc = format!("control of the {} {title}, of joint {}", element.name, linkage.joints[moved.number].name);
    let unit = law.unit[usize::from(moved.is_slide)];
    linkage.parameters.push(Parameter { name: control, value: 0.0, unit, doc });
    let along = moved.displacement(linkage);
    linkage.loads.push(Load::Along { name, along, keys: format!("force = '{force}'") });
    Ok(())
}
