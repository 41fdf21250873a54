//! Values that depend only on parameters: their names and formulae.

use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};

use super::Writer;
use super::body::Body;
use super::naming::{power_name, untaken};
use super::plan::Plan;
use super::scene_formula;
use crate::graph::{Id, Op, Signed};
use crate::term::Symbol;
use qrm_core::named_tape::{Function, ResultField, Shape};

/// The longest name made from a formula; longer ones are replaced by numbers.
const LONGEST_NAME: usize = 34;

impl Writer<'_> {
    /// Adds the functions for values that depend only on parameters: dependent parameters, and constants. A constant is
    /// a value other than a plain parameter that does not change during a run; each has a field.
    pub(super) fn add_constants(&mut self) {
        let parameters = scene_formula::parameters(self.scene, &mut self.tape.borrow_mut());
        self.add(parameters);
        let mut roots: Vec<Id> = self.layout.plans.iter().flat_map(Plan::values).map(|root| root.id).collect();
        roots.extend(self.layout.kernel.values().map(|root| root.id));
        let mut fields: BTreeSet<Id> = BTreeSet::new();
        let mut note = |id: Id| {
            if self.graph.is_constant(id) && !self.graph.op(id).is_leaf() {
                fields.insert(id);
            }
        };
        roots.iter().for_each(|&id| note(id));
        for id in self.graph.reachable(roots) {
            if !self.graph.is_constant(id) {
                self.graph.op(id).operands().into_iter().for_each(&mut note);
            }
        }
        let mut taken = HashSet::new();
        let mut unnamed = 0;
        let mut names = Vec::new();
        for id in fields {
            let wish = self.constant_name(id).unwrap_or_else(|| {
                unnamed += 1;
                format!("k{unnamed}")
            });
            let name = untaken(wish, &mut taken);
            self.hints.insert(id, name.clone());
            names.push((name, id));
        }
        if names.is_empty() {
            return;
        }
        let roots: Vec<Signed> = names.iter().map(|(_, id)| Signed { negative: false, id: *id }).collect();
        let constant = self.graph.reachable(roots.iter().map(|r| r.id)).into_iter();
        let hints: HashMap<Id, String> = constant.filter_map(|id| Some((id, self.constant_name(id)?))).collect();
        let taken = HashSet::from(["p".to_owned()]);
        let mut body = Body::new((self.graph, &self.tape), &self.predefined, &hints, &HashSet::new(), taken, &roots);
        let values: Vec<u32> = roots.iter().map(|root| body.root(*root)).collect();
        let statements = body.finish();
        let part = |((name, id), value): (&(String, Id), &u32)| {
            let doc = format!("`{}`", self.formula(*id));
            ResultField { name: name.clone(), doc, values: Shape::Scalar(*value) }
        };
        let parts = names.iter().zip(&values).map(part).collect();
        self.add(Function { name: "constants".to_owned(), statements, parts, ..Default::default() });
        self.predefined.extend(names.iter().zip(values).map(|((_, id), value)| (*id, value)));
    }

    /// The name of a constant from its formula, if that is short enough.
    fn constant_name(&self, id: Id) -> Option<String> {
        let name = match self.graph.op(id) {
            Op::Number(bits) if f64::from_bits(*bits) == 2.0 => "twice".to_owned(),
            Op::Number(bits) if f64::from_bits(*bits) == 0.5 => "half".to_owned(),
            Op::Input(_) => self.hints[&id].clone(),
            Op::Product(_) => {
                let names = self.powers(id).into_iter().map(|(factor, times)| {
                    let name = self.constant_name(factor)?;
                    let name = if matches!(self.graph.op(factor), Op::Sum(_)) { format!("times_{name}") } else { name };
                    Some(power_name(name, times))
                });
                names.collect::<Option<Vec<String>>>()?.join("_")
            }
            Op::Sum(terms) => {
                let mut name = String::new();
                for term in terms {
                    name += match (name.is_empty(), term.negative) {
                        (true, false) => "",
                        (true, true) => "minus_",
                        (false, false) => "_plus_",
                        (false, true) => "_minus_",
                    };
                    name += &self.constant_name(term.id)?;
                }
                name
            }
            Op::Call(function, a) => format!("{}_{}", function.name(), self.constant_name(*a)?),
            _ => return None,
        };
        (name.len() <= LONGEST_NAME).then_some(name)
    }

    /// The factors of a product and of nested products, with their multiplicity; numbers first, sums last.
    fn powers(&self, id: Id) -> Vec<(Id, usize)> {
        let mut pending = vec![id];
        let mut counts: BTreeMap<(u8, Id), usize> = BTreeMap::new();
        while let Some(id) = pending.pop() {
            match self.graph.op(id) {
                Op::Product(factors) => pending.extend(factors),
                op => {
                    let class = match op {
                        Op::Number(_) => 0,
                        Op::Sum(_) => 2,
                        _ => 1,
                    };
                    *counts.entry((class, id)).or_default() += 1;
                }
            }
        }
        counts.into_iter().map(|((_, id), times)| (id, times)).collect()
    }

    /// A constant's formula in the notation of scenes.
    fn formula(&self, id: Id) -> String {
        let inner = |id: Id| {
            let text = self.formula(id);
            if matches!(self.graph.op(id), Op::Sum(_)) { format!("({text})") } else { text }
        };
        match self.graph.op(id) {
            Op::Number(bits) => format!("{}", f64::from_bits(*bits)),
            Op::Input(Symbol::Parameter(i)) => self.scene.parameters[*i].name.clone(),
            Op::Input(_) => "pi".to_owned(),
            Op::Sum(terms) => {
                let mut text = String::new();
                for term in terms {
                    text += match (text.is_empty(), term.negative) {
                        (true, false) => "",
                        (true, true) => "-",
                        (false, false) => " + ",
                        (false, true) => " - ",
                    };
                    text += &inner(term.id);
                }
                text
            }
            Op::Product(_) => {
                let power = |(factor, times): (Id, usize)| match times {
                    1 => inner(factor),
                    _ => format!("{}^{times}", inner(factor)),
                };
                self.powers(id).into_iter().map(power).collect::<Vec<_>>().join("*")
            }
            Op::Reciprocal(a) => format!("1/({})", self.formula(*a)),
            Op::Power(a, exponent) => format!("({})^{}", self.formula(*a), f64::from_bits(*exponent)),
            Op::Call(function, a) => format!("{}({})", function.name(), self.formula(*a)),
        }
    }
}
