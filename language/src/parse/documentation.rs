//! The text of documentation.

use syn::{Attribute, Expr, ExprLit, Lit, Meta};

/// The lines of the documentation; formulae in it are set in by four spaces.
pub(super) fn documentation(attributes: &[Attribute]) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    let mut in_formulae = false;
    for text in attributes.iter().filter_map(text) {
        for line in text.lines() {
            let line = line.strip_prefix(' ').unwrap_or(line);
            match line.starts_with("```") {
                true => in_formulae = !in_formulae,
                false if in_formulae => lines.push(format!("    {line}")),
                false => lines.push(line.to_owned()),
            }
        }
        if text.is_empty() {
            lines.push(String::new());
        }
    }
    lines
}

fn text(attribute: &Attribute) -> Option<String> {
    match &attribute.meta {
        Meta::NameValue(pair) if pair.path.is_ident("doc") => match &pair.value {
            Expr::Lit(ExprLit { lit: Lit::Str(text), .. }) => Some(text.value()),
            _ => None,
        },
        _ => None,
    }
}
