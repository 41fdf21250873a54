//! Values that depend on parameters alone: their names, their struct, their formulae.

use std::collections::{BTreeSet, HashMap, HashSet};

use proc_macro2::{Ident, TokenStream};
use quote::quote;

use super::Writer;
use super::body::Body;
use super::plain::ident;
use crate::graph::{Id, Op, Signed};
use crate::term::Symbol;

impl Writer<'_> {
    /// Values that keep their size during a run and are not just parameters get a field each.
    pub(super) fn name_constants(&mut self) {
        let roots = self.layout.plans.iter().flat_map(|plan| plan.parts.iter().flat_map(|(_, shape)| shape.values()));
        let roots: Vec<Id> = roots.map(|root| root.id).collect();
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
        for (number, id) in fields.into_iter().enumerate() {
            let base = self.constant_name(id).unwrap_or_else(|| format!("k{}", number + 1));
            let mut name = base.clone();
            let mut suffix = 2;
            while !taken.insert(name.clone()) {
                name = format!("{base}_{suffix}");
                suffix += 1;
            }
            let field = ident(&name);
            self.outside.insert(id, quote!(k.#field));
            self.hints.insert(id, name);
            self.constants.push((field, id));
        }
    }

    /// A product of parameters is called after them.
    fn constant_name(&self, id: Id) -> Option<String> {
        let Op::Product(factors) = self.graph.op(id) else { return None };
        let mut names: Vec<String> = Vec::new();
        for (i, factor) in factors.iter().enumerate() {
            if factors[..i].contains(factor) {
                continue;
            }
            let times = factors.iter().filter(|f| *f == factor).count();
            let name = match self.graph.op(*factor) {
                Op::Number(bits) if f64::from_bits(*bits) == 2.0 => "twice".to_owned(),
                Op::Number(bits) if f64::from_bits(*bits) == 0.5 => "half".to_owned(),
                Op::Input(_) => self.hints[factor].clone(),
                _ => return None,
            };
            names.push(if times == 1 {
                name
            } else if times == 2 {
                format!("{name}_sq")
            } else {
                format!("{name}_pow{times}")
            });
        }
        let name = names.join("_");
        (name.len() <= 24).then_some(name)
    }

    /// The struct of the constants, and how they are computed.
    pub(super) fn constants(&self) -> TokenStream {
        let parameters: HashMap<Id, TokenStream> = self
            .outside
            .iter()
            .filter(|(id, _)| self.graph.op(**id).is_leaf())
            .map(|(id, t)| (*id, t.clone()))
            .collect();
        let roots: Vec<Signed> = self.constants.iter().map(|(_, id)| Signed { negative: false, id: *id }).collect();
        let hints = HashMap::new();
        let mut body = Body::new(self.graph, &parameters, &hints, HashSet::from(["p".to_owned()]), &roots);
        let values: Vec<TokenStream> = roots.iter().map(|root| body.root(*root)).collect();
        let (statements, _) = body.finish();
        let names: Vec<&Ident> = self.constants.iter().map(|(name, _)| name).collect();
        let docs = self.constants.iter().map(|(_, id)| format!(" `{}`", self.formula(*id)));
        let p = if values.is_empty() { quote!(_p) } else { quote!(p) };
        // A struct without fields still has to mention its number type.
        let marker = values
            .is_empty()
            .then(|| (quote!(marker: std::marker::PhantomData<R>,), quote!(marker: std::marker::PhantomData)));
        let (marker_field, marker_value) = marker.unzip();
        quote! {
            /// Values that depend on parameters alone, computed once.
            #[derive(Clone, Copy, Debug)]
            pub struct Constants<R = f64> {
                #(#[doc = #docs] pub #names: R,)*
                #marker_field
            }

            impl<R: Real> Constants<R> {
                fn new(#p: &Parameters<R>) -> Self {
                    #(#statements)*
                    Self { #(#names: #values,)* #marker_value }
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
            Op::Product(factors) => {
                let mut parts: Vec<String> = Vec::new();
                for (i, factor) in factors.iter().enumerate() {
                    let times = factors.iter().filter(|f| *f == factor).count();
                    if !factors[..i].contains(factor) {
                        parts.push(if times == 1 { inner(*factor) } else { format!("{}^{times}", inner(*factor)) });
                    }
                }
                parts.join("*")
            }
            Op::Reciprocal(a) => format!("1/({})", self.formula(*a)),
            Op::Power(a, exponent) => format!("({})^{}", self.formula(*a), f64::from_bits(*exponent)),
            Op::Call(function, a) => format!("{}({})", function.name(), self.formula(*a)),
        }
    }
}
