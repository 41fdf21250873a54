//! An order of operations that groups operations of one kind: such tapes run faster.

use std::cmp::Reverse;
use std::collections::{BTreeSet, HashMap};
use std::vec;
use std::vec::Vec;

use super::{NamedTape, Value};
use crate::tape::Operation;

/// Orders values so that operands come first.
///
/// Operations of one kind follow each other as long as their operands are available; those that the longest chains
/// depend on come first. The next kind is the one with many available operations and a long chain: the processor waits
/// for the results of chains, and predicts long runs of one kind.
pub(super) fn ordered(tape: &NamedTape, needed: &[u32]) -> Vec<u32> {
    // A cosine is computed with its sine.
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
