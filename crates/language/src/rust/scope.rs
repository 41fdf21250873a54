//! The names of values in a Rust function.

use std::collections::{BTreeSet, HashMap};

use proc_macro2::{Ident, Literal, TokenStream};
use quote::{format_ident, quote};

use super::expression::{Piece, expression};
use crate::sparsity::is_sparse;
use qrm_core::NamedTape;
use qrm_core::named_tape::{Function, Shape, Value};

/// The names of values in a function.
pub(super) struct Scope<'t> {
    pub(super) tape: &'t NamedTape,
    pub(super) names: HashMap<u32, TokenStream>,
    pub(super) used: BTreeSet<u32>,
}

impl Scope<'_> {
    /// The statements of a function, and the values of its parts.
    pub(super) fn print(&mut self, function: &Function) -> (Vec<TokenStream>, Vec<TokenStream>) {
        let mut statements = Vec::new();
        for statement in &function.statements {
            let value = self.computed(statement.value).tokens;
            let names: Vec<Ident> = statement.names.iter().map(|name| format_ident!("{name}")).collect();
            // The printer keeps only documentation, which later becomes comments.
            let comment = statement.comment.iter().map(|text| format!(" {text}"));
            statements.push(match &names[..] {
                [sine, cosine] => quote!(#(#[doc = #comment])* let (#sine, #cosine) = #value;),
                names => quote!(#(#[doc = #comment])* let #(#names)* = #value;),
            });
            self.names.extend((statement.value..).zip(names.iter().map(|name| quote!(#name))));
        }
        let parts = function.parts.iter().map(|part| self.shape(&part.values)).collect();
        (statements, parts)
    }

    /// The expression of a value: its name if it has one.
    fn value(&mut self, value: u32) -> Piece {
        let Some(name) = self.names.get(&value) else { return self.computed(value) };
        self.used.insert(value);
        Piece::whole(name.clone())
    }

    /// The operation that computes a value.
    fn computed(&mut self, value: u32) -> Piece {
        match self.tape.values()[value as usize] {
            Value::Operation(operation) => expression(operation, |operand| self.value(operand)),
            Value::Input => unreachable!("an input has a name"),
            Value::Cosine => unreachable!("a cosine is named with its sine"),
        }
    }

    fn list(&mut self, values: &[u32]) -> TokenStream {
        let values = values.iter().map(|value| self.value(*value).tokens);
        quote!([#(#values),*])
    }

    fn shape(&mut self, shape: &Shape<u32>) -> TokenStream {
        match shape {
            Shape::Scalar(value) => self.value(*value).tokens,
            Shape::Vector(values) => self.list(values),
            Shape::Matrix(rows) if self.is_sparse(rows) => self.sparse(rows),
            Shape::Matrix(rows) => {
                let rows = rows.iter().map(|row| self.list(row));
                quote!([#(#rows),*])
            }
        }
    }

    fn is_sparse(&self, rows: &[Vec<u32>]) -> bool {
        let entries = rows.iter().map(Vec::len).sum::<usize>();
        let filled = rows.iter().flatten().filter(|entry| !self.tape.is_zero(**entry)).count();
        is_sparse(entries, filled)
    }

    /// A matrix given by its nonzero entries, so that the code of a large mechanism grows with their number.
    fn sparse(&mut self, rows: &[Vec<u32>]) -> TokenStream {
        let [height, width] = [rows.len(), rows.first().map_or(0, Vec::len)].map(Literal::usize_unsuffixed);
        let mut entries = Vec::new();
        for (i, row) in rows.iter().enumerate() {
            for (j, entry) in row.iter().enumerate() {
                if !self.tape.is_zero(*entry) {
                    let value = self.value(*entry).tokens;
                    let [i, j] = [i, j].map(Literal::usize_unsuffixed);
                    entries.push(quote!(rows[#i][#j] = #value;));
                }
            }
        }
        quote!({
            let mut rows = [[R::zero(); #width]; #height];
            #(#entries)*
            rows
        })
    }
}
