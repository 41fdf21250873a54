//! Dry friction in pins and sliders, as loads whose normal forces are outputs.

use super::forces::force;
use super::places::{line, slide};
use super::resolved::Linkage;
use super::resolved::displacement_through;
use super::terms::{difference, dot, multiply, name, negate, subtract, whole};
use crate::diagnostic::Diagnostic;
use crate::document::{
    Along, FrictionSyntax, Identifier, JointFriction, LoadSyntax, OutputSyntax, OutputValue, SpringSyntax,
};
use crate::parser::Formula;

/// The friction loads of joints, and the outputs that serve as their normal forces.
#[derive(Default)]
pub(super) struct Frictions {
    pub(super) loads: Vec<(Identifier, LoadSyntax)>,
    pub(super) outputs: Vec<OutputSyntax>,
}

impl Frictions {
    /// Creates the friction of all joints, in their order.
    pub(super) fn new(linkage: &Linkage, findings: &mut Vec<Diagnostic>) -> Self {
        let mut frictions = Self::default();
        for (number, joint) in linkage.graph.joints.iter().enumerate() {
            let Some(friction) = &joint.syntax.friction else { continue };
            if joint.ends.len() > 2 {
                let own = &joint.syntax.identifier;
                let title = format!("joint `{}` has friction and joins {} links", own.name, joint.ends.len());
                let error = Diagnostic::error(title, own.span.clone(), "between which of them?");
                findings
                    .push(error.help("join two links by each pin: the others get joints of their own at this point"));
                continue;
            }
            frictions.add(linkage, number, friction);
        }
        frictions
    }

    fn add(&mut self, linkage: &Linkage, number: usize, friction: &JointFriction) {
        let own = &linkage.graph.joints[number].syntax.identifier;
        let identifier = |name: String| Identifier { name, span: own.span.clone() };
        let normal = identifier(format!("N_{}", own.name));
        let spring = SpringSyntax {
            along: Along::Formula(sliding(linkage, number, friction)),
            stiffness: None,
            rest: None,
            damping: None,
            potential: None,
            force: None,
            friction: Some(FrictionSyntax {
                size: friction.mu.clone(),
                slip: friction.slip.clone(),
                normal: Some(normal.clone()),
            }),
        };
        self.loads.push((identifier(load_of_joint(&own.name)), LoadSyntax::Spring(Box::new(spring))));
        let mut output = |identifier: Identifier, value: OutputValue| {
            let doc = format!("normal force of joint {}", own.name);
            self.outputs.push(OutputSyntax { identifier, value, unit: "N".to_owned(), doc });
        };
        if linkage.graph.joints[number].syntax.kind.is_slider() {
            output(normal, across(linkage, number));
            return;
        }
        let on = linkage.graph.joints[number].ends[0];
        let components = ["x", "y"].map(|axis| identifier(format!("N_{}_{axis}", own.name)));
        for (component, direction) in components.clone().into_iter().zip([[1, 0], [0, 1]]) {
            output(component, force(linkage, number, on, direction));
        }
        output(normal, OutputValue::Norm { components: components.into(), at: None });
    }
}

/// The name of the load that represents the friction of a joint.
pub(crate) fn load_of_joint(joint: &str) -> String {
    format!("friction_{joint}")
}

/// The sliding distance: along the line of a slider, or on the surface of a pin.
fn sliding(linkage: &Linkage, number: usize, friction: &JointFriction) -> Formula {
    let Linkage { graph, tree, angles, places, .. } = linkage;
    let joint = &graph.joints[number];
    let span = &joint.syntax.identifier.span;
    if let Some(radius) = &friction.radius {
        let [first, second] = [0, 1].map(|end: usize| angles.formula(joint.ends[end].link, span));
        return multiply(radius.clone(), subtract(first, second));
    }
    if joint.ends.iter().any(|end| tree.places(number, *end)) {
        return name(slide(graph, number), span);
    }
    let [point, on] = [0, 1].map(|end: usize| places.components(joint.ends[end], span));
    dot(difference(point, on), line(graph, angles, number))
}

/// The force of a slider perpendicular to its line.
fn across(linkage: &Linkage, number: usize) -> OutputValue {
    let joint = &linkage.graph.joints[number];
    if let Some(end) = joint.ends.iter().find(|end| linkage.tree.places(number, **end)) {
        let [cos, sin] = line(linkage.graph, linkage.angles, number);
        let displacements = vec![displacement_through(linkage, *end, [negate(sin), cos])];
        return OutputValue::FreeBody { displacements, multipliers: Vec::new(), loads: Vec::new() };
    }
    let multipliers = vec![(joint.syntax.identifier.clone(), whole(-1))];
    OutputValue::FreeBody { displacements: Vec::new(), multipliers, loads: Vec::new() }
}
