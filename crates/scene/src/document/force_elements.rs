//! Gas springs and motors, as springs and laws.

use super::reader::{self, Reader};
use super::table::Table;
use crate::linkage::terms::{add, divide, multiply, name, subtract, whole};
use crate::parser::Formula;

/// Reads a gas spring with the force `F` at its `extended` length, and the force `ratio F` after its `stroke`; returns
/// the stiffness and the free length of the spring that gives the same forces:
///
/// ```text
/// k = (ratio - 1) F / stroke,  s0 = extended + stroke/(ratio - 1)
/// ```
pub(super) fn gas_spring(r: &mut Reader, table: &Table) -> Option<[Formula; 2]> {
    let force = table.optional("gas_spring").map(|v| r.quantity(v, "N"))?;
    let mut needed = |key: &str, unit: &str| {
        table.required(r, key).map_or_else(reader::placeholder, |value| r.quantity(value, unit))
    };
    let (extended, stroke, ratio) = (needed("extended", "m"), needed("stroke", "m"), needed("ratio", "-"));
    let progression = subtract(ratio, whole(1));
    let stiffness = divide(multiply(force, progression.clone()), stroke.clone());
    Some([stiffness, add(extended, divide(stroke, progression))])
}

/// Reads a motor whose torque or force falls linearly from its value at rest to zero at the speed `no_load`:
///
/// ```text
/// motor (1 - s_dot/no_load)
/// ```
pub(super) fn motor(r: &mut Reader, table: &Table, unit: Option<&str>) -> Option<Formula> {
    let value = table.optional("motor")?;
    let (force, speed) = match unit {
        Some("m") => ("N", "m/s"),
        _ => ("N m", "rad/s"),
    };
    let stall = if unit.is_some() { r.quantity(value, force) } else { r.formula(value) };
    let no_load = table.required(r, "no_load").map_or_else(reader::placeholder, |value| match unit {
        Some(_) => r.quantity(value, speed),
        None => r.formula(value),
    });
    let rate = name("s_dot", &value.span());
    Some(multiply(stall, subtract(whole(1), divide(rate, no_load))))
}
