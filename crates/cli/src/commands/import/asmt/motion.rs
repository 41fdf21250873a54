//! The motions of an assembly, as drives of joints.

use super::super::linkage::{Kind, Linkage};
use super::super::names::Names;
use super::super::numbers::{factor, finite, further, shortest, within_a_turn};
use super::super::plane::Plane;
use super::parts::Parts;
use super::tree::Node;

/// Adds the motions as drives. What cannot be carried over is noted.
pub(super) fn add(assembly: &Node, parts: &Parts, plane: &Plane, start: f64, linkage: &mut Linkage, names: &mut Names) {
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
    linkage: &mut Linkage,
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
    let joint =
        linkage.joints.iter().position(|joint| joint.title == name).ok_or("whose joint does nothing in the plane")?;
    let is_j_first = linkage.joints[joint].ends[0].link == j.part;
    let sign = if is_j_first { 1.0 } else { -1.0 };
    let text = match (linkage.joints[joint].kind, key) {
        (Kind::Pin, "RotationZ") => {
            // The formula is the angle of the x axes of both markers about the axis of the first one.
            let side = plane.side(parts.world(&i).axis(2)).unwrap_or(1.0);
            let angle = |marker: &super::parts::Marker| parts.body(plane, marker.part).angle_of(marker.frame.axis(0));
            let offset = within_a_turn(angle(&i) - angle(&j));
            signed(&translated, sign * side) + &further(sign * offset)
        }
        (Kind::Slider { .. }, "TranslationZ") => signed(&translated, sign),
        _ => return Err(format!("which moves joint `{name}` in a way that it does not have")),
    };
    linkage.joints[joint].drive = Some(text);
    let output = names.unique(&format!("T_{}", linkage.joints[joint].name), "drive");
    let entry = format!("{{ drive = \"{}\" }}", linkage.joints[joint].name);
    linkage.outputs.push((output, entry));
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

/// A formula of the time of the solver as one of a scene, where it has nothing else.
fn translated(formula: &str, start: f64) -> Option<String> {
    let functions = ["sin", "cos", "tan", "asin", "acos", "atan", "exp", "log", "sqrt", "abs", "sinh", "cosh", "tanh"];
    let mut text = String::new();
    let mut rest = formula.trim();
    while let Some(c) = rest.chars().next() {
        let mut length = c.len_utf8();
        if c.is_ascii_digit() || c == '.' {
            length = number_length(rest);
            let number = finite(&rest[..length])?;
            text.push_str(&shortest(number));
            // Numbers of Smalltalk end with `d`.
            if rest[length..].starts_with('d') {
                length += 1;
            }
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

/// The length of the number with which a text begins.
fn number_length(text: &str) -> usize {
    let digits =
        |from: usize| text[from..].find(|c: char| !c.is_ascii_digit() && c != '.').map_or(text.len(), |at| from + at);
    let end = digits(0);
    let exponent = &text[end..];
    let sign = exponent.strip_prefix(['e', 'E']).map(|rest| usize::from(rest.starts_with(['+', '-'])));
    match sign {
        Some(sign) if exponent[1 + sign..].starts_with(|c: char| c.is_ascii_digit()) => digits(end + 1 + sign),
        _ => end,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formulae_are_translated() {
        assert_eq!(translated("2.0d*pi*time", 0.0).as_deref(), Some("2*pi*t"));
        assert_eq!(translated("0.1*sin(1.0e-1*time) + .5", 0.0).as_deref(), Some("0.1*sin(0.1*t) + 0.5"));
        assert_eq!(translated("time^2", 1.0).as_deref(), Some("(t + 1)^2"));
        for wrong in ["integral(time, 1)", "", "sin time", "(1", "1)", "1e999", "x", "a'b", "9.9.9"] {
            assert_eq!(translated(wrong, 0.0), None, "{wrong}");
        }
        assert_eq!(signed("t + 1", -1.0), "-(t + 1)");
    }
}
