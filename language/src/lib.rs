//! Writes generated modules of mechanisms in other languages.
//!
//! The text of a module in Rust is parsed into an [intermediate representation](mod@ir), from which each language is
//! written: the functions keep their names, their formulae and the order of their operations. Only the text is needed, so
//! that this works where the equations are not derived.
//!
//! ```
//! # let text = include_str!("../../qrm-model/golden/pendulum.rs");
//! let program = qrm_language::parse("pendulum", text)?;
//! let files = qrm_language::c(&program)?;
//! assert_eq!(files[0].name, "pendulum.h");
//! # Ok::<(), qrm_language::Untranslated>(())
//! ```

mod c;
mod constants;
pub mod ir;
mod lines;
mod matlab;
mod names;
mod parse;
mod precedence;

use quote::ToTokens;

use ir::{Function, Program};

/// A language of generated code.
#[derive(Clone, Copy, Debug)]
pub struct Language {
    /// The word for it on a command line.
    pub name: &'static str,
    /// The language as it calls itself.
    pub title: &'static str,
    /// What is written, in a few words.
    pub doc: &'static str,
    /// What begins a comment.
    pub comment: &'static str,
    /// Whether steps take constraints that repeat others.
    pub takes_repeated_constraints: bool,
    /// Writes a module.
    pub write: fn(&Program) -> Result<Vec<File>, Untranslated>,
    /// Writes a function of a module.
    pub write_function: fn(&Program, &Function) -> Result<String, Untranslated>,
}

/// The languages that generated modules are translated into.
pub const LANGUAGES: [Language; 2] = [
    Language {
        name: "c",
        title: "C",
        doc: "C99, a header and a source file that need libm alone",
        comment: "//",
        takes_repeated_constraints: false,
        write: c,
        write_function: c::write_function,
    },
    Language {
        name: "matlab",
        title: "MATLAB",
        doc: "MATLAB and Octave, a file for each function",
        comment: "%",
        takes_repeated_constraints: true,
        write: matlab,
        write_function: matlab::write_function,
    },
];

/// A file of generated code.
#[derive(Clone, Debug, PartialEq)]
pub struct File {
    /// Its name, without a folder.
    pub name: String,
    /// Its text.
    pub text: String,
}

/// The intermediate representation of a generated module.
///
/// `name` is that of the scene; what others see of the translations begins with it: with `quick_return` for
/// `quick-return`.
///
/// # Errors
/// The text is not Rust, or a construct has no translation.
pub fn parse(name: &str, text: &str) -> Result<Program, Untranslated> {
    let module = parse::syntax(text).map_err(|e| Untranslated(format!("the module `{name}`: {e}")))?;
    Ok(Program { notes: parse::notes(text), ..lower(name, &module)? })
}

/// The intermediate representation of the syntax of a generated module.
///
/// # Errors
/// A construct has no translation.
pub fn lower(name: &str, module: &syn::File) -> Result<Program, Untranslated> {
    parse::lower(&name.to_lowercase().replace('-', "_"), module)
}

pub use parse::syntax;

/// A module in C99, as a header and a source file: it needs `libm` and no allocator.
///
/// # Errors
/// A name cannot be one in C.
pub fn c(program: &Program) -> Result<Vec<File>, Untranslated> {
    c::write(program)
}

/// A module in MATLAB, as a file for each function, and a script that simulates the motion. It runs in Octave too.
///
/// # Errors
/// A name cannot be one in MATLAB.
pub fn matlab(program: &Program) -> Result<Vec<File>, Untranslated> {
    matlab::write(program)
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
