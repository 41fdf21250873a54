//! The function that computes the quantities of a position.

use std::collections::{BTreeMap, BTreeSet, HashSet};

use qrm_core::Operation;

use super::emitter::{Emitter, KernelFunction, angle_of, define};
use crate::graph::{Id, Op, Signed};
use crate::kernel::Local;
use crate::term::Symbol;
use qrm_core::named_tape::{Argument, Function, ResultField, Shape};
use qrm_scene::scene::EliminationForm;

/// The results of the function `position`.
pub(super) struct Position {
    pub(super) values: BTreeMap<Id, u32>,
    pub(super) names: HashSet<String>,
}

impl Emitter<'_> {
    /// The quantities of a position that other functions need.
    pub(super) fn fields(&self, parts: &[KernelFunction]) -> BTreeSet<Id> {
        let mut fields = self.computed_fields(parts);
        let definitions = self.definitions();
        // Functions without coordinates, sines, cosines, or time as arguments take these from the position.
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

    fn computed_fields(&self, parts: &[KernelFunction]) -> BTreeSet<Id> {
        let kernel = self.kernel;
        let values = parts.iter().flat_map(|part| part.results.iter().copied().flatten()).chain(&kernel.growth_factors);
        let mut pending: Vec<Id> = values.map(|value| value.id).collect();
        pending.extend(kernel.locals.iter().filter(|local| !local.block.is_position()).map(|local| local.value.id));
        let (mut seen, mut fields) = (HashSet::new(), BTreeSet::new());
        while let Some(id) = pending.pop() {
            if self.predefined.contains_key(&id) || !seen.insert(id) {
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

    pub(super) fn add_position(&self, fields: &BTreeSet<Id>) -> Position {
        let locals: Vec<&Local> = self.kernel.locals.iter().filter(|local| local.block.is_position()).collect();
        let named: HashSet<Id> = fields.iter().copied().collect();
        let roots: Vec<Signed> = fields.iter().map(|&id| Signed { negative: false, id }).collect();
        let all: Vec<Signed> = locals.iter().map(|local| local.value).chain(roots.clone()).collect();
        let mut body = self.body(&self.predefined, &HashSet::new(), &all);
        define(&mut body, &locals, &named);
        body.define_all(&roots, &named);
        let values: BTreeMap<Id, u32> = fields.iter().map(|&id| (id, body.value(id))).collect();
        let name = |(id, value): (&Id, &u32)| {
            let own = body.name_of(*id).map(str::to_owned);
            let name = own.or_else(|| self.writer.tape.borrow().names.get(value).cloned());
            name.map(|name| (name, *value))
        };
        let names: BTreeMap<String, u32> = values.iter().filter_map(name).collect();
        let what = match self.kernel.form {
            EliminationForm::Sparse => "named quantities, their slopes, and the factors of the elimination",
            EliminationForm::RangeSpace => {
                "the loops, their Jacobian, the mass matrix, and the factors of `Mbar` and `C_q Mbar^-1 C_q'`"
            }
            EliminationForm::NullSpace => {
                "the loops, their Jacobian, the mass matrix, and how the dependent coordinates follow the others"
            }
        };
        let arguments = match self.kernel.is_timed {
            true => vec![Argument::Time, Argument::Coordinates, Argument::Angles],
            false => vec![Argument::Coordinates, Argument::Angles],
        };
        let part = |(name, value): (&String, &u32)| ResultField {
            name: name.clone(),
            doc: String::new(),
            values: Shape::Scalar(*value),
        };
        self.writer.add(Function {
            name: "position".to_owned(),
            doc: format!("What follows from the position alone: {what}."),
            arguments,
            statements: body.finish(),
            parts: names.iter().map(part).collect(),
            structure: Some("Position".to_owned()),
            ..Default::default()
        });
        Position { values, names: names.into_keys().collect() }
    }

    /// Whether a coordinate or time is an argument of a function.
    fn is_argument(&self, id: Id, arguments: &[Argument]) -> bool {
        match self.graph.op(id) {
            Op::Input(Symbol::Coordinate(_)) => arguments.contains(&Argument::Coordinates),
            Op::Input(Symbol::Time) => arguments.contains(&Argument::Time),
            _ => false,
        }
    }

    /// Adds the function for the largest factor by which the elimination amplifies errors.
    pub(super) fn add_growth_factor(&self, position: &Position) {
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
            parts: vec![ResultField { name: String::new(), doc: String::new(), values: Shape::Scalar(most) }],
            ..Default::default()
        });
    }
}
