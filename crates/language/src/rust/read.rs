//! Reads printed functions back: every statement and result must match an operation of the tape.

mod function;

use std::collections::HashMap;

use quote::ToTokens;
use syn::{Block, ImplItem, Item};

use super::NOT_PRINTED;
use function::Reader;
use qrm_core::NamedTape;

/// Compares every function in the text of a module with its tape.
///
/// # Errors
/// The first statement or result that differs.
pub fn check(tape: &NamedTape, text: &str) -> Result<(), String> {
    let file = syn::parse_file(text).map_err(|e| format!("the printed module is not Rust: {e}"))?;
    let blocks = blocks(&file);
    for function in tape.functions.iter().filter(|function| !NOT_PRINTED.contains(&&*function.name)) {
        let block = blocks.get(&function.name).ok_or_else(|| format!("no `{}` was printed", function.name))?;
        let reader = Reader { tape, names: HashMap::new() };
        reader.function(function, block).map_err(|e| format!("printed `{}`: {e}", function.name))?;
    }
    Ok(())
}

/// The bodies of functions and methods, by the names of the tape.
fn blocks(file: &syn::File) -> HashMap<String, &Block> {
    let mut blocks = HashMap::new();
    for item in &file.items {
        match item {
            Item::Fn(function) => drop(blocks.insert(function.sig.ident.to_string(), &*function.block)),
            Item::Impl(own) => {
                for item in &own.items {
                    let ImplItem::Fn(method) = item else { continue };
                    let name = match (own.self_ty.to_token_stream().to_string(), method.sig.ident.to_string()) {
                        (owner, name) if owner.starts_with("Parameters") && name == "with" => "parameters".to_owned(),
                        (owner, name) if owner.starts_with("Constants") && name == "new" => "constants".to_owned(),
                        (_, name) => name,
                    };
                    // A method that forwards to a function of the same name has been found before.
                    blocks.entry(name).or_insert(&method.block);
                }
            }
            _ => {}
        }
    }
    blocks
}
