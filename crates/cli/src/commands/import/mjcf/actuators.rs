//! Actuators of joints: forces with a control, which is a parameter of the scene.

use super::super::linkage::{ImportedLinkage, Load, Parameter};
use super::super::names::Names;
use super::super::numbers::{factor, signed_term};
use super::attributes::{Attributes, MAIN};
use super::links::{ImportedJoint, Links};
use super::xml::Element;
use crate::error::Error;

/// Adds the actuators that act on joints. The others are noted.
pub(super) fn add(
    attributes: &Attributes,
    links: &Links,
    linkage: &mut ImportedLinkage,
    names: &mut Names,
) -> Result<(), Error> {
    for element in attributes.xml.section("actuator") {
        let title = element.get("name").unwrap_or(element.name.as_str()).to_owned();
        let joint = attributes.get(element, MAIN, "joint").or(attributes.get(element, MAIN, "jointinparent"));
        if let Some(name) = joint.filter(|name| links.joints.iter().all(|joint| joint.name != *name)) {
            let title = format!("`{name}` is not a joint of the model");
            let help = "write the name of one that is there";
            return Err(attributes.xml.error(element, "joint", &title, help));
        }
        let joint = joint.and_then(|name| links.joints.iter().find(|joint| joint.name == name));
        match (joint, Law::read(attributes, element)?) {
            (Some(joint), Some(law)) => actuator(attributes, element, joint, &law, &title, linkage, names)?,
            _ => linkage.left_out.push(format!("the actuator `{title}` ({})", element.name)),
        }
        for range in ["ctrlrange", "forcerange", "inheritrange"] {
            if attributes.get(element, MAIN, range).is_some() {
                linkage.left_out.push(format!("the {range} of actuator `{title}`"));
            }
        }
    }
    Ok(())
}

/// The law of an actuator. All kinds of actuators set the parameters of `general`.
#[derive(Clone)]
struct Law {
    /// The kind of actuator that has set the parameters last.
    kind: String,
    gain: f64,
    /// The force without control: constant, by length and by velocity.
    bias: [f64; 3],
    dyntype: String,
    gaintype: String,
    biastype: String,
}

impl Law {
    /// The law of an actuator, if a scene can have it.
    fn read(attributes: &Attributes, element: &Element) -> Result<Option<Self>, Error> {
        let mut law = Self::new("general");
        for default in attributes.actuator_defaults(element) {
            law.apply(attributes, default)?;
        }
        law.apply(attributes, element)?;
        Ok(law.is_plain().then_some(law))
    }

    fn new(kind: &str) -> Self {
        Self {
            kind: kind.to_owned(),
            gain: 1.0,
            bias: [0.0; 3],
            dyntype: "none".to_owned(),
            gaintype: "fixed".to_owned(),
            biastype: "none".to_owned(),
        }
    }

    /// Sets what an element gives: an actuator, or one of its defaults.
    fn apply(&mut self, attributes: &Attributes, element: &Element) -> Result<(), Error> {
        let kind = element.name.as_str();
        // MuJoCo passes the parameters of `general` to all kinds, those of another kind to itself and to `general`.
        let is_passed = kind == "general" || self.kind == kind || self.kind == "general" && self.gaintype == "fixed";
        if !is_passed {
            *self = Self::new(kind);
        }
        let numbers = |name: &str| attributes.own_numbers(element, name);
        let number = |name: &str| Ok::<_, Error>(numbers(name)?.map(|numbers| numbers[0]));
        match kind {
            "general" => {
                self.gain = number("gainprm")?.unwrap_or(self.gain);
                let bias = numbers("biasprm")?.unwrap_or_default();
                self.bias.iter_mut().zip(bias).for_each(|(own, value)| *own = value);
                let types = [&mut self.dyntype, &mut self.gaintype, &mut self.biastype];
                for (own, name) in types.into_iter().zip(["dyntype", "gaintype", "biastype"]) {
                    element.get(name).into_iter().for_each(|value| *own = value.to_owned());
                }
            }
            "motor" => *self = Self::new(kind),
            "position" => {
                let dyntype = if self.kind == kind { self.dyntype.clone() } else { "none".to_owned() };
                let kp = number("kp")?.unwrap_or(self.gain);
                let damping = number("dampratio")?.or(number("kv")?.map(|kv| -kv)).unwrap_or(self.bias[2]);
                *self = Self { gain: kp, bias: [0.0, -kp, damping], ..Self::affine(kind) };
                self.dyntype = match number("timeconst")? {
                    None => dyntype,
                    Some(0.0) => "none".to_owned(),
                    Some(_) => "filterexact".to_owned(),
                };
            }
            "velocity" => {
                let kv = number("kv")?.unwrap_or(self.gain);
                *self = Self { gain: kv, bias: [0.0, 0.0, -kv], ..Self::affine(kind) };
            }
            // A scene has no actuators of other kinds.
            _ => self.gaintype = kind.to_owned(),
        }
        self.kind = kind.to_owned();
        Ok(())
    }

    fn affine(kind: &str) -> Self {
        Self { biastype: "affine".to_owned(), ..Self::new(kind) }
    }

    fn is_plain(&self) -> bool {
        // MuJoCo takes a positive number here as a ratio of damping, which depends on the mass.
        let has_damping_ratio = self.biastype == "affine" && self.gain == -self.bias[1] && self.bias[2] > 0.0;
        self.dyntype == "none"
            && self.gaintype == "fixed"
            && ["none", "affine"].contains(&self.biastype.as_str())
            && !has_damping_ratio
    }

    /// The unit of the control.
    fn unit(&self, is_slide: bool) -> &'static str {
        match (self.kind.as_str(), is_slide) {
            ("motor", false) => "N m",
            ("motor", true) => "N",
            ("position", false) => "rad",
            ("position", true) => "m",
            ("velocity", false) => "rad/s",
            ("velocity", true) => "m/s",
            _ => "",
        }
    }
}

/// Adds an actuator as a force along its joint.
fn actuator(
    attributes: &Attributes,
    element: &Element,
    joint: &ImportedJoint,
    law: &Law,
    title: &str,
    linkage: &mut ImportedLinkage,
    names: &mut Names,
) -> Result<(), Error> {
    let gear = attributes.numbers(element, MAIN, "gear")?.map_or(1.0, |gear| gear[0]);
    let control = names.unique(&format!("ctrl_{title}"), "ctrl");
    let name = names.unique(title, "actuator");
    let [constant, by_length, by_velocity] = if law.biastype == "affine" { law.bias } else { [0.0; 3] };
    // The length of the actuator is that of the joint times the gear.
    let mut force = format!("{}*{control}", factor(gear * law.gain));
    let constant = gear * constant + gear * gear * by_length * joint.reference;
    for (value, of) in [(gear * gear * by_length, "s"), (gear * gear * by_velocity, "s_dot")] {
        if value != 0.0 {
            force.push_str(&format!("{}*{of}", signed_term(value)));
        }
    }
    force.push_str(&signed_term(constant));
    let doc = format!("control of the {} {title}, of joint {}", element.name, linkage.joints[joint.number].name);
    let unit = law.unit(joint.is_slide);
    linkage.parameters.push(Parameter { name: control, value: 0.0, unit, doc });
    let along = joint.displacement(linkage);
    linkage.loads.push(Load::Along { name, along, keys: format!("force = '{force}'") });
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::super::super::imported;

    /// The force of an actuator with defaults; `None` where it is left out.
    fn force(defaults: &str, actuator: &str) -> Option<String> {
        let text = format!(
            "<mujoco><default>{defaults}</default><worldbody><body><joint name=\"j\" axis=\"0 1 0\"/>\
             <geom size=\"0.1\"/></body></worldbody>\
             <actuator><{actuator} name=\"a\" joint=\"j\"/></actuator></mujoco>"
        );
        let scene = imported(&text).expect("a scene");
        let begin = scene.find("force = '")? + "force = '".len();
        scene[begin..].split('\'').next().map(str::to_owned)
    }

    /// Gains and biases are those of MuJoCo 4.0.0.
    #[test]
    fn all_actuators_share_one_default() {
        let affine = "<general gainprm=\"5\" biastype=\"affine\" biasprm=\"1 2 -3\"/>";
        for (defaults, actuator, expected) in [
            ("<general gear=\"3\"/>", "motor", "3*ctrl_a"),
            ("<motor gear=\"3\"/>", "position", "3*ctrl_a - 9*s"),
            ("<position kp=\"50\"/>", "position", "50*ctrl_a - 50*s"),
            ("<position kp=\"50\"/>", "general", "50*ctrl_a - 50*s"),
            ("<position kp=\"50\"/>", "motor", "1*ctrl_a"),
            ("<position kp=\"50\"/>", "velocity", "1*ctrl_a - 1*s_dot"),
            ("<position kp=\"50\" kv=\"3\"/>", "position kp=\"2\"", "2*ctrl_a - 2*s - 3*s_dot"),
            ("<velocity kv=\"7\"/>", "general", "7*ctrl_a - 7*s_dot"),
            ("<velocity kv=\"7\"/>", "position", "1*ctrl_a - 1*s"),
            ("<velocity kv=\"7\"/><general gear=\"3\"/>", "position", "21*ctrl_a - 63*s - 63*s_dot"),
            ("<velocity kv=\"4\"/>", "general biasprm=\"1 2\"", "4*ctrl_a + 2*s - 4*s_dot + 1"),
            (affine, "position", "5*ctrl_a - 5*s - 3*s_dot"),
            (affine, "velocity", "5*ctrl_a - 5*s_dot"),
            (affine, "motor", "1*ctrl_a"),
            ("<general dyntype=\"filter\" gainprm=\"5\"/>", "position", "5*ctrl_a - 5*s"),
            ("<general gaintype=\"affine\" gainprm=\"5\"/>", "position", "1*ctrl_a - 1*s"),
            ("<position kp=\"5\"/><motor gear=\"2\"/>", "general", "2*ctrl_a"),
        ] {
            assert_eq!(force(defaults, actuator).as_deref(), Some(expected), "{defaults} {actuator}");
        }
    }

    #[test]
    fn classes_begin_with_the_actuators_around_them() {
        let defaults = "<position kp=\"50\"/><default class=\"c\"><general gear=\"2\"/></default>";
        assert_eq!(force(defaults, "position class=\"c\"").as_deref(), Some("100*ctrl_a - 200*s"));
        assert_eq!(force(defaults, "position").as_deref(), Some("50*ctrl_a - 50*s"));
    }

    #[test]
    fn laws_that_no_scene_has_are_left_out() {
        for (defaults, actuator) in [
            ("<position kp=\"50\" dampratio=\"1\"/>", "position"),
            ("<position kp=\"50\" timeconst=\"0.1\"/>", "position"),
            ("<position kp=\"50\" dampratio=\"1\"/>", "general"),
            ("<general dyntype=\"filter\"/>", "general"),
            ("<intvelocity kp=\"6\"/>", "general"),
            ("", "muscle"),
        ] {
            assert_eq!(force(defaults, actuator), None, "{defaults} {actuator}");
        }
    }
}
