//! The names of coordinates, constraints and outputs.

use syn::{Expr, ExprLit, FieldValue, Item, Lit, Member};

use super::Untranslated;
use crate::ir::Quantity;

/// The coordinates, constraints and outputs that a module describes.
pub(super) fn quantities(file: &syn::File) -> Result<[Vec<Quantity>; 3], Untranslated> {
    let description = file.items.iter().find_map(|item| match item {
        Item::Const(item) if item.ident == "DESCRIPTION" => Some(&*item.expr),
        _ => None,
    });
    let Some(Expr::Struct(description)) = description else {
        return Err(Untranslated("a module without `DESCRIPTION`".to_owned()));
    };
    let list = |name: &str| list(field(&description.fields, name)?);
    Ok([list("coordinates")?, list("constraints")?, list("outputs")?])
}

fn field<'e>(fields: impl IntoIterator<Item = &'e FieldValue>, name: &str) -> Result<&'e Expr, Untranslated> {
    let is_it = |field: &&FieldValue| matches!(&field.member, Member::Named(other) if other == name);
    let found = fields.into_iter().find(is_it).map(|field| &field.expr);
    found.ok_or_else(|| Untranslated(format!("a description without `{name}`")))
}

fn list(value: &Expr) -> Result<Vec<Quantity>, Untranslated> {
    let Expr::Reference(reference) = value else { return Err(Untranslated::new("the list", value)) };
    let Expr::Array(array) = &*reference.expr else { return Err(Untranslated::new("the list", value)) };
    let quantity = |value: &Expr| {
        let Expr::Struct(quantity) = value else { return Err(Untranslated::new("the quantity", value)) };
        let text = |name: &str| match field(&quantity.fields, name)? {
            Expr::Lit(ExprLit { lit: Lit::Str(text), .. }) => Ok(text.value()),
            other => Err(Untranslated::new("the text", other)),
        };
        Ok(Quantity { name: text("name")?, unit: text("unit")?, doc: text("doc")? })
    };
    array.elems.iter().map(quantity).collect()
}
