//! An order of operations in which those of one kind stand together: they are interpreted faster.

use std::collections::{BTreeSet, HashMap};

use qrm_core::OperationKind;

use super::super::trace::{Entry, Trace, Traced};

/// Values in an order in which operands come first.
///
/// Of one kind as many follow each other as have their operands; then comes the kind that most are ready of.
pub(super) fn scheduled(trace: &Trace, needed: &[Traced]) -> Vec<Traced> {
    let mut waiting: HashMap<u32, usize> = HashMap::with_capacity(needed.len());
    let mut uses: HashMap<u32, Vec<u32>> = HashMap::new();
    let mut ready: [BTreeSet<u32>; 3] = Default::default();
    let place = |value: u32| kind(trace, value) as usize;
    for &Traced(value) in needed {
        let Entry::Operation(operation) = trace.entries[value as usize] else { continue };
        let mut operands = 0;
        operation.for_each_operand(|operand| {
            // A cosine is there with its sine.
            let source = if matches!(trace.entries[operand as usize], Entry::Cosine) { operand - 1 } else { operand };
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
        order.push(Traced(value));
        if matches!(trace.entries.get(value as usize + 1), Some(Entry::Cosine)) {
            order.push(Traced(value + 1));
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

fn kind(trace: &Trace, value: u32) -> OperationKind {
    match trace.entries[value as usize] {
        Entry::Operation(operation) => operation.kind(),
        Entry::Input | Entry::Cosine => OperationKind::Other,
    }
}
