//! Reads the motions of an assembly as drives of joints.

use super::super::linkage::{ImportedLinkage, Kind};
use super::super::names::Names;
use super::super::numbers::{factor, shortest, signed_term, wrap_angle};
use super::super::plane::Plane;
use super::parts::Parts;
use super::tree::{Node, smalltalk_number};

/// Adds the motions as drives. What cannot be carried over is noted.
pub(super) fn add(
    assembly: &Node,
    parts: &Parts,
    plane: &Plane,
    start: f64,
    linkage: &mut ImportedLinkage,
    names: &mut Names,
) {
    let sets = assembly.child("ConstraintSets");
    let joints: Vec<Node> = super::joints::items(assembly);
    for motion in sets.and_then(|sets| sets.child("Motions")).into_iter().flat_map(|node| node.children()) {
        if let Err(reason) = drive(&motion, &joints, parts, plane, start, linkage, names) {
            linkage.left_out.push(format!("the motion `{}`, {reason}", motion.name()));
        }
    }
}

fn drive(
    motion: &Node,
    joints: &[Node],
    parts: &Parts,
    plane: &Plane,
    start: f64,
    linkage: &mut ImportedLinkage,
    names: &mut Names,
) -> Result<(), String> {
    let key = match motion.text() {
        "RotationalMotion" => "RotationZ",
        "TranslationalMotion" => "TranslationZ",
        other => return Err(format!("which is a `{other}`")),
    };
    let formula = motion.value(key).ok_or_else(|| format!("which has no `{key}`"))?;
    let Some(translated) = translated(formula, start) else {
        return Err(format!("whose formula is `{formula}`: write it as the `drive` of its joint"));
    };
    let path = motion.value("MotionJoint").unwrap_or_default();
    let name = path.rsplit('/').next().unwrap_or_default();
    let item =
        joints.iter().find(|joint| joint.name() == name).ok_or_else(|| format!("whose joint `{path}` is not known"))?;
    let place = [item.value("MarkerI"), item.value("MarkerJ")].map(|path| path.and_then(|path| parts.find(path)));
    let [Some(i), Some(j)] = place else { return Err("whose joint has no markers".to_owned()) };
    let joint = linkage
        .joints
        .iter()
        .position(|joint| joint.model_name == name)
        .ok_or("whose joint does nothing in the plane")?;
    let is_j_first = linkage.joints[joint].ends[0].link == j.part;
    let sign = if is_j_first { 1.0 } else { -1.0 };
    let text = match (linkage.joints[joint].kind, key) {
        (Kind::Pin, "RotationZ") => {
            // The formula is the angle of the x axes of both markers about the axis of the first one.
            let side = plane.normal_sign(parts.world(&i).axis(2)).unwrap_or(1.0);
            let angle = |marker: &super::parts::Marker| parts.body(plane, marker.part).angle_of(marker.frame.axis(0));
            let offset = wrap_angle(angle(&i) - angle(&j));
            signed(&translated, sign * side) + &signed_term(sign * offset)
        }
        (Kind::Slider { direction, .. }, "TranslationZ") => {
            // The formula is the place of the second marker along the z axis of the first one.
            let [x, y] = plane.project(parts.world(&i).axis(2));
            let angle = linkage.links[linkage.joints[joint].ends[1].link].angle + direction;
            let along = x * angle.cos() + y * angle.sin();
            if along.abs() < 0.5 {
                return Err(format!("which moves joint `{name}` across the direction in which it slides"));
            }
            signed(&translated, sign * along.signum())
        }
        _ => return Err(format!("which moves joint `{name}` in a way that it does not have")),
    };
    linkage.joints[joint].drive = Some(text);
    linkage.add_drive_force(joint, names);
    Ok(())
}

fn signed(formula: &str, sign: f64) -> String {
    let is_sum = formula.chars().skip(1).any(|c| matches!(c, '+' | '-'));
    match (sign < 0.0, is_sum || formula.starts_with('-')) {
        (false, _) => formula.to_owned(),
        (true, true) => format!("-({formula})"),
        (true, false) => format!("-{formula}"),
    }
}

/// Translates a formula of the solver into one of a scene. `None`, where it has more than time, numbers and functions.
fn translated(formula: &str, start: f64) -> Option<String> {
    let functions = ["sin", "cos", "tan", "asin", "acos", "atan", "exp", "log", "sqrt", "abs", "sinh", "cosh", "tanh"];
    let mut text = String::new();
    let mut rest = formula.trim();
    while let Some(c) = rest.chars().next() {
        let mut length = c.len_utf8();
        if c.is_ascii_digit() || c == '.' {
            length = number_length(rest);
            text.push_str(&shortest(smalltalk_number(&rest[..length])?));
        } else if c.is_ascii_alphabetic() {
            length = rest.find(|c: char| !c.is_ascii_alphanumeric() && c != '_').unwrap_or(rest.len());
            match &rest[..length] {
                "time" if start == 0.0 => text.push('t'),
                "time" => text.push_str(&format!("(t + {})", factor(start))),
                "pi" => text.push_str("pi"),
                name if functions.contains(&name) && rest[length..].trim_start().starts_with('(') => {
                    text.push_str(name)
                }
                _ => return None,
            }
        } else if matches!(c, '+' | '-' | '*' | '/' | '^' | '(' | ')') {
            text.push(c);
        } else if c.is_whitespace() {
            text.push(' ');
        } else {
            return None;
        }
        rest = &rest[length..];
    }
    let depth = text.chars().try_fold(0_usize, |depth, c| match c {
        '(' => Some(depth + 1),
        ')' => depth.checked_sub(1),
        _ => Some(depth),
    });
    (depth == Some(0) && !text.trim().is_empty()).then_some(text)
}

/// The length of the number at the begin of a text, with all letters and digits directly behind it.
fn number_length(text: &str) -> usize {
    let end = |from: usize| {
        let rest = text[from..].find(|c: char| !c.is_ascii_alphanumeric() && !matches!(c, '.' | '_'));
        rest.map_or(text.len(), |at| from + at)
    };
    let first = end(0);
    // A sign directly behind `d` or `e` belongs to the exponent.
    if text[..first].ends_with(['d', 'e', 'E']) && text[first..].starts_with(['+', '-']) {
        end(first + 1)
    } else {
        first
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formulae_are_translated() {
        assert_eq!(translated("2.0d*pi*time", 0.0).as_deref(), Some("2*pi*t"));
        assert_eq!(translated("0.1*sin(1.0e-1*time) + .5", 0.0).as_deref(), Some("0.1*sin(0.1*t) + 0.5"));
        assert_eq!(translated("2.0d-1*time + 1d+2 - 3.0d2*(4d)", 0.0).as_deref(), Some("0.2*t + 100 - 300*(4)"));
        assert_eq!(translated("time^2", 1.0).as_deref(), Some("(t + 1)^2"));
        for wrong in [
            "integral(time, 1)",
            "",
            "sin time",
            "(1",
            "1)",
            "1e999",
            "x",
            "a'b",
            "9.9.9",
            "2.0d-*time",
            "2dx",
            "2dd",
            "2d.5",
            "1.0da*time",
            "2e*time",
            "2d1.5",
        ] {
            assert_eq!(translated(wrong, 0.0), None, "{wrong}");
        }
        assert_eq!(signed("t + 1", -1.0), "-(t + 1)");
    }
}
