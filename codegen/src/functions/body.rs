//! Straight-line function bodies: sines and cosines first, then named intermediate values, then the result.

mod operations;

use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};

use qrm_core::Operation;
use qrm_scene::function::Function;

use super::naming::{power_name, untaken};
use crate::graph::{Graph, Id, Op, Signed};
use qrm_core::NamedTape;
use qrm_core::named_tape::Statement;

/// Creates the statements of one function.
pub(super) struct Body<'g> {
    graph: &'g Graph,
    tape: &'g RefCell<NamedTape>,
    /// Values defined outside the function: inputs, parameters, precomputed constants.
    predefined: &'g HashMap<Id, u32>,
    uses: HashMap<Id, usize>,
    /// The sine and the cosine of each angle that the function needs.
    angles: BTreeMap<Id, [Option<Id>; 2]>,
    hints: &'g HashMap<Id, String>,
    taken: HashSet<String>,
    names: HashMap<Id, String>,
    /// The values with a name.
    values: HashMap<Id, u32>,
    statements: Vec<Statement>,
    /// The comment of the next statement.
    comment: Option<&'static str>,
    unnamed: usize,
    /// The depth of each value, that is, the work before it is available; set if depth determines the order of
    /// operations.
    depths: Option<&'g [u32]>,
}

impl<'g> Body<'g> {
    /// Computes `roots`. Values with a name outside the function are not computed; `named` values get their own
    /// statement even if they are used only once.
    pub(super) fn new(
        (graph, tape): (&'g Graph, &'g RefCell<NamedTape>),
        predefined: &'g HashMap<Id, u32>,
        hints: &'g HashMap<Id, String>,
        named: &HashSet<Id>,
        taken: HashSet<String>,
        roots: &[Signed],
    ) -> Self {
        let mut body = Self::begin((graph, tape), predefined, hints, taken, roots, None);
        body.define_all(roots, named);
        body
    }

    /// Creates an empty body. If the `depths` of values are given, products and sums are fused, deepest last.
    pub(super) fn begin(
        (graph, tape): (&'g Graph, &'g RefCell<NamedTape>),
        predefined: &'g HashMap<Id, u32>,
        hints: &'g HashMap<Id, String>,
        taken: HashSet<String>,
        roots: &[Signed],
        depths: Option<&'g [u32]>,
    ) -> Self {
        let mut body = Self {
            graph,
            tape,
            predefined,
            uses: HashMap::new(),
            angles: BTreeMap::new(),
            hints,
            taken,
            names: HashMap::new(),
            values: HashMap::new(),
            statements: Vec::new(),
            comment: None,
            unnamed: 0,
            depths,
        };
        let needed = body.needed(roots);
        for root in roots {
            *body.uses.entry(root.id).or_default() += 1;
        }
        for &id in &needed {
            for operand in graph.op(id).operands() {
                *body.uses.entry(operand).or_default() += 1;
            }
            match graph.op(id) {
                Op::Call(Function::Sin, angle) => body.angles.entry(*angle).or_default()[0] = Some(id),
                Op::Call(Function::Cos, angle) => body.angles.entry(*angle).or_default()[1] = Some(id),
                _ => {}
            }
        }
        body
    }

    /// Defines values that are used more than once on the way to `roots`, and all `named` values.
    pub(super) fn define_all(&mut self, roots: &[Signed], named: &HashSet<Id>) {
        let graph = self.graph;
        let needed = self.needed(roots);
        // Inputs first.
        let angles = needed.iter().filter_map(|&id| self.angle(id)).filter(|&angle| graph.op(angle).is_leaf());
        for angle in angles.collect::<BTreeSet<Id>>() {
            self.define_pair(angle);
        }
        for id in needed {
            if self.values.contains_key(&id) || graph.op(id).is_leaf() {
                continue;
            }
            if let Some(angle) = self.angle(id) {
                self.define_pair(angle);
            } else if self.uses[&id] > 1 || named.contains(&id) {
                self.define(id);
            }
        }
    }

    /// Defines a value under a name; from now on `input` represents it.
    pub(super) fn define_local(&mut self, value: Id, input: Id, name: &str, named: &HashSet<Id>) {
        if let Some(&predefined) = self.predefined.get(&value) {
            self.values.insert(input, predefined);
            let name = || self.tape.borrow().names.get(&predefined).cloned();
            let hint = self.hints.get(&value).cloned().or_else(name);
            self.names.extend(hint.map(|hint| (input, hint)));
            return;
        }
        let only: Vec<Signed> =
            self.graph.op(value).operands().iter().map(|&id| Signed { negative: false, id }).collect();
        self.define_all(&only, named);
        if !self.values.contains_key(&value) {
            let computed = self.compute(value);
            let name = self.name(value, Some(name.to_owned()));
            self.push(computed, vec![name], &[value]);
        }
        self.values.insert(input, self.values[&value]);
        self.names.insert(input, self.names[&value].clone());
    }

    /// Sets the comment before the next statement.
    pub(super) fn comment(&mut self, text: &'static str) {
        self.comment = Some(text);
    }

    /// Discards a comment that no statement followed.
    pub(super) fn end_comment(&mut self) {
        self.comment = None;
    }

    /// Adds a statement that names a value, or a pair of sine and cosine.
    fn push(&mut self, value: u32, names: Vec<String>, ids: &[Id]) {
        for (id, value) in ids.iter().zip(value..) {
            self.values.insert(*id, value);
        }
        self.statements.push(Statement { comment: self.comment.take().map(str::to_owned), value, names });
    }

    fn operation(&self, operation: Operation) -> u32 {
        self.tape.borrow_mut().operation(operation)
    }

    /// The name of a defined value.
    pub(super) fn name_of(&self, id: Id) -> Option<&str> {
        self.names.get(&id).map(String::as_str)
    }

    /// The values to compute, operands first.
    fn needed(&self, roots: &[Signed]) -> Vec<Id> {
        let mut needed = BTreeSet::new();
        let mut pending: Vec<Id> = roots.iter().map(|r| r.id).collect();
        while let Some(id) = pending.pop() {
            if !self.predefined.contains_key(&id) && !self.values.contains_key(&id) && needed.insert(id) {
                pending.extend(self.graph.op(id).operands());
            }
        }
        needed.into_iter().collect()
    }

    /// The angle of an operation that is a sine or cosine.
    fn angle(&self, id: Id) -> Option<Id> {
        match self.graph.op(id) {
            Op::Call(Function::Sin | Function::Cos, angle) => Some(*angle),
            _ => None,
        }
    }

    /// Defines the sine and cosine of an angle by one operation.
    fn define_pair(&mut self, angle: Id) {
        let pair = self.angles[&angle];
        let value = self.value(angle);
        let hint = self.descriptive_name(angle);
        let names = [("sin", pair[0]), ("cos", pair[1])].map(|(what, id)| {
            let id = id?;
            Some((id, self.name(id, hint.as_ref().map(|angle| format!("{what}_{angle}")))))
        });
        match names {
            [Some((sine, sine_name)), Some((cosine, cosine_name))] => {
                let value = self.operation(Operation::SinCos(value));
                self.push(value, vec![sine_name, cosine_name], &[sine, cosine]);
            }
            [sine, cosine] => {
                let operation = if sine.is_some() { Operation::Sin } else { Operation::Cos };
                let value = self.operation(operation(value));
                if let Some((id, name)) = sine.or(cosine) {
                    self.push(value, vec![name], &[id]);
                }
            }
        }
    }

    fn define(&mut self, id: Id) {
        let value = self.compute(id);
        let hint = self.descriptive_name(id);
        let name = self.name(id, hint);
        self.push(value, vec![name], &[id]);
    }

    /// A short descriptive name of a value, if there is one.
    fn descriptive_name(&self, id: Id) -> Option<String> {
        if let Some(name) = self.names.get(&id).or_else(|| self.hints.get(&id)) {
            return Some(name.clone());
        }
        let name = match self.graph.op(id) {
            Op::Reciprocal(a) => format!("inv_{}", self.descriptive_name(*a)?),
            Op::Call(Function::Sqrt, _) => "root".to_owned(),
            Op::Product(factors) => {
                let mut names: Vec<String> = Vec::new();
                for (i, &factor) in factors.iter().enumerate() {
                    let times = factors.iter().filter(|&&f| f == factor).count();
                    if factors[..i].contains(&factor) {
                        continue;
                    }
                    let name = self.descriptive_name(factor)?;
                    names.push(power_name(name, times));
                }
                names.join("_")
            }
            _ => return None,
        };
        (name.len() <= 24).then_some(name)
    }

    /// Assigns an unused name to a value.
    fn name(&mut self, id: Id, hint: Option<String>) -> String {
        let wish = hint.unwrap_or_else(|| {
            self.unnamed += 1;
            format!("v{}", self.unnamed)
        });
        let name = untaken(wish, &mut self.taken);
        self.names.insert(id, name.clone());
        name
    }

    /// Returns the value; computes it if it has no name.
    pub(super) fn value(&mut self, id: Id) -> u32 {
        let known = self.predefined.get(&id).or_else(|| self.values.get(&id));
        known.copied().unwrap_or_else(|| self.compute(id))
    }

    /// The value of a root.
    pub(super) fn root(&mut self, root: Signed) -> u32 {
        let value = self.value(root.id);
        if root.negative { self.tape.borrow_mut().negative(value) } else { value }
    }

    /// Returns the statements.
    pub(super) fn finish(self) -> Vec<Statement> {
        self.statements
    }
}
