//! Values that occur in several tables.

use super::reader::{self, Reader};
use super::{Identifier, Position, Side};
use crate::diagnostic::Diagnostic;

/// The name of a point, or two formulae.
pub(super) fn position(r: &mut Reader, value: reader::Value) -> Option<Position> {
    if value.is_array() {
        return Some(Position::Pair(r.pair(value, "m")));
    }
    if value.is_text() {
        return r.text(value).map(Position::Point);
    }
    r.wrong_type(value, "the name of a point or an array of two formulae, `['x', 'y']`");
    None
}

/// `<= 0` or `>= 0`.
pub(super) fn side(r: &mut Reader, text: &Identifier) -> Option<Side> {
    match text.name.replace(' ', "").as_str() {
        "<=0" => Some(Side::Below),
        ">=0" => Some(Side::Above),
        _ => {
            let error =
                Diagnostic::error(format!("`{}` is no side of zero", text.name), text.span.clone(), "not a side");
            r.findings.push(
                error.help("write `<= 0` for a rope, which gives way below its length, `>= 0` for a support or a cam"),
            );
            None
        }
    }
}
