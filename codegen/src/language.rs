//! Writes generated modules in other languages: their syntax is translated as it stands.

mod c;
mod names;
mod program;
mod read;
#[cfg(test)]
mod tests;

use quote::ToTokens;

/// A generated module in C99: it needs `libm` and no allocator.
///
/// `name` is that of the scene's module; all that others see begins with it.
///
/// # Errors
/// A construct has no translation.
pub fn c(name: &str, module: &syn::File) -> Result<Code, Untranslated> {
    c::write(&read::program(name, module)?)
}

/// The syntax of a generated module, the comments of its statements included.
///
/// # Errors
/// The text is not Rust.
pub fn syntax(text: &str) -> syn::Result<syn::File> {
    // A parser keeps documentation alone.
    let line = |line: &str| match line.split_once("// ") {
        Some((indent, comment)) if !indent.is_empty() && indent.trim().is_empty() => format!("{indent}/// {comment}\n"),
        _ => format!("{line}\n"),
    };
    // Behind the functions stands the scene, in a literal.
    let (functions, rest) = text.split_at(text.find("pub const SOURCE").unwrap_or(text.len()));
    let functions: String = functions.lines().map(line).collect();
    syn::parse_file(&(functions + rest))
}

/// A module in C.
#[derive(Clone, Debug, PartialEq)]
pub struct Code {
    /// What others see, for `NAME.h`.
    pub header: String,
    /// The functions, for `NAME.c`.
    pub source: String,
}

/// What has no translation.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("no translation of {0}")]
pub struct Untranslated(String);

impl Untranslated {
    fn new(what: &str, construct: &impl ToTokens) -> Self {
        Self(format!("{what} `{}`", construct.to_token_stream()))
    }
}
