//! The moments in joints that hold angles, from the equations of motion of links that turn while others only move.

use super::closures::{DRIVE, gear_slopes};
use super::friction::load_of_joint;
use super::gears::moments_of_teeth;
use super::graph::{GROUND, PointId};
use super::resolved::Linkage;
use super::terms::{add, difference, is_zero, multiply, negate, sum, whole};
use super::tree::Placement;
use crate::diagnostic::Diagnostic;
use crate::document::{DisplacementSyntax, Identifier, JointKind, OutputValue};
use crate::parser::Formula;

/// The moment of a joint on the link of one of its ends, about its point.
pub(super) fn moment(
    linkage: &Linkage,
    number: usize,
    on: PointId,
    asked: &Identifier,
) -> Result<OutputValue, Diagnostic> {
    let joint = &linkage.graph.joints[number];
    let syntax = joint.syntax;
    match syntax.kind {
        JointKind::Gear => {
            let slopes = gear_slopes(joint);
            let slope = slopes.into_iter().find(|(link, _)| *link == on.link).map_or_else(|| whole(0), |(_, own)| own);
            Ok(multiplier_moment(linkage, number, "", negate(slope)))
        }
        JointKind::Revolute if syntax.drive.is_some() || syntax.friction.is_some() => {
            Ok(pin_moment(linkage, number, on))
        }
        kind if kind.holds_angle() => angle_holding_moment(linkage, number, on, asked),
        _ => {
            let title = format!("joint `{}` carries no moment", asked.name);
            let error = Diagnostic::error(title, asked.span.clone(), "its links turn freely");
            Err(error
                .help("ask for its force: `joint = \"NAME\"`, or for the moment of a weld, a slider, gears or a drive"))
        }
    }
}

/// The moment of a pin: the sum of its drive and its friction.
fn pin_moment(linkage: &Linkage, number: usize, on: PointId) -> OutputValue {
    let joint = &linkage.graph.joints[number];
    let Identifier { name, span } = &joint.syntax.identifier;
    let identifier = |name: String| Identifier { name, span: span.clone() };
    let sign = if on == joint.ends[0] { 1 } else { -1 };
    let driven = joint.syntax.drive.as_ref().map(|_| (identifier(format!("{name}{DRIVE}")), whole(-sign)));
    let radius = joint.syntax.friction.as_ref().and_then(|friction| friction.radius.clone());
    let rubbed = radius.map(|radius| (identifier(load_of_joint(name)), multiply(whole(sign), radius)));
    OutputValue::FreeBody {
        displacements: Vec::new(),
        multipliers: driven.into_iter().collect(),
        loads: rubbed.into_iter().collect(),
    }
}

/// The torque, or the force along its line, of a drive on the link of one of the ends of its joint. The force of a
/// cylinder is positive if it pushes.
pub(super) fn drive(
    linkage: &Linkage,
    number: usize,
    on: PointId,
    asked: &Identifier,
) -> Result<OutputValue, Diagnostic> {
    let joint = &linkage.graph.joints[number];
    if joint.syntax.is_cylinder {
        return Ok(multiplier_moment(linkage, number, "", whole(-1)));
    }
    if joint.syntax.drive.is_none() {
        let title = format!("joint `{}` has no drive", asked.name);
        let error = Diagnostic::error(title, asked.span.clone(), "nothing drives it");
        return Err(error.help("give it `drive = 'FORMULA of t'`, or ask for the power of a load"));
    }
    Ok(multiplier_moment(linkage, number, DRIVE, whole(if on == joint.ends[0] { -1 } else { 1 })))
}

/// A multiple of the multiplier of a joint's constraint.
fn multiplier_moment(linkage: &Linkage, number: usize, suffix: &str, factor: Formula) -> OutputValue {
    let Identifier { name, span } = &linkage.graph.joints[number].syntax.identifier;
    let constraint = Identifier { name: format!("{name}{suffix}"), span: span.clone() };
    OutputValue::FreeBody { displacements: Vec::new(), multipliers: vec![(constraint, factor)], loads: Vec::new() }
}

/// The moment of a joint that holds an angle. All links that other joints hold at one angle with the link of its end
/// turn, each about the point by which the tree places it; links further out move without turning.
fn angle_holding_moment(
    linkage: &Linkage,
    number: usize,
    on: PointId,
    asked: &Identifier,
) -> Result<OutputValue, Diagnostic> {
    let Linkage { graph, angles, closures, .. } = linkage;
    let joint = &graph.joints[number];
    let [first, second] = [joint.ends[0].link, joint.ends[1].link];
    let other = if on.link == first { second } else { first };
    let turned = links_at_same_angle(linkage, number, on.link);
    if turned.contains(&other) {
        let title = format!("the moment of joint `{}` cannot be told from those of others", asked.name);
        let error = Diagnostic::error(title, asked.span.clone(), "other joints hold its angle too");
        return Err(error.help("make one of them a revolute joint or a pin in a slot"));
    }
    // The ground does not turn; the links on the other side turn in the opposite direction instead.
    let (turned, turn) =
        if turned.contains(&0) { (links_at_same_angle(linkage, number, other), -1) } else { (turned, 1) };
    let class = angles.angle(on.link).class;
    // Formulae contain the coordinate of the link that owns it.
    let owner = if class > 0 { Some(angles.coordinates[class - 1].1) } else { None };
    let is_turned_in_formulae = owner.is_some_and(|owner| turned.contains(&owner));
    let missing = |slopes: &[(usize, Formula)]| {
        slopes.iter().fold(whole(0), |sum, (link, slope)| {
            match (turned.contains(link), is_turned_in_formulae && angles.angle(*link).class == class) {
                (true, false) => add(sum, slope.clone()),
                (false, true) => add(sum, negate(slope.clone())),
                _ => sum,
            }
        })
    };
    let multipliers =
        closures.iter().map(|own| (own.syntax.identifier.clone(), multiply(whole(turn), missing(&own.slopes))));
    let teeth = moments_of_teeth(linkage, number, on);
    // Friction in pins acts along the angles of their links.
    let frictions = graph.joints.iter().filter_map(|own| {
        let radius = own.syntax.friction.as_ref()?.radius.clone()?;
        let slopes = [(own.ends[0].link, radius.clone()), (own.ends[1].link, negate(radius))];
        let Identifier { name, span } = &own.syntax.identifier;
        let load = Identifier { name: load_of_joint(name), span: span.clone() };
        Some((load, multiply(whole(-turn), missing(&slopes))))
    });
    Ok(OutputValue::FreeBody {
        displacements: displacements(linkage, number, &turned, turn, owner),
        multipliers: multipliers.filter(|(_, factor)| !is_zero(factor)).chain(teeth).collect(),
        loads: frictions.filter(|(_, factor)| !is_zero(factor)).collect(),
    })
}

/// The links that joints other than this one hold at one angle with a link.
fn links_at_same_angle(linkage: &Linkage, but: usize, link: usize) -> Vec<usize> {
    linkage.graph.joined(vec![link], |number, joint| number != but && joint.syntax.kind.holds_angle())
}

/// The displacements of all links when some of them turn.
fn displacements(
    linkage: &Linkage,
    number: usize,
    turned: &[usize],
    turn: i32,
    owner: Option<usize>,
) -> Vec<DisplacementSyntax> {
    let Linkage { graph, tree, angles, places, .. } = linkage;
    let joint = &graph.joints[number];
    let span = &joint.syntax.identifier.span;
    let components = |id: PointId| places.components(id, span);
    // Rotated by a quarter of a turn.
    let velocity = |from: PointId, to: PointId| {
        let [x, y] = difference(components(to), components(from));
        let across = [negate(y), x];
        if turn < 0 { across.map(negate) } else { across }
    };
    let base = |link: usize| match tree.placements[link] {
        Placement::Pin { own, .. } | Placement::Slider { own, .. } => own,
        // Any point will do.
        Placement::Free | Placement::Ground => {
            joint.ends.iter().copied().find(|end| end.link == link).unwrap_or(PointId { link, point: 0 })
        }
    };
    let mut moved: Vec<[Formula; 2]> = vec![[whole(0), whole(0)]; graph.links.len()];
    let mut displacements = Vec::new();
    for &link in &tree.order {
        let guide = match tree.placements[link] {
            Placement::Slider { joint, .. } => Some(graph.joints[joint].ends[1].link),
            _ => None,
        };
        if let Placement::Pin { at, own, .. } | Placement::Slider { at, own, .. } = tree.placements[link] {
            let mut along = moved[at.link].clone();
            if turned.contains(&at.link) && at != base(at.link) {
                along = sum(along, velocity(base(at.link), at));
            }
            if guide.is_some_and(|guide| turned.contains(&guide)) {
                along = sum(along, velocity(at, own));
            }
            moved[link] = along;
        }
        let is_moved = !moved[link].iter().all(is_zero);
        let turns = turned.contains(&link);
        if !is_moved && !turns {
            continue;
        }
        let (bodies, points) = linkage.bodies_and_points(&[link]);
        let identifier = |name: &str| Identifier { name: name.to_owned(), span: span.clone() };
        let angle = (owner == Some(link)).then(|| &angles.coordinates[angles.angle(link).class - 1].0);
        let turn = (whole(turn), identifier(places.name(base(link))), angle.map(|name| identifier(name)));
        displacements.push(DisplacementSyntax {
            bodies,
            points,
            along: is_moved.then(|| moved[link].clone()),
            turn: turns.then_some(turn),
            slide: None,
        });
    }
    debug_assert!(!turned.iter().any(|link| graph.name(*link) == GROUND), "the ground does not turn");
    displacements
}
