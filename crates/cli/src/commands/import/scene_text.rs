//! The text of an imported scene.

use std::fmt::Write;

use super::independent_coordinates::{IndependentCoordinates, slider_rate};
use super::linkage::{ImportedLinkage, Joint, Kind, Load, rotated};
use super::numbers::{pair, shortest, snap_rounding, wrap_angle};

/// Writes a linkage as a scene.
pub(super) fn scene_text(linkage: &ImportedLinkage, name: &str, file: &str) -> String {
    let independent = IndependentCoordinates::choose(linkage);
    let mut text = head(linkage, name, file);
    section(
        &mut text,
        "parameters",
        linkage.parameters.iter().map(|parameter| {
            let value = shortest(parameter.value);
            let doc = quoted(&parameter.doc);
            let unit =
                if parameter.unit.is_empty() { String::new() } else { format!(", unit = \"{}\"", parameter.unit) };
            // Without this key, the generated code leaves out what zero multiplies.
            let runtime = if parameter.value == 0.0 { ", runtime = true" } else { "" };
            (parameter.name.clone(), format!("{{ value = {value}{unit}{runtime}, doc = {doc} }}"))
        }),
    );
    section(
        &mut text,
        "links",
        (0..linkage.links.len())
            .map(|link| (linkage.links[link].name.clone(), link_entry(linkage, link, &independent))),
    );
    section(
        &mut text,
        "joints",
        (0..linkage.joints.len())
            .map(|joint| (linkage.joints[joint].name.clone(), joint_entry(linkage, joint, &independent))),
    );
    section(
        &mut text,
        "constraints",
        linkage.constraints.iter().map(|constraint| {
            (
                constraint.name.clone(),
                format!("{{ residual = '{}', unit = \"{}\" }}", constraint.residual, constraint.unit),
            )
        }),
    );
    section(
        &mut text,
        "loads",
        linkage.loads.iter().map(|load| match load {
            Load::Gravity(gravity) => ("gravity".to_owned(), format!("{{ gravity = {} }}", pair(*gravity))),
            Load::Along { name, along, keys } => (name.clone(), format!("{{ along = '{along}', {keys} }}")),
            Load::Force { name, force, at, frame } => {
                let frame = frame.as_ref().map_or(String::new(), |link| format!(", frame = \"{link}\""));
                (name.clone(), format!("{{ force = {}, at = \"{at}\"{frame} }}", pair(*force)))
            }
        }),
    );
    section(&mut text, "outputs", linkage.outputs.iter().cloned());
    text
}

/// Writes the comments, the name and the run.
fn head(linkage: &ImportedLinkage, name: &str, file: &str) -> String {
    let mut text = String::new();
    comment(&mut text, "# ", &format!("Imported from {file}, {}.", linkage.format));
    for remark in &linkage.remarks {
        comment(&mut text, "# ", remark);
    }
    if !linkage.left_out.is_empty() {
        text.push_str("#\n# Left out:\n");
        for item in &linkage.left_out {
            comment(&mut text, "# - ", item);
        }
    }
    let doc = quoted(&format!("A linkage imported from {file}."));
    let [step, end_time] = [linkage.step, linkage.end_time].map(shortest);
    let _ = write!(text, "name = \"{name}\"\ndoc = {doc}\nrun = {{ step = {step}, end_time = {end_time} }}\n");
    text
}

/// Writes a comment in lines of at most 120 characters.
fn comment(text: &mut String, begin: &str, content: &str) {
    let mut line = begin.to_owned();
    let mut is_empty = true;
    for word in content.split_whitespace() {
        let word: String = word.chars().filter(|c| !c.is_control()).take(80).collect();
        if !is_empty && line.chars().count() + word.chars().count() >= 120 {
            text.push_str(&line);
            text.push('\n');
            line = if begin == "# " { "# ".to_owned() } else { "#   ".to_owned() };
            is_empty = true;
        }
        if !is_empty {
            line.push(' ');
        }
        line.push_str(&word);
        is_empty = false;
    }
    text.push_str(line.trim_end());
    text.push('\n');
}

/// Writes a section with its equals signs below each other. An empty section is left out.
fn section(text: &mut String, name: &str, entries: impl Iterator<Item = (String, String)>) {
    let entries: Vec<_> = entries.collect();
    let width = entries.iter().map(|(key, _)| key.len()).max().unwrap_or(0);
    if !entries.is_empty() {
        let _ = writeln!(text, "[{name}]");
    }
    for (key, value) in entries {
        let _ = writeln!(text, "{key:width$} = {value}");
    }
}

/// Puts a text in quotes.
fn quoted(text: &str) -> String {
    let escaped: String = text.chars().filter(|c| !c.is_control()).collect();
    format!("\"{}\"", escaped.replace('\\', "\\\\").replace('"', "\\\""))
}

/// Writes a link: its points, its mass, its angle at the start.
fn link_entry(linkage: &ImportedLinkage, link: usize, independent: &IndependentCoordinates) -> String {
    let own = &linkage.links[link];
    let mut points: Vec<(String, [f64; 2])> = Vec::new();
    for joint in &linkage.joints {
        if matches!(joint.kind, Kind::Gear { .. }) {
            continue;
        }
        let names = ImportedLinkage::points(joint);
        for (i, end) in joint.ends.iter().enumerate().filter(|(_, end)| end.link == link) {
            let name = &names[usize::from(i == 1)];
            if !points.iter().any(|(other, _)| other == name) {
                points.push((name.clone(), end.at));
            }
        }
    }
    points.extend(own.points.iter().cloned());
    let listed: Vec<String> = points.iter().map(|(name, at)| format!("{name} = {}", pair(*at))).collect();
    let mut keys = vec![if listed.is_empty() {
        "points = {}".to_owned()
    } else {
        format!("points = {{ {} }}", listed.join(", "))
    }];
    if let Some(mass) = &own.mass {
        // A mass of zero with an inertia is a wheel without weight.
        keys.push(format!(
            "mass = {}, com = {}, inertia = {}",
            shortest(mass.mass),
            pair(mass.com),
            shortest(mass.inertia)
        ));
    }
    let is_owner = link > 0 && linkage.angles()[link].0 == link;
    if is_owner && !is_driven_against_ground(linkage, link) {
        keys.push(format!("angle = {}", shortest(wrap_angle(own.angle))));
    }
    if independent.links.contains(&link) {
        keys.push(format!("rate = {}", shortest(own.rate)));
    }
    format!("{{ {} }}", keys.join(", "))
}

/// Whether a drive in a pin on the ground gives the angle of a link.
fn is_driven_against_ground(linkage: &ImportedLinkage, link: usize) -> bool {
    linkage.joints.iter().any(|joint| {
        let other = |end: usize| joint.ends[end].link;
        joint.drive.is_some()
            && joint.kind == Kind::Pin
            && joint.ends.len() == 2
            && (other(0) == link && other(1) == 0 || other(0) == 0 && other(1) == link)
    })
}

/// Writes a joint: its kind, its links, its drive.
fn joint_entry(linkage: &ImportedLinkage, joint: usize, independent: &IndependentCoordinates) -> String {
    let own = &linkage.joints[joint];
    let names = ImportedLinkage::points(own);
    let place = |(i, link): (usize, &str)| {
        let point = &names[usize::from(i == 1)];
        // A point that has the name of the joint is the one that is meant.
        if *point == own.name { format!("\"{link}\"") } else { format!("\"{link}.{point}\"") }
    };
    let links: Vec<&str> = own.ends.iter().map(|end| linkage.links[end.link].name.as_str()).collect();
    let places: Vec<String> = links.iter().copied().enumerate().map(place).collect();
    let places = places.join(", ");
    let angle = |key: &str, value: f64| match shortest(wrap_angle(value)) {
        zero if zero == "0" => String::new(),
        number => format!(", {key} = {number}"),
    };
    let mut entry = match own.kind {
        Kind::Pin => format!("revolute = [{places}]"),
        Kind::Slider { direction, rotation } => {
            format!("prismatic = [{places}]{}{}", angle("direction", direction), angle("rotation", rotation))
        }
        Kind::Slot { direction } => format!("pin_in_slot = [{places}]{}", angle("direction", direction)),
        Kind::Weld { rotation } => format!("weld = [{places}]{}", angle("rotation", rotation)),
        Kind::Gear { ratio, phase, carrier } => {
            let carrier =
                if carrier == 0 { String::new() } else { format!(", carrier = \"{}\"", linkage.links[carrier].name) };
            let links = links.iter().map(|link| format!("\"{link}\"")).collect::<Vec<_>>().join(", ");
            format!("gear = [{links}], ratio = {}{}{carrier}", shortest(ratio), angle("phase", phase))
        }
        Kind::Rack { radius, direction } => {
            format!("rack = [{places}], radius = {}{}", shortest(radius), angle("direction", direction))
        }
    };
    if let Some(drive) = &own.drive {
        let _ = write!(entry, ", drive = '{drive}'");
    } else if let Kind::Slider { direction, .. } | Kind::Slot { direction } = own.kind {
        let _ = write!(entry, ", start = {}", shortest(start(linkage, own, direction)));
        if independent.joints.contains(&joint) {
            let _ = write!(entry, ", rate = {}", shortest(slider_rate(linkage, joint)));
        }
    }
    format!("{{ {entry} }}")
}

/// The place of the point of a slider along its line at the start.
fn start(linkage: &ImportedLinkage, joint: &Joint, direction: f64) -> f64 {
    let [first, second] = [joint.ends[0], joint.ends[1]].map(|end| linkage.place(end));
    let axis = rotated([1.0, 0.0], linkage.links[joint.ends[1].link].angle + direction);
    let size = first.iter().chain(&second).fold(0.0, |most: f64, value| most.max(value.abs()));
    snap_rounding((first[0] - second[0]) * axis[0] + (first[1] - second[1]) * axis[1], 4.0 * size)
}
