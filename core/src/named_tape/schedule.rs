//! An order of operations in which those of one kind stand together: they are interpreted fast.

use std::cmp::Reverse;
use std::collections::{BTreeSet, HashMap};
use std::vec;
use std::vec::Vec;

use super::{NamedTape, Value};
use crate::tape::Operation;

/// Values in an order in which operands come first.
///
/// Of one kind as many follow each other as have their operands, those before the longest chains of others first. Then
/// comes a kind with many of them, before a long chain: the processor waits for results of chains, and foresees
/// long runs of one kind.
pub(super) fn scheduled(tape: &NamedTape, needed: &[u32]) -> Vec<u32> {
    // A cosine is there with its sine.
    let source = |value: u32| value - u32::from(matches!(tape.values[value as usize], Value::Cosine));
    let kind = |value: u32| match tape.values[value as usize] {
        Value::Operation(operation) => operation.kind(),
        Value::Input | Value::Cosine => Operation::OTHER,
    };
    let mut chains = vec![0; tape.values.len()];
    for &value in needed.iter().rev() {
        let Value::Operation(operation) = tape.values[value as usize] else { continue };
        let chain = chains[value as usize] + 1;
        chains[value as usize] = chain;
        operation.for_each_operand(|operand| {
            let behind = &mut chains[source(operand) as usize];
            *behind = chain.max(*behind);
        });
    }
    let place = |value: u32| (Reverse(chains[value as usize]), value);
    let mut waiting: HashMap<u32, usize> = HashMap::with_capacity(needed.len());
    let mut uses: HashMap<u32, Vec<u32>> = HashMap::new();
    let mut ready: [BTreeSet<(Reverse<usize>, u32)>; Operation::OTHER + 1] = Default::default();
    for &value in needed {
        let Value::Operation(operation) = tape.values[value as usize] else { continue };
        let mut operands = 0;
        operation.for_each_operand(|operand| {
            if waiting.contains_key(&source(operand)) {
                uses.entry(source(operand)).or_default().push(value);
                operands += 1;
            }
        });
        waiting.insert(value, operands);
        if operands == 0 {
            ready[kind(value)].insert(place(value));
        }
    }
    let mut order = Vec::with_capacity(needed.len());
    let mut current = 0;
    loop {
        if ready[current].is_empty() {
            let gain =
                |list: &BTreeSet<(Reverse<usize>, u32)>| list.first().map_or(0, |first| 2 * first.0.0 + list.len());
            current = (0..ready.len()).max_by_key(|&kind| gain(&ready[kind])).unwrap_or(0);
        }
        let Some((_, value)) = ready[current].pop_first() else { return order };
        order.push(value);
        if matches!(tape.values.get(value as usize + 1), Some(Value::Cosine)) {
            order.push(value + 1);
        }
        for user in uses.remove(&value).unwrap_or_default() {
            let left = waiting.entry(user).or_default();
            *left -= 1;
            if *left == 0 {
                ready[kind(user)].insert(place(user));
            }
        }
    }
}
