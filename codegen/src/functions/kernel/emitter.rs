//! Common parts of the functions of a kernel: available values, and the statements of a body.

use std::collections::{HashMap, HashSet};

use qrm_scene::function::Function as Call;

use crate::functions::body::Body;
use crate::functions::{Writer, reserved};
use crate::graph::{Graph, Id, Op, Signed};
use crate::kernel::{Block, Kernel, Local};
use crate::term::Symbol;
use qrm_core::named_tape::{Argument, Function, ResultField, Shape, place};

/// Creates the functions of a kernel.
pub(in crate::functions) struct Emitter<'a> {
    pub(super) writer: &'a Writer<'a>,
    pub(super) kernel: &'a Kernel,
    pub(super) graph: &'a Graph,
    /// The inputs of every function: arguments, parameters, constants, sines and cosines.
    pub(super) predefined: HashMap<Id, u32>,
    /// Whether each value follows from the position alone.
    pub(super) is_position: Vec<bool>,
    depths: Vec<u32>,
    taken: HashSet<String>,
}

impl<'a> Emitter<'a> {
    /// Creates the emitter; with `has_angles` the functions take sines and cosines as arguments, otherwise they compute
    /// them.
    pub(in crate::functions) fn new(writer: &'a Writer<'a>, kernel: &'a Kernel, has_angles: bool) -> Self {
        let graph = writer.graph;
        let n = place(writer.scene.coordinates.len());
        let mut predefined = writer.predefined.clone();
        for (id, op) in graph.ops().iter().enumerate().filter(|_| has_angles) {
            if let Some((function, i)) = angle_of(graph, op) {
                let sine = writer.tape.borrow().sine(i);
                predefined.insert(id, if function == Call::Sin { sine } else { sine + n });
            }
        }
        let mut taken = reserved();
        let results = |id: Id| matches!(graph.op(id), Op::Input(Symbol::Acceleration(_) | Symbol::Multiplier(_)));
        let tape = writer.tape.borrow();
        let given = predefined.iter().filter(|(id, _)| !results(**id) && !graph.is_constant(**id));
        taken.extend(given.filter_map(|(_, value)| tape.names.get(value).cloned()));
        drop(tape);
        let inputs: HashMap<Id, &Local> = kernel.locals.iter().map(|local| (local.input.id, local)).collect();
        let mut emitter =
            Self { writer, kernel, graph, predefined, is_position: Vec::new(), depths: Vec::new(), taken };
        for (id, op) in graph.ops().iter().enumerate() {
            let local = inputs.get(&id);
            let follows = match (op, local) {
                (_, Some(local)) => local.block.is_position(),
                // If constraints or lengths depend on time, so does a position.
                (Op::Input(Symbol::Time), None) => kernel.is_timed,
                (Op::Input(symbol), None) => symbol.is_constant() || matches!(symbol, Symbol::Coordinate(_)),
                (op, None) => op.operands().iter().all(|&operand| emitter.is_position[operand]),
            };
            emitter.is_position.push(follows);
            let depth = emitter.depth(id, op, local.map(|local| local.value.id));
            emitter.depths.push(depth);
        }
        emitter
    }

    /// The approximate number of cycles until a value is available.
    fn depth(&self, id: Id, op: &Op, definition: Option<Id>) -> u32 {
        let deepest = op.operands().iter().map(|&operand| self.depths[operand]).max().unwrap_or(0);
        let more = |operands: usize| 3 * u32::try_from(operands.saturating_sub(1)).unwrap_or(u32::MAX / 4);
        match op {
            // Sines and cosines are available first.
            op if self.predefined.contains_key(&id) || angle_of(self.graph, op).is_some() => 0,
            Op::Input(_) => definition.map_or(0, |id| self.depths[id]),
            Op::Number(_) => 0,
            Op::Sum(terms) => deepest + more(terms.len()),
            Op::Product(factors) => deepest + more(factors.len()),
            Op::Reciprocal(_) => deepest + 13,
            Op::Power(..) | Op::Call(..) => deepest + 20,
        }
    }

    /// The value that each local represents.
    pub(super) fn definitions(&self) -> HashMap<Id, Id> {
        self.kernel.locals.iter().map(|local| (local.input.id, local.value.id)).collect()
    }

    /// The locals that results depend on, down to values defined outside.
    pub(super) fn needed_locals(
        &self,
        results: impl Iterator<Item = Signed>,
        predefined: &HashMap<Id, u32>,
    ) -> Vec<&Local> {
        let definitions = self.definitions();
        let mut pending: Vec<Id> = results.map(|root| root.id).collect();
        let mut needed = HashSet::new();
        while let Some(id) = pending.pop() {
            if !predefined.contains_key(&id) && needed.insert(id) {
                pending.extend(self.graph.op(id).operands());
                pending.extend(definitions.get(&id));
            }
        }
        self.kernel.locals.iter().filter(|local| needed.contains(&local.input.id)).collect()
    }

    pub(super) fn body<'b>(
        &'b self,
        predefined: &'b HashMap<Id, u32>,
        fields: &HashSet<String>,
        roots: &[Signed],
    ) -> Body<'b> {
        // The fields of a position are bound in the same scope.
        let taken = self.taken.union(fields).cloned().collect();
        let graph = (self.graph, &self.writer.tape);
        Body::begin(graph, predefined, &self.writer.hints, taken, roots, Some(&self.depths))
    }

    /// Creates a function without a position as argument.
    pub(in crate::functions) fn function_without_position(
        &self,
        name: &str,
        arguments: &[Argument],
        results: &[&[Signed]],
    ) -> Function {
        let ends: Vec<Signed> = results.iter().copied().flatten().copied().collect();
        let locals = self.needed_locals(ends.iter().copied(), &self.predefined);
        let roots: Vec<Signed> = locals.iter().map(|local| local.value).chain(ends.clone()).collect();
        let mut body = self.body(&self.predefined, &HashSet::new(), &roots);
        define(&mut body, &locals, &HashSet::new());
        body.define_all(&ends, &HashSet::new());
        let parts = vectors(&mut body, results);
        Function {
            name: name.to_owned(),
            arguments: arguments.to_vec(),
            statements: body.finish(),
            parts,
            ..Default::default()
        }
    }
}

/// A function of a kernel.
pub(super) struct KernelFunction<'k> {
    pub(super) name: &'static str,
    pub(super) doc: &'static str,
    pub(super) arguments: &'static [Argument],
    pub(super) blocks: &'static [Block],
    pub(super) results: Vec<&'k [Signed]>,
}

/// Returns results as lists.
pub(super) fn vectors(body: &mut Body, results: &[&[Signed]]) -> Vec<ResultField> {
    let part = |result: &&[Signed]| {
        let values = Shape::Vector(result.iter().map(|root| body.root(*root)).collect());
        ResultField { name: String::new(), doc: String::new(), values }
    };
    results.iter().map(part).collect()
}

/// Defines named values, with a comment where another block begins.
pub(super) fn define(body: &mut Body, locals: &[&Local], named: &HashSet<Id>) {
    let mut block = None;
    for local in locals {
        if block != Some(local.block) {
            body.comment(local.block.title());
            block = Some(local.block);
        }
        body.define_local(local.value.id, local.input.id, &local.name, named);
    }
    body.end_comment();
}

/// The coordinate of an operation that is a sine or cosine of one.
pub(super) fn angle_of(graph: &Graph, op: &Op) -> Option<(Call, usize)> {
    match op {
        Op::Call(function @ (Call::Sin | Call::Cos), angle) => match graph.op(*angle) {
            Op::Input(Symbol::Coordinate(i)) => Some((*function, *i)),
            _ => None,
        },
        _ => None,
    }
}
