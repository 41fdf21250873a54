//! Values that depend on parameters alone: their names, their struct, their formulae.

use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};

use proc_macro2::{Ident, TokenStream};
use quote::quote;

use super::Writer;
use super::body::Body;
use super::layout::Plan;
use super::naming::{power_name, untaken};
use super::plain::ident;
use crate::graph::{Id, Op, Signed};
use crate::term::Symbol;

/// Constants whose formula makes a longer name are numbered.
const LONGEST_NAME: usize = 34;

impl Writer<'_> {
    /// Values that keep their size during a run and are not just parameters get a field each.
    pub(super) fn name_constants(&mut self) {
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
        for id in fields {
            let wish = self.constant_name(id).unwrap_or_else(|| {
                unnamed += 1;
                format!("k{unnamed}")
            });
            let name = untaken(wish, &mut taken);
            let field = ident(&name);
            self.outside.insert(id, quote!(k.#field));
            self.hints.insert(id, name);
            self.constants.push((field, id));
        }
    }

    /// A constant is called after its formula, if that makes a name that can still be read.
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

    /// The factors of a product and of products in it, each with how often it occurs; numbers first, sums last.
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

    /// The struct of the constants, and how they are computed.
    pub(super) fn constants(&self) -> TokenStream {
        if self.constants.is_empty() {
            return TokenStream::new();
        }
        let parameters: HashMap<Id, TokenStream> = self
            .outside
            .iter()
            .filter(|(id, _)| self.graph.op(**id).is_leaf())
            .map(|(id, t)| (*id, t.clone()))
            .collect();
        let roots: Vec<Signed> = self.constants.iter().map(|(_, id)| Signed { negative: false, id: *id }).collect();
        let constant = self.graph.reachable(roots.iter().map(|r| r.id)).into_iter();
        let hints: HashMap<Id, String> = constant.filter_map(|id| Some((id, self.constant_name(id)?))).collect();
        let mut body =
            Body::new(self.graph, &parameters, &hints, &HashSet::new(), HashSet::from(["p".to_owned()]), &roots);
        let values: Vec<TokenStream> = roots.iter().map(|root| body.root(*root)).collect();
        let (statements, _) = body.finish();
        let field = |((name, _), value): (&(Ident, Id), &TokenStream)| match *name == value.to_string() {
            true => quote!(#name),
            false => quote!(#name: #value),
        };
        let fields = self.constants.iter().zip(&values).map(field);
        let names: Vec<&Ident> = self.constants.iter().map(|(name, _)| name).collect();
        let docs = self.constants.iter().map(|(_, id)| format!(" `{}`", self.formula(*id)));
        quote! {
            /// Values that depend on parameters alone, computed once.
            #[derive(Clone, Copy, Debug)]
            pub struct Constants<R = f64> {
                #(#[doc = #docs] pub #names: R,)*
            }

            impl<R: Scalar> Constants<R> {
                #[inline(always)]
                fn new(p: &Parameters<R>) -> Self {
                    #(#statements)*
                    Self { #(#fields),* }
                }
            }
        }
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
