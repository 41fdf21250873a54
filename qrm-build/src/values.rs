//! Changed numbers of a scene in a generated module: values of parameters, start, step and end.

use qrm_scene::expression::Node;
use qrm_scene::layout::without_layout;
use qrm_scene::scene::{Scene, Start, Value};

use crate::golden_copy::GoldenCopy;
use crate::tape_text::TapeText;

/// A module with the numbers of a scene; `None` if more than numbers has changed since it was generated, or a number
/// stands where it cannot be replaced.
///
/// Values also decide in which order the kernel eliminates coordinates. The order of the copy stays, so that results may
/// differ from those of a new derivation in the last digit.
pub(crate) fn with_values(copy: &GoldenCopy, old: &Scene, new: &Scene, source: &str) -> Option<GoldenCopy> {
    if formulae(copy.source()?)? != formulae(source)? || left_out(old) != left_out(new) {
        return None;
    }
    let (before, after) = (settings(old), settings(new));
    let mut copy = copy.clone().with_source(source)?;
    if before.len() != after.len() {
        return None;
    }
    for ((place, old), (_, new)) in before.iter().zip(&after) {
        if old.map(|old| old.nodes()) != new.map(|new| new.nodes()) {
            let change = Change { from: number(old.as_ref()?)?, to: number(new.as_ref()?)? };
            copy = place.changed(copy, &change)?;
        }
    }
    for (old, new) in old.parameters.iter().zip(&new.parameters).filter(|(old, _)| !old.left_out) {
        if old.text != new.text {
            let formula = |text: &str| format!("formula: {text:?},");
            let name = format!("ParameterDescription {{\n            name: {:?},", old.name);
            copy.code = replaced_behind(&copy.code, &name, &formula(&old.text), &formula(&new.text))?;
        }
    }
    Some(copy)
}

/// The text of a scene without the numbers that can be replaced, and without what is no part of its module.
fn formulae(source: &str) -> Option<String> {
    without_layout(source, |keys, is_number| match keys {
        ["drawing" | "extreme" | "reference", ..] => true,
        ["parameters" | "initial" | "run", ..] => is_number,
        _ => false,
    })
}

/// For each parameter, whether the generated code does without it.
fn left_out(scene: &Scene) -> Vec<bool> {
    scene.parameters.iter().map(|parameter| parameter.left_out).collect()
}

/// A number of a scene that its module holds.
enum Setting<'a> {
    /// The value of a parameter, by its place and its name.
    Parameter(usize, &'a str),
    /// A coordinate or a rate at the start, by its place among both.
    Start(usize, usize),
    /// The step or the end, by its field and its place.
    Schedule(&'static str, usize),
}

/// All numbers of a module that a scene can change, with their formulae.
fn settings(scene: &Scene) -> Vec<(Setting<'_>, Option<&Value>)> {
    let parameters = scene.parameters.iter().filter(|parameter| !parameter.left_out);
    let parameters =
        parameters.enumerate().map(|(i, parameter)| (Setting::Parameter(i, &parameter.name), Some(&parameter.formula)));
    let n = scene.coordinates.len();
    let positions = scene.coordinates.iter().map(|coordinate| &coordinate.position);
    let rates = scene.coordinates.iter().map(|coordinate| &coordinate.rate);
    let starts = positions.chain(rates).enumerate().map(|(i, start)| {
        let value = match start {
            Start::Given(value) | Start::Guess(value) => Some(value),
            Start::Free => None,
        };
        (Setting::Start(i, n), value)
    });
    let schedule = [("step", &scene.run.step), ("end_time", &scene.run.end_time)];
    let schedule =
        schedule.into_iter().enumerate().map(|(i, (field, value))| (Setting::Schedule(field, i), Some(value)));
    parameters.chain(starts).chain(schedule).collect()
}

/// The number that a formula is.
fn number(formula: &Value) -> Option<f64> {
    match formula.nodes() {
        [Node::Number(number)] => Some(number.value),
        [Node::Number(number), Node::Negate(0)] => Some(-number.value),
        _ => None,
    }
}

/// A number that becomes another one.
pub(crate) struct Change {
    pub(crate) from: f64,
    pub(crate) to: f64,
}

impl Setting<'_> {
    /// The module with the other number here.
    fn changed(&self, mut copy: GoldenCopy, change: &Change) -> Option<GoldenCopy> {
        let mut tape = TapeText::new(&copy.code)?;
        match *self {
            Self::Parameter(index, name) => {
                tape.set_parameter(index, change)?;
                copy.code = tape.written(&copy.code)?;
                let before = format!("replace({name:?})");
                copy.code = in_rust(&copy.code, &before, ".unwrap_or(", 0, change)?;
                let cell = |value: f64| format!("| `{name}` | `{value:?}` |");
                copy.derivation = replaced_behind(&copy.derivation, "", &cell(change.from), &cell(change.to))?;
            }
            Self::Start(i, n) => {
                tape.set("start", i, change)?;
                copy.code = tape.written(&copy.code)?;
                let field = if i < n { " q: [" } else { " qd: [" };
                copy.code = in_rust(&copy.code, "fn start(&self)", field, i % n, change)?;
            }
            Self::Schedule(field, i) => {
                tape.set("schedule", i, change)?;
                copy.code = tape.written(&copy.code)?;
                copy.code = in_rust(&copy.code, "fn schedule(&self)", &format!(" {field}: "), 0, change)?;
            }
        }
        Some(copy)
    }
}

/// A text with a part replaced that stands once behind another one.
fn replaced_behind(text: &str, behind: &str, from: &str, to: &str) -> Option<String> {
    let start = text.find(behind)? + behind.len();
    let place = start + text[start..].find(from)?;
    Some(format!("{}{to}{}", &text[..place], &text[place + from.len()..]))
}

/// A module with the number of a list that stands behind two texts replaced in its Rust.
fn in_rust(code: &str, first: &str, second: &str, index: usize, change: &Change) -> Option<String> {
    let first = code.find(first)? + first.len();
    let mut start = first + code[first..].find(second)? + second.len();
    for _ in 0..index {
        start += item_end(&code[start..]) + 1;
    }
    let end = start + item_end(&code[start..]);
    let item = code[start..end].trim();
    let (sign, rest) = item.strip_prefix('-').map_or((1.0, item), |rest| (-1.0, rest));
    let value: f64 = rest.strip_prefix("R::from_f64(")?.strip_suffix(')')?.parse().ok()?;
    if sign * value != change.from {
        return None;
    }
    let before = code[start..end].find(item)? + start;
    Some(format!("{}R::from_f64({:?}){}", &code[..before], change.to, &code[before + item.len()..]))
}

/// Where the first item of a list ends.
fn item_end(text: &str) -> usize {
    let mut depth = 0;
    let is_end = |character: char| {
        match character {
            '(' | '[' => depth += 1,
            ')' | ']' if depth == 0 => return true,
            ')' | ']' => depth -= 1,
            ',' if depth == 0 => return true,
            _ => {}
        }
        false
    };
    text.find(is_end).unwrap_or(text.len())
}
