//! Springs, dampers and rotors of joints.

use super::super::linkage::{ImportedLinkage, Load, Mass};
use super::super::names::Names;
use super::super::numbers::shortest;
use super::attributes::Attributes;
use super::bodies::{Bodies, BodyJoint};
use super::links::{ImportedJoint, Links};
use crate::error::Error;

impl Links {
    /// Adds the springs, dampers and rotors of all joints, and notes what is left out of them.
    pub(super) fn passive(
        &self,
        attributes: &Attributes,
        bodies: &Bodies,
        linkage: &mut ImportedLinkage,
        names: &mut Names,
    ) -> Result<(), Error> {
        // Joints of links are in the order of the joints of bodies.
        let joints: Vec<&BodyJoint> = bodies.all.iter().flat_map(|body| &body.joints).collect();
        let mut armatures = Vec::new();
        for joint in &joints {
            armatures.push(first(attributes, joint, "armature")?);
        }
        let mut inertias: Option<Option<Vec<Option<f64>>>> = None;
        for (number, (joint, moved)) in joints.iter().zip(&self.joints).enumerate() {
            let mut values = [first(attributes, joint, "stiffness")?, first(attributes, joint, "damping")?];
            let settings = attributes.numbers(joint.element, &joint.class, "springdamper")?;
            if let Some(&[time, ratio]) = settings.as_deref() {
                if time > 0.0 && ratio > 0.0 {
                    let inertias = inertias.get_or_insert_with(|| self.inertias(bodies, linkage, &armatures));
                    let own = inertias.as_ref().and_then(|all| all.get(number).copied().flatten());
                    let inertia = own.ok_or_else(|| {
                        let help = "write `stiffness` and `damping` instead, or give all bodies a mass";
                        let title = "the inertia that this spring needs is not known";
                        attributes.xml.error(joint.element, "springdamper", title, help)
                    })?;
                    // The motion has this time constant and this ratio of damping.
                    values = [inertia / (time * ratio).powi(2), 2.0 * inertia / time];
                }
            } else if settings.is_some() {
                let help = "write a time constant and a ratio of damping";
                let title = "`springdamper` has two numbers";
                return Err(attributes.xml.error(joint.element, "springdamper", title, help));
            }
            self.spring_damper(attributes, joint, moved, values, linkage, names)?;
        }
        for ((joint, moved), armature) in joints.iter().zip(&self.joints).zip(armatures) {
            self.rotor(moved, armature, linkage);
            left_out(attributes, joint, moved, linkage)?;
        }
        Ok(())
    }

    /// Adds the spring and the damper of a joint.
    fn spring_damper(
        &self,
        attributes: &Attributes,
        joint: &BodyJoint,
        moved: &ImportedJoint,
        [stiffness, damping]: [f64; 2],
        linkage: &mut ImportedLinkage,
        names: &mut Names,
    ) -> Result<(), Error> {
        let mut keys = Vec::new();
        if stiffness != 0.0 {
            let rest = first(attributes, joint, "springref")?;
            let rest = if moved.is_slide { rest } else { attributes.angle(rest) } - moved.reference;
            let unit = if moved.is_slide { "m" } else { "rad" };
            keys.push(format!("spring = {}", shortest(stiffness)));
            if rest != 0.0 {
                keys.push(format!("rest = '{} {unit}'", shortest(rest)));
            }
        }
        if damping != 0.0 {
            keys.push(format!("damper = {}", shortest(damping)));
        }
        if !keys.is_empty() {
            let along = moved.displacement(linkage);
            let name = names.unique(&format!("passive_{}", linkage.joints[moved.number].name), "spring");
            linkage.loads.push(Load::Along { name, along, keys: keys.join(", ") });
        }
        Ok(())
    }

    /// Adds the rotor of a joint on the ground, which turns with its link. Other rotors are noted.
    fn rotor(&self, moved: &ImportedJoint, armature: f64, linkage: &mut ImportedLinkage) {
        let [link, parent] = [0, 1].map(|end| linkage.joints[moved.number].ends[end].link);
        if armature == 0.0 {
            return;
        }
        if !moved.is_slide && parent == 0 {
            let mass = linkage.links[link].mass.get_or_insert(Mass { mass: 0.0, com: [0.0; 2], inertia: 0.0 });
            mass.inertia += armature;
        } else {
            linkage.left_out.push(format!("the armature of joint `{}`", moved.title(linkage)));
        }
    }
}

/// The first number of an attribute of a joint, or 0.
fn first(attributes: &Attributes, joint: &BodyJoint, name: &str) -> Result<f64, Error> {
    Ok(attributes.numbers(joint.element, &joint.class, name)?.map_or(0.0, |numbers| numbers[0]))
}

/// Notes what is left out of a joint.
fn left_out(
    attributes: &Attributes,
    joint: &BodyJoint,
    moved: &ImportedJoint,
    linkage: &mut ImportedLinkage,
) -> Result<(), Error> {
    let title = moved.title(linkage).to_owned();
    for name in ["stiffness", "damping"] {
        let numbers = attributes.numbers(joint.element, &joint.class, name)?;
        if numbers.is_some_and(|numbers| numbers[1..].iter().any(|number| *number != 0.0)) {
            linkage.left_out.push(format!("the nonlinear part of the {name} of joint `{title}`"));
        }
    }
    if first(attributes, joint, "frictionloss")? != 0.0 {
        linkage.left_out.push(format!("the dry friction of joint `{title}`"));
    }
    let limited = attributes.get(joint.element, &joint.class, "limited");
    let has_range = attributes.get(joint.element, &joint.class, "range").is_some();
    if limited == Some("true") || has_range && limited != Some("false") {
        linkage.left_out.push(format!("the range of joint `{title}`"));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::super::super::imported;

    /// Stiffness and damping are those of MuJoCo 4.0.0.
    #[test]
    fn springdampers_have_the_stiffness_and_damping_of_mujoco() {
        let text = "<mujoco><worldbody><body name=\"a\"><joint name=\"j\" axis=\"0 1 0\" springdamper=\"0.1 0.7\" \
                    armature=\"0.02\"/><geom size=\"0.1\" mass=\"2\" pos=\"0.2 0 0\"/><body name=\"b\" pos=\"0.4 0 0\">\
                    <joint name=\"k\" type=\"slide\" axis=\"1 0 1\" springdamper=\"0.2 1\"/>\
                    <geom size=\"0.1\" mass=\"3\" pos=\"0 0 0.1\"/></body></body></worldbody></mujoco>";
        let scene = imported(text).expect("a scene");
        let number = |name: &str, key: &str| -> f64 {
            let line = scene.lines().find(|line| line.starts_with(name)).expect("a load");
            let rest = line.split(&format!("{key} = ")).nth(1).expect("a key");
            rest.split([',', ' ']).next().and_then(|text| text.parse().ok()).expect("a number")
        };
        for (name, key, expected) in [
            ("passive_j", "spring", JOINT[0]),
            ("passive_j", "damper", JOINT[1]),
            ("passive_k", "spring", SLIDE[0]),
            ("passive_k", "damper", SLIDE[1]),
        ] {
            assert!((number(name, key) / expected - 1.0).abs() < 1e-12, "{name} {key}: {scene}");
        }
    }

    const JOINT: [f64; 2] = [101.0204081632653, 9.9];
    const SLIDE: [f64; 2] = [58.92857142857141, 23.571428571428566];
}
