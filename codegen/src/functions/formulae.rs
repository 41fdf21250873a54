//! Formulae of a function's values, for its documentation.

use crate::formula::Writer;
use crate::term::{Symbol, Term};
use qrm_core::named_tape::Shape;

/// The longest formula in documentation; longer ones are easier to read in the derivation.
const LONGEST: usize = 400;
/// The largest number of formulae in documentation.
const MOST: usize = 60;

/// Writes the nonzero values with their formulae, and the formulae of the named roots in them.
pub(super) fn block(writer: &Writer, rows: &[String], columns: &[String], shape: &Shape<&Term>) -> String {
    let is_from_recursion =
        |term: &&&Term| matches!(term, Term::Symbol(Symbol::Momentum(_) | Symbol::GeneralizedForce(_)));
    if shape.values().iter().any(is_from_recursion) {
        return String::from("\n\nThe derivation of the scene describes how it is computed.");
    }
    let entries: Vec<(String, &Term)> = match shape {
        Shape::Scalar(term) => vec![(String::new(), *term)],
        Shape::Vector(terms) => rows.iter().cloned().zip(terms.iter().copied()).collect(),
        Shape::Matrix(matrix) => {
            let names = rows.iter().flat_map(|row| columns.iter().map(move |column| format!("{row}, {column}")));
            names.zip(matrix.iter().flatten().copied()).collect()
        }
    };
    let entries: Vec<(String, &Term)> = entries.into_iter().filter(|(_, term)| !term.is_zero()).collect();
    let lines: Vec<(String, String)> = entries.into_iter().map(|(name, term)| (name, writer.term(term))).collect();
    if lines.is_empty() {
        return String::from("\n\nAll of it is zero.");
    }
    if lines.len() > MOST || lines.iter().any(|(_, formula)| formula.len() > LONGEST) {
        return String::from("\n\nIts formulae stand in the derivation of the scene.");
    }
    // A named root is explained where it is used.
    let is_used = |name: &str| {
        let words = |text: &str| text.split(|c: char| !c.is_ascii_alphanumeric() && c != '_').any(|word| word == name);
        lines.iter().any(|(_, formula)| words(formula))
    };
    let roots = writer.roots().into_iter().filter(|(name, _)| is_used(name));
    let lines: Vec<(String, String)> = roots.chain(lines.clone()).collect();
    let width = lines.iter().map(|(name, _)| name.len()).max().unwrap_or(0);
    let line = |(name, formula): &(String, String)| match width {
        0 => formula.clone(),
        _ => format!("{name:width$}  {formula}"),
    };
    format!("\n\n```text\n{}\n```", lines.iter().map(line).collect::<Vec<_>>().join("\n"))
}
