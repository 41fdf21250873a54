//! The tape in the text of a generated module, as far as numbers are replaced in it.

use std::ops::Range;

use crate::values::Change;

/// The beginning of the item.
const HEAD: &str = "\npub static TAPE: qrm_core::Tape = {";
/// The longest line.
const WIDTH: usize = 120;

/// The functions of a tape in which numbers are replaced.
pub(crate) struct TapeText {
    /// The place of the first value of a function.
    base: usize,
    functions: Vec<Function>,
}

/// A function of the tape.
struct Function {
    name: &'static str,
    /// Its text in the module.
    range: Range<usize>,
    operations: Vec<String>,
    /// Places of the results.
    results: Vec<usize>,
}

impl TapeText {
    /// The tape of a module.
    pub(crate) fn new(code: &str) -> Option<Self> {
        let start = code.find(HEAD)?;
        let field =
            |name: &str| code[start..].find(&format!("\n        {name}: ")).map(|at| start + at + name.len() + 11);
        let size = |name: &str| -> Option<usize> { code[field(name)?..].split_once(',')?.0.parse().ok() };
        let (n, m) = (size("coordinates")?, size("constraints")?);
        let mut functions = Vec::new();
        for name in ["parameters", "start", "schedule"] {
            let start = field(name)?;
            let range = start..start + code[start..].find("\n        }")?;
            let (_, operations) = code[range.clone()].split_once("operations: &[")?;
            let (_, results) = code[range.clone()].split_once("results: &[")?;
            let results = items(results).iter().map(|place| place.parse().ok()).collect::<Option<_>>()?;
            functions.push(Function { name, range, operations: items(operations), results });
        }
        let (_, constants) = code[field("constants")?..].split_once('[')?;
        let constants: usize = items(constants).iter().map(|operation| places(operation)).sum();
        // Parameters, time, q, qd, qdd, multipliers, sines, cosines and residuals stand before the constants.
        let base = functions[0].results.len() + 1 + 5 * n + 2 * m + constants;
        Some(Self { base, functions })
    }

    fn function(&mut self, name: &str) -> Option<&mut Function> {
        self.functions.iter_mut().find(|function| function.name == name)
    }

    /// Replaces a result that is a number, by a further operation.
    pub(crate) fn set(&mut self, function: &str, result: usize, change: &Change) -> Option<()> {
        let base = self.base;
        let function = self.function(function)?;
        let place = base + function.operations.iter().map(|operation| places(operation)).sum::<usize>();
        function.operations.push(format!("Number({:?})", change.to));
        *function.results.get_mut(result)? = place;
        Some(())
    }

    /// Replaces the number of a parameter. Values of parameters follow from those before them, by the operations up to
    /// their results, so the new one stands behind those of the parameters before it.
    pub(crate) fn set_parameter(&mut self, parameter: usize, change: &Change) -> Option<()> {
        let base = self.base;
        let Function { operations, results, .. } = self.function("parameters")?;
        let own = *results.get(parameter)?;
        let number = format!("Number({:?})", change.from);
        if operations.iter().any(|operation| places(operation) != 1)
            || *operations.get(own.checked_sub(base)?)? != number
        {
            return None;
        }
        let place = results[..parameter].iter().map(|result| result + 1).max().unwrap_or(base);
        let moved = |place_now: usize| if place_now >= place { place_now + 1 } else { place_now };
        for operation in operations.iter_mut() {
            *operation = with_operands(operation, moved)?;
        }
        results.iter_mut().for_each(|result| *result = moved(*result));
        results[parameter] = place;
        operations.insert(place - base, format!("Number({:?})", change.to));
        Some(())
    }

    /// The module with this tape.
    pub(crate) fn written(&self, code: &str) -> Option<String> {
        let mut code = code.to_owned();
        for function in self.functions.iter().rev() {
            code.replace_range(function.range.clone(), &function.text());
        }
        Some(code)
    }
}

impl Function {
    fn text(&self) -> String {
        let results: Vec<String> = self.results.iter().map(usize::to_string).collect();
        format!(
            "TapeFunction {{\n            operations: {},\n            results: {},",
            list(&self.operations),
            list(&results)
        )
    }
}

/// A list on one line, or else in lines as long as they may be.
fn list(items: &[String]) -> String {
    let whole = items.join(", ");
    if "            operations: &[],".len() + whole.len() <= WIDTH {
        return format!("&[{whole}]");
    }
    let mut lines = vec![String::new()];
    for item in items {
        if lines.last().is_some_and(|line| line.len() + item.len() + 20 > WIDTH) {
            lines.push(String::new());
        }
        if let Some(line) = lines.last_mut() {
            *line += &format!(" {item},");
        }
    }
    let lines: String = lines.iter().map(|line| format!("\n               {line}")).collect();
    format!("&[{lines}\n            ]")
}

/// The items of a list that begins here.
fn items(text: &str) -> Vec<String> {
    let (mut items, mut depth, mut start) = (Vec::new(), 0, 0);
    for (at, character) in text.char_indices() {
        match character {
            '(' => depth += 1,
            ')' => depth -= 1,
            ',' | ']' if depth == 0 => {
                items.push(text[start..at].trim().to_owned());
                start = at + 1;
            }
            _ => {}
        }
        if character == ']' {
            break;
        }
    }
    items.retain(|item| !item.is_empty());
    items
}

/// How many values an operation has.
fn places(operation: &str) -> usize {
    if operation.starts_with("SinCos") { 2 } else { 1 }
}

/// An operation with other places of its operands.
fn with_operands(operation: &str, place: impl Fn(usize) -> usize) -> Option<String> {
    let Some((name, operands)) = operation.strip_suffix(')').and_then(|text| text.split_once('(')) else {
        return Some(operation.to_owned());
    };
    // The others have an exponent, or a number, behind.
    let count = match name {
        "Number" => 0,
        "PowI" | "PowF" => 1,
        _ => usize::MAX,
    };
    let operands = operands.split(", ").enumerate().map(|(i, operand)| match i < count {
        true => operand.parse().ok().map(|operand| place(operand).to_string()),
        false => Some(operand.to_owned()),
    });
    Some(format!("{name}({})", operands.collect::<Option<Vec<_>>>()?.join(", ")))
}

#[cfg(test)]
mod tests {
    use super::*;

    const CODE: &str = "
pub static TAPE: qrm_core::Tape = {
    use qrm_core::Operation::*;
    qrm_core::Tape {
        coordinates: 1,
        constraints: 0,
        parameters: TapeFunction {
            operations: &[
                Number(2.0), PowI(0, 2), Number(0.5), Mul(13, 14),
            ],
            results: &[12, 15, 12],
        },
        constants: &[Mul(0, 0), Number(0.1), Number(9.0)],
        start: TapeFunction {
            operations: &[],
            results: &[10, 11],
        },
        schedule: TapeFunction {
            operations: &[],
            results: &[10, 11],
        },
    }
};
";

    /// Parameters `[2, a^2/2, 2]`, one of which becomes 3; arguments take the places 3 to 8.
    fn with(parameter: usize) -> String {
        let mut tape = TapeText::new(CODE).expect("a tape");
        assert_eq!(tape.base, 12);
        tape.set_parameter(parameter, &Change { from: 2.0, to: 3.0 }).expect("a number");
        tape.written(CODE).expect("a text").split_whitespace().collect::<Vec<_>>().join(" ")
    }

    #[test]
    fn a_parameter_that_shares_its_number_gets_one_of_its_own() {
        let first = with(0);
        assert!(first.contains("&[Number(3.0), Number(2.0), PowI(0, 2), Number(0.5), Mul(14, 15)]"), "{first}");
        assert!(first.contains("results: &[12, 16, 13]"), "{first}");
        let last = with(2);
        assert!(last.contains("&[Number(2.0), PowI(0, 2), Number(0.5), Mul(13, 14), Number(3.0)]"), "{last}");
        assert!(last.contains("results: &[12, 15, 16]"), "{last}");
    }

    #[test]
    fn a_parameter_that_is_no_such_number_is_refused() {
        let mut tape = TapeText::new(CODE).expect("a tape");
        assert_eq!(tape.set_parameter(1, &Change { from: 2.0, to: 3.0 }), None);
        assert_eq!(tape.set_parameter(0, &Change { from: 2.5, to: 3.0 }), None);
    }

    #[test]
    fn a_start_gets_a_number_of_its_own() {
        let mut tape = TapeText::new(CODE).expect("a tape");
        tape.set("start", 1, &Change { from: 9.0, to: 8.0 }).expect("a number");
        let text = tape.written(CODE).expect("a text").split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(text.contains("start: TapeFunction { operations: &[Number(8.0)], results: &[10, 12], }"), "{text}");
    }
}
