//! The functions of a generated module by their names.

use std::collections::HashMap;

use syn::{ImplItem, Item};

use super::{Number, Value, run, run_block};

/// The functions of a module, ready to be run.
pub(in super::super) struct GeneratedModule<'f> {
    pub(in super::super) functions: HashMap<String, &'f syn::ItemFn>,
    pub(in super::super) methods: HashMap<String, &'f syn::ImplItemFn>,
    /// The coordinates of `inverse_dynamics`.
    pub(in super::super) actuated: Vec<usize>,
}

impl<'f> GeneratedModule<'f> {
    pub(in super::super) fn new(file: &'f syn::File) -> Result<Self, String> {
        let mut generated = Self { functions: HashMap::new(), methods: HashMap::new(), actuated: Vec::new() };
        for item in &file.items {
            match item {
                Item::Fn(function) => {
                    generated.functions.insert(function.sig.ident.to_string(), function);
                }
                Item::Const(constant) if constant.ident == "ACTUATED" => {
                    let syn::Expr::Array(places) = &*constant.expr else { continue };
                    let place = |place: &syn::Expr| match place {
                        syn::Expr::Lit(syn::ExprLit { lit: syn::Lit::Int(place), .. }) => place.base10_parse().ok(),
                        _ => None,
                    };
                    generated.actuated = places.elems.iter().filter_map(place).collect();
                }
                Item::Impl(block) => {
                    let owner = match &*block.self_ty {
                        syn::Type::Path(path) => path.path.segments.last().map(|s| s.ident.to_string()),
                        _ => None,
                    };
                    let owner = owner.ok_or("an impl of something without a name")?;
                    for item in &block.items {
                        let ImplItem::Fn(method) = item else { continue };
                        let name = if owner == "Constants" {
                            "Constants::new".to_owned()
                        } else {
                            method.sig.ident.to_string()
                        };
                        generated.methods.entry(name).or_insert(method);
                    }
                }
                _ => {}
            }
        }
        Ok(generated)
    }

    pub(in super::super) fn value<N: Number>(&self, name: &str, arguments: &[Value<N>]) -> Result<Value<N>, String> {
        let function = self.functions.get(name).ok_or_else(|| format!("no function `{name}` was generated"))?;
        run(function, arguments).map_err(|e| format!("generated `{name}`: {e}"))
    }

    pub(in super::super) fn method<N: Number>(&self, name: &str, arguments: &[Value<N>]) -> Result<Value<N>, String> {
        let method = self.methods.get(name).ok_or_else(|| format!("no method `{name}` was generated"))?;
        run_block(&method.sig, &method.block, arguments).map_err(|e| format!("generated `{name}`: {e}"))
    }
}
