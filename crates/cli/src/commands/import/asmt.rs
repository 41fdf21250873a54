//! Assemblies of the Ondsel solver: parts with markers, joints between markers, and motions of joints.

mod joints;
mod motion;
mod parts;
mod tree;

use super::linkage::{Linkage, Load};
use super::names::Names;
use super::plane::Plane;
use super::source::Source;
use crate::error::Error;
use parts::Parts;
use tree::{Node, Tree};

/// Whether a text begins as an assembly.
pub(super) fn is_of(text: &str) -> bool {
    let first = text.lines().next().unwrap_or_default();
    first.trim() == "OndselSolver" || first.starts_with("freeCAD: 3D CAD with Motion Simulation")
}

/// Reads an assembly.
pub(super) fn read(source: &Source) -> Result<Linkage, Error> {
    let tree = Tree::read(&source.text);
    let Some(assembly) = tree.roots().find(|node| node.text() == "Assembly") else {
        return Err(
            source.whole("it has no `Assembly`", "export the assembly again, as a file .asmt of the Ondsel solver")
        );
    };
    let mut linkage = Linkage::new("an assembly of the Ondsel solver");
    let mut names = Names::new();
    let items = joints::items(&assembly);
    let mut parts = Parts::read(source, &assembly)?;
    let plane = joints::plane(source, &parts, &items)?;
    parts.place(&plane, &mut linkage, &mut names);
    joints::add(source, &parts, &plane, &items, &mut linkage, &mut names)?;
    let run = simulation(source, &assembly, &mut linkage)?;
    motion::add(&assembly, &parts, &plane, run, &mut linkage, &mut names);
    gravity(source, &assembly, &plane, &mut linkage)?;
    forces(&mut linkage, &mut names);
    remarks(&tree, &assembly, &plane, &mut linkage);
    Ok(linkage)
}

/// The times of the simulation; returns its start.
fn simulation(source: &Source, assembly: &Node, linkage: &mut Linkage) -> Result<f64, Error> {
    let Some(settings) = assembly.child("SimulationParameters") else { return Ok(0.0) };
    let value =
        |name: &str| settings.child(name).and_then(|node| node.first()).map(|node| node.number(source)).transpose();
    let [start, end, output] =
        [value("tstart")?.unwrap_or(0.0), value("tend")?.unwrap_or(0.0), value("hout")?.unwrap_or(0.0)];
    if end > start {
        linkage.end_time = end - start;
    }
    // The rows of the file are among those of the run, which has at least 1000 steps.
    let output = if output > 0.0 && output <= linkage.end_time { output } else { linkage.end_time };
    let parts = (1000.0 * output / linkage.end_time).ceil().max(1.0);
    linkage.step = output / parts;
    Ok(start)
}

fn gravity(source: &Source, assembly: &Node, plane: &Plane, linkage: &mut Linkage) -> Result<(), Error> {
    let Some(row) = assembly.child("ConstantGravity").and_then(|node| node.first()) else { return Ok(()) };
    let gravity = row.vector(source)?;
    let flat = plane.project(gravity);
    if flat != [0.0; 2] {
        linkage.loads.push(Load::Gravity(flat));
    }
    if !plane.contains(gravity) && gravity != [0.0; 3] {
        linkage.left_out.push("gravity across the plane, which joints carry".to_owned());
    }
    Ok(())
}

/// Forces in all joints as outputs.
fn forces(linkage: &mut Linkage, names: &mut Names) {
    let has_mass = linkage.links.iter().any(|link| link.mass.is_some());
    for joint in linkage.joints.iter().filter(|joint| joint.has_force() && has_mass) {
        let name = names.unique(&format!("F_{}", joint.name), "force");
        linkage.outputs.push((name, format!("{{ joint = \"{}\" }}", joint.name)));
    }
}

fn remarks(tree: &Tree, assembly: &Node, plane: &Plane, linkage: &mut Linkage) {
    let axis = |vector: [f64; 3]| format!("({})", vector.map(super::numbers::shortest).join(", "));
    linkage.remarks.push(format!("The axes of the plane, in the assembly: x {}, y {}.", axis(plane.x), axis(plane.y)));
    for (section, what) in
        [("ForceTorques", "force or torque"), ("Limits", "limit"), ("KinematicIJs", "measured quantity")]
    {
        let nodes = [assembly.child(section), assembly.child("ConstraintSets").and_then(|sets| sets.child(section))];
        for item in nodes.into_iter().flatten().flat_map(|node| node.children()) {
            linkage.left_out.push(format!("the {what} `{}` ({})", item.name(), item.text()));
        }
    }
    let sets = assembly.child("ConstraintSets").and_then(|sets| sets.child("GeneralConstraintSets"));
    for item in sets.into_iter().flat_map(|node| node.children()) {
        linkage.left_out.push(format!("the constraint `{}` ({})", item.name(), item.text()));
    }
    if tree.roots().any(|node| node.text().starts_with("TimeSeries")) {
        linkage.left_out.push("the results that the file holds".to_owned());
    }
}
