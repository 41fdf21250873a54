//! Helpers for the names of values.

use std::collections::HashSet;

/// The name of a power.
pub(super) fn power_name(name: String, times: usize) -> String {
    match times {
        1 => name,
        2 => format!("{name}_sq"),
        _ => format!("{name}_pow{times}"),
    }
}

/// Reserves an unused name: `wish`, or `wish` with a number.
pub(super) fn untaken(wish: String, taken: &mut HashSet<String>) -> String {
    let mut name = wish.clone();
    let mut number = 2;
    while !taken.insert(name.clone()) {
        name = format!("{wish}_{number}");
        number += 1;
    }
    name
}
