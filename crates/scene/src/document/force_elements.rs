//! Gas springs and motors, as springs and laws.

use super::reader::{self, Reader};
use super::table::Table;
use crate::linkage::terms::{add, divide, multiply, name, subtract, whole};
use crate::parser::Formula;
use crate::unit::Unit;

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
pub(super) fn motor(r: &mut Reader, table: &Table, unit: Option<&Unit>) -> Option<Formula> {
    let value = table.optional("motor")?;
    let mut quantity = |value: reader::Value, of_length: Option<Unit>| {
        let (formula, dimension) = r.with_dimension(value, None);
        r.check_dimension(&formula, &dimension, of_length.as_ref());
        formula
    };
    let stall = quantity(value, Unit::parse("J").zip(unit).map(|(energy, unit)| energy.times(unit, -1)));
    let speed = Unit::parse("1/s").zip(unit).map(|(rate, unit)| rate.times(unit, 1));
    let no_load = table.optional("no_load").map(|value| quantity(value, speed));
    let no_load = no_load.unwrap_or_else(|| {
        table.required(r, "no_load");
        reader::placeholder()
    });
    let rate = name("s_dot", &value.span());
    Some(multiply(stall, subtract(whole(1), divide(rate, no_load))))
}
