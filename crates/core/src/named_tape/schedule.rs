//! An order of operations that groups operations of one kind: such tapes run faster.

use std::collections::{BTreeSet, HashMap};
use std::vec::Vec;

use super::{NamedTape, Value};
use crate::tape::OperationKind;

/// Orders values so that operands come first.
///
/// Operations of one kind follow each other as long as their operands are available; then the kind with the most
/// available operations comes next.
pub(super) fn scheduled(tape: &NamedTape, needed: &[u32]) -> Vec<u32> {
    let mut waiting: HashMap<u32, usize> = HashMap::with_capacity(needed.len());
    let mut uses: HashMap<u32, Vec<u32>> = HashMap::new();
    let mut ready: [BTreeSet<u32>; 3] = Default::default();
    let place = |value: u32| kind(tape, value) as usize;
    for &value in needed {
        let Value::Operation(operation) = tape.values[value as usize] else { continue };
        let mut operands = 0;
        operation.for_each_operand(|operand| {
            // A cosine is computed with its sine.
            let source = if matches!(tape.values[operand as usize], Value::Cosine) { operand - 1 } else { operand };
            if waiting.contains_key(&source) {
                uses.entry(source).or_default().push(value);
                operands += 1;
            }
        });
        waiting.insert(value, operands);
        if operands == 0 {
            ready[place(value)].insert(value);
        }
    }
    let mut order = Vec::with_capacity(needed.len());
    let mut current = 0;
    loop {
        if ready[current].is_empty() {
            let most = (0..ready.len()).rev().max_by_key(|&kind| ready[kind].len());
            current = most.unwrap_or(0);
        }
        let Some(value) = ready[current].pop_first() else { return order };
        order.push(value);
        if matches!(tape.values.get(value as usize + 1), Some(Value::Cosine)) {
            order.push(value + 1);
        }
        for user in uses.remove(&value).unwrap_or_default() {
            let left = waiting.entry(user).or_default();
            *left -= 1;
            if *left == 0 {
                ready[place(user)].insert(user);
            }
        }
    }
}

fn kind(tape: &NamedTape, value: u32) -> OperationKind {
    match tape.values[value as usize] {
        Value::Operation(operation) => operation.kind(),
        Value::Input | Value::Cosine => OperationKind::Other,
    }
}
