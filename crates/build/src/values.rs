//! Replaces changed numbers of a scene in its golden copy: values of parameters, start, step and end.

use qrm_core::named_tape::Value as TapeValue;
use qrm_core::{NamedTape, Operation};
use qrm_language::{Code, rust};
use qrm_scene::expression::Node;
use qrm_scene::layout::without_layout;
use qrm_scene::scene::{Scene, Start, Value};
use qrm_scene::scene_file::SceneFile;

use crate::golden_copy::GoldenCopy;

/// Updates a golden copy to the numbers of a scene; `None` if more than numbers has changed since its generation.
///
/// Values also determine the order in which the kernel eliminates coordinates. The order of the copy is kept, so
/// results may differ from those of a new derivation in the last digit.
pub(crate) fn with_values(copy: &GoldenCopy, (old, source): (&Scene, &str), new: &SceneFile) -> Option<GoldenCopy> {
    if formulae(source)? != formulae(&new.source)? || left_out(old) != left_out(&new.scene) {
        return None;
    }
    let (before, after) = (numbers(old), numbers(&new.scene));
    if before.len() != after.len() {
        return None;
    }
    let mut copy = copy.clone();
    for (before, after) in before.iter().zip(&after) {
        if before.formula.map(Value::nodes) != after.formula.map(Value::nodes) {
            let (from, to) = (number(before.formula?)?, number(after.formula?)?);
            if result(&copy.tape, before.function, before.result) != Some(from) {
                return None;
            }
            copy.tape.set_number(before.function, before.result, to);
            if let Some(name) = before.parameter {
                let cell = |value: f64| format!("| `{name}` | `{value:?}` |");
                if !copy.derivation.contains(&cell(from)) {
                    return None;
                }
                copy.derivation = copy.derivation.replacen(&cell(from), &cell(to), 1);
            }
        }
    }
    let path = new.path.display().to_string();
    copy.code = rust::text(&Code { path: &path, scene: &new.scene, source: &new.source, tape: &copy.tape });
    Some(copy)
}

/// The text of a scene without replaceable numbers, and without parts that do not affect its module.
fn formulae(source: &str) -> Option<String> {
    without_layout(source, |keys, is_number| match keys {
        ["drawing" | "extreme" | "reference", ..] => true,
        ["parameters" | "initial" | "run", ..] => is_number,
        _ => false,
    })
}

/// Whether the generated code omits each parameter.
fn left_out(scene: &Scene) -> Vec<bool> {
    scene.parameters.iter().map(|parameter| parameter.left_out).collect()
}

/// A number of a scene, and the result of the function that returns it.
struct Number<'s> {
    function: &'static str,
    result: usize,
    /// The name of its parameter, if it is the value of one.
    parameter: Option<&'s str>,
    formula: Option<&'s Value>,
}

/// All numbers of a scene that can change without changing formulae.
fn numbers(scene: &Scene) -> Vec<Number<'_>> {
    let kept = scene.parameters.iter().filter(|parameter| !parameter.left_out).enumerate();
    let parameters = kept.map(|(result, parameter)| Number {
        function: "parameters",
        result,
        parameter: Some(&parameter.name),
        formula: Some(&parameter.formula),
    });
    let positions = scene.coordinates.iter().map(|coordinate| &coordinate.position);
    let rates = scene.coordinates.iter().map(|coordinate| &coordinate.rate);
    let starts = positions.chain(rates).enumerate().map(|(result, start)| {
        let formula = match start {
            Start::Given(value) | Start::Guess(value) => Some(value),
            Start::Free => None,
        };
        Number { function: "start", result, parameter: None, formula }
    });
    let schedule = [&scene.run.step, &scene.run.end_time].into_iter().enumerate();
    let schedule = schedule.map(|(result, formula)| Number {
        function: "schedule",
        result,
        parameter: None,
        formula: Some(formula),
    });
    parameters.chain(starts).chain(schedule).collect()
}

/// The value of a formula that is a single number.
fn number(formula: &Value) -> Option<f64> {
    match formula.nodes() {
        [Node::Number(number)] => Some(number.value),
        [Node::Number(number), Node::Negate(0)] => Some(-number.value),
        _ => None,
    }
}

/// The value of a function's result that is a number.
fn result(tape: &NamedTape, function: &str, result: usize) -> Option<f64> {
    let value = tape.function(function)?.results().nth(result)?;
    match tape.values()[value as usize] {
        TapeValue::Operation(Operation::Number(number)) => Some(number),
        _ => None,
    }
}
