//! The kernel as functions: what follows from a position, and what is made of it.

use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};

use qrm_core::Operation;
use qrm_scene::function::Function as Call;

use super::Writer;
use super::body::Body;
use crate::graph::{Graph, Id, Op, Signed};
use crate::kernel::{Block, Kernel, Local};
use crate::term::Symbol;
use qrm_core::named_tape::{Argument, Function, Operations, Part, Shape, place};

/// A function of a kernel.
struct KernelFunction<'k> {
    name: &'static str,
    doc: &'static str,
    arguments: &'static [Argument],
    blocks: &'static [Block],
    results: Vec<&'k [Signed]>,
}

/// Makes the functions of a kernel.
pub(super) struct Emitter<'a> {
    writer: &'a Writer<'a>,
    kernel: &'a Kernel,
    graph: &'a Graph,
    /// The inputs of every function: arguments, parameters, constants, sines and cosines.
    outside: HashMap<Id, u32>,
    /// Whether each value follows from the position alone.
    is_position: Vec<bool>,
    depths: Vec<u32>,
    taken: HashSet<String>,
}

impl<'a> Emitter<'a> {
    /// The functions are given sines and cosines of the coordinates, or compute them.
    pub(super) fn new(writer: &'a Writer<'a>, kernel: &'a Kernel, has_angles: bool) -> Self {
        let graph = writer.graph;
        let n = place(writer.scene.coordinates.len());
        let mut outside = writer.outside.clone();
        for (id, op) in graph.ops().iter().enumerate().filter(|_| has_angles) {
            if let Some((function, i)) = angle_of(graph, op) {
                let sine = writer.tape.borrow().sine(i);
                outside.insert(id, if function == Call::Sin { sine } else { sine + n });
            }
        }
        let mut taken = super::reserved();
        let results = |id: Id| matches!(graph.op(id), Op::Input(Symbol::Acceleration(_) | Symbol::Multiplier(_)));
        let tape = writer.tape.borrow();
        let given = outside.iter().filter(|(id, _)| !results(**id) && !graph.is_constant(**id));
        taken.extend(given.filter_map(|(_, value)| tape.names.get(value).cloned()));
        drop(tape);
        let inputs: HashMap<Id, &Local> = kernel.locals.iter().map(|local| (local.input.id, local)).collect();
        let mut emitter = Self { writer, kernel, graph, outside, is_position: Vec::new(), depths: Vec::new(), taken };
        for (id, op) in graph.ops().iter().enumerate() {
            let local = inputs.get(&id);
            let follows = match (op, local) {
                (_, Some(local)) => local.block.is_position(),
                // Where closures or lengths need time, a position is one at a time.
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

    /// After about how many cycles a value is there.
    fn depth(&self, id: Id, op: &Op, definition: Option<Id>) -> u32 {
        let deepest = op.operands().iter().map(|&operand| self.depths[operand]).max().unwrap_or(0);
        let more = |operands: usize| 3 * u32::try_from(operands.saturating_sub(1)).unwrap_or(u32::MAX / 4);
        match op {
            // Sines and cosines are there before the rest.
            op if self.outside.contains_key(&id) || angle_of(self.graph, op).is_some() => 0,
            Op::Input(_) => definition.map_or(0, |id| self.depths[id]),
            Op::Number(_) => 0,
            Op::Sum(terms) => deepest + more(terms.len()),
            Op::Product(factors) => deepest + more(factors.len()),
            Op::Reciprocal(_) => deepest + 13,
            Op::Power(..) | Op::Call(..) => deepest + 20,
        }
    }

    /// Adds all functions to the tape.
    pub(super) fn add_functions(&self) {
        let kernel = self.kernel;
        let parts = [
            KernelFunction {
                name: "residuals",
                doc: "Residuals of the loop closures, `C(q)`.",
                arguments: &[Argument::Position],
                blocks: &[],
                results: vec![&kernel.residuals],
            },
            KernelFunction {
                name: "velocity_residual",
                doc: if self.writer.scene.is_driven() { "`C_q qd + C_t`." } else { "`C_q qd`." },
                arguments: &[Argument::Position, Argument::Rates],
                blocks: &[],
                results: vec![&kernel.velocity_residual],
            },
            KernelFunction {
                name: "correction",
                doc: "The change of coordinates that is least in the metric of `Mbar` among those with `C_q dq = \
                      -residuals`.",
                arguments: &[Argument::Position, Argument::Residuals],
                blocks: &[Block::Correction],
                results: vec![&kernel.correction],
            },
            KernelFunction {
                name: "accelerations",
                doc: "`qdd`, and the multipliers.",
                arguments: &[
                    Argument::Position,
                    Argument::Time,
                    Argument::Coordinates,
                    Argument::Rates,
                    Argument::Angles,
                ],
                blocks: &[
                    Block::Rates,
                    Block::NamedRates,
                    Block::Bias,
                    Block::Forces,
                    Block::Accelerations,
                    Block::Multipliers,
                    Block::Friction,
                ],
                results: vec![&kernel.accelerations, &kernel.multipliers],
            },
            KernelFunction {
                name: "outputs_at",
                doc: "What the scene asks for, at a position that is known.",
                arguments: &[
                    Argument::Position,
                    Argument::Time,
                    Argument::Coordinates,
                    Argument::Rates,
                    Argument::Accelerations,
                    Argument::Multipliers,
                    Argument::Angles,
                ],
                blocks: &[Block::Rates, Block::NamedRates],
                results: vec![&kernel.outputs],
            },
        ];
        let fields = self.fields(&parts);
        let position = self.add_position(&fields);
        let mut inside = self.outside.clone();
        inside.extend(&position.values);
        for part in &parts {
            self.add_function(part, &inside, &position);
        }
        self.add_growth_factor(&position);
        let solution = self.solution();
        let has_angle = (0..self.writer.scene.coordinates.len())
            .map(|i| self.graph.ops().iter().any(|op| angle_of(self.graph, op).is_some_and(|(_, j)| i == j)));
        let mut tape = self.writer.tape.borrow_mut();
        tape.has_angle = has_angle.collect();
        tape.solution = solution;
    }

    /// The values of a position that other functions need.
    fn fields(&self, parts: &[KernelFunction]) -> BTreeSet<Id> {
        let mut fields = self.computed_fields(parts);
        let definitions = self.definitions();
        // Functions that do not take coordinates, their sines and cosines, or time find them there.
        for part in parts {
            let roots: Vec<Signed> = part.results.iter().copied().flatten().copied().collect();
            let (mut seen, mut pending) = (HashSet::new(), roots.iter().map(|root| root.id).collect::<Vec<Id>>());
            while let Some(id) = pending.pop() {
                if fields.contains(&id) || !seen.insert(id) {
                    continue;
                }
                if angle_of(self.graph, self.graph.op(id)).is_some() {
                    if !part.arguments.contains(&Argument::Angles) {
                        fields.insert(id);
                    }
                    continue;
                }
                let may_be_one = matches!(self.graph.op(id), Op::Input(Symbol::Coordinate(_) | Symbol::Time));
                if may_be_one && !self.is_argument(id, part.arguments) {
                    fields.insert(id);
                } else {
                    pending.extend(self.graph.op(id).operands());
                    pending.extend(definitions.get(&id));
                }
            }
        }
        fields
    }

    /// The value that each local stands for.
    fn definitions(&self) -> HashMap<Id, Id> {
        self.kernel.locals.iter().map(|local| (local.input.id, local.value.id)).collect()
    }

    fn computed_fields(&self, parts: &[KernelFunction]) -> BTreeSet<Id> {
        let kernel = self.kernel;
        let values = parts.iter().flat_map(|part| part.results.iter().copied().flatten()).chain(&kernel.growth_factors);
        let mut pending: Vec<Id> = values.map(|value| value.id).collect();
        pending.extend(kernel.locals.iter().filter(|local| !local.block.is_position()).map(|local| local.value.id));
        let (mut seen, mut fields) = (HashSet::new(), BTreeSet::new());
        while let Some(id) = pending.pop() {
            if self.outside.contains_key(&id) || !seen.insert(id) {
                continue;
            }
            let op = self.graph.op(id);
            let is_local = matches!(op, Op::Input(Symbol::Local(_)));
            if self.is_position[id] && (is_local || !op.is_leaf()) {
                fields.insert(id);
            } else {
                pending.extend(op.operands());
            }
        }
        fields
    }

    fn add_position(&self, fields: &BTreeSet<Id>) -> Position {
        let locals: Vec<&Local> = self.kernel.locals.iter().filter(|local| local.block.is_position()).collect();
        let named: HashSet<Id> = fields.iter().copied().collect();
        let roots: Vec<Signed> = fields.iter().map(|&id| Signed { negative: false, id }).collect();
        let all: Vec<Signed> = locals.iter().map(|local| local.value).chain(roots.clone()).collect();
        let mut body = self.body(&self.outside, &HashSet::new(), &all);
        define(&mut body, &locals, &named);
        body.define_all(&roots, &named);
        let values: BTreeMap<Id, u32> = fields.iter().map(|&id| (id, body.value(id))).collect();
        let name = |(id, value): (&Id, &u32)| {
            let own = body.name_of(*id).map(str::to_owned);
            let name = own.or_else(|| self.writer.tape.borrow().names.get(value).cloned());
            name.map(|name| (name, *value))
        };
        let names: BTreeMap<String, u32> = values.iter().filter_map(name).collect();
        let doc = "What follows from the position alone: the loops, their Jacobian, the mass matrix, and how the \
                   dependent coordinates follow the others.";
        let arguments = match self.kernel.is_timed {
            true => vec![Argument::Time, Argument::Coordinates, Argument::Angles],
            false => vec![Argument::Coordinates, Argument::Angles],
        };
        let part = |(name, value): (&String, &u32)| Part {
            name: name.clone(),
            doc: String::new(),
            values: Shape::Scalar(*value),
        };
        self.writer.add(Function {
            name: "position".to_owned(),
            doc: doc.to_owned(),
            arguments,
            statements: body.finish(),
            parts: names.iter().map(part).collect(),
            structure: Some("Position".to_owned()),
            ..Default::default()
        });
        Position { values, names: names.into_keys().collect() }
    }

    fn add_function(&self, part: &KernelFunction, inside: &HashMap<Id, u32>, position: &Position) {
        let results = || part.results.iter().copied().flatten();
        let locals = self.needed_locals(results().copied(), inside);
        let locals: Vec<&Local> = locals.into_iter().filter(|local| part.blocks.contains(&local.block)).collect();
        let roots: Vec<Signed> = locals.iter().map(|local| &local.value).chain(results()).copied().collect();
        let mut body = self.body(inside, &position.names, &roots);
        define(&mut body, &locals, &HashSet::new());
        let ends: Vec<Signed> = results().copied().collect();
        body.define_all(&ends, &HashSet::new());
        let parts = vectors(&mut body, &part.results);
        self.writer.add(Function {
            name: part.name.to_owned(),
            doc: part.doc.to_owned(),
            arguments: part.arguments.to_vec(),
            statements: body.finish(),
            parts,
            ..Default::default()
        });
    }

    /// The locals that results need, through others and up to what stands outside.
    fn needed_locals(&self, results: impl Iterator<Item = Signed>, outside: &HashMap<Id, u32>) -> Vec<&Local> {
        let definitions = self.definitions();
        let mut pending: Vec<Id> = results.map(|root| root.id).collect();
        let mut needed = HashSet::new();
        while let Some(id) = pending.pop() {
            if !outside.contains_key(&id) && needed.insert(id) {
                pending.extend(self.graph.op(id).operands());
                pending.extend(definitions.get(&id));
            }
        }
        self.kernel.locals.iter().filter(|local| needed.contains(&local.input.id)).collect()
    }

    /// The operations that accelerations and multipliers need once sines and cosines are known.
    fn solution(&self) -> Operations {
        let function = self.whole("accelerations", &[], &[&self.kernel.accelerations, &self.kernel.multipliers]);
        let given: HashSet<u32> = self.outside.values().copied().collect();
        function.operations(&self.writer.tape.borrow(), |value| given.contains(&value))
    }

    fn body<'b>(&'b self, outside: &'b HashMap<Id, u32>, fields: &HashSet<String>, roots: &[Signed]) -> Body<'b> {
        // The fields of a position are bound in the same scope.
        let taken = self.taken.union(fields).cloned().collect();
        let graph = (self.graph, &self.writer.tape);
        Body::begin(graph, outside, &self.writer.hints, taken, roots, Some(&self.depths))
    }

    /// A function that is given no position.
    pub(super) fn whole(&self, name: &str, arguments: &[Argument], results: &[&[Signed]]) -> Function {
        let ends: Vec<Signed> = results.iter().copied().flatten().copied().collect();
        let locals = self.needed_locals(ends.iter().copied(), &self.outside);
        let roots: Vec<Signed> = locals.iter().map(|local| local.value).chain(ends.clone()).collect();
        let mut body = self.body(&self.outside, &HashSet::new(), &roots);
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

    /// Whether a coordinate or time is among a function's arguments.
    fn is_argument(&self, id: Id, arguments: &[Argument]) -> bool {
        match self.graph.op(id) {
            Op::Input(Symbol::Coordinate(_)) => arguments.contains(&Argument::Coordinates),
            Op::Input(Symbol::Time) => arguments.contains(&Argument::Time),
            _ => false,
        }
    }

    /// Adds the function that gives the largest factor by which the elimination magnifies errors.
    fn add_growth_factor(&self, position: &Position) {
        let mut tape = self.writer.tape.borrow_mut();
        let sizes = self.kernel.growth_factors.iter().filter_map(|value| position.values.get(&value.id));
        let sizes: Vec<u32> = sizes.map(|&value| tape.operation(Operation::Abs(value))).collect();
        let most = match (self.kernel.is_valid_everywhere, sizes.is_empty()) {
            (false, _) => tape.number(f64::INFINITY),
            (true, true) => tape.number(0.0),
            (true, false) => sizes[1..].iter().fold(sizes[0], |most, &size| tape.operation(Operation::Max(most, size))),
        };
        tape.functions.push(Function {
            name: "growth_factor".to_owned(),
            doc: "How much the elimination of dependent coordinates magnifies rounding errors.".to_owned(),
            arguments: vec![Argument::Position],
            parts: vec![Part { name: String::new(), doc: String::new(), values: Shape::Scalar(most) }],
            ..Default::default()
        });
    }
}

/// The results of the function `position`.
struct Position {
    values: BTreeMap<Id, u32>,
    names: HashSet<String>,
}

/// Results as lists.
fn vectors(body: &mut Body, results: &[&[Signed]]) -> Vec<Part> {
    let part = |result: &&[Signed]| {
        let values = Shape::Vector(result.iter().map(|root| body.root(*root)).collect());
        Part { name: String::new(), doc: String::new(), values }
    };
    results.iter().map(part).collect()
}

/// Defines values with a name, with a comment where another part of the computation begins.
fn define(body: &mut Body, locals: &[&Local], named: &HashSet<Id>) {
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

/// The coordinate whose sine or cosine an operation is.
fn angle_of(graph: &Graph, op: &Op) -> Option<(Call, usize)> {
    match op {
        Op::Call(function @ (Call::Sin | Call::Cos), angle) => match graph.op(*angle) {
            Op::Input(Symbol::Coordinate(i)) => Some((*function, *i)),
            _ => None,
        },
        _ => None,
    }
}
