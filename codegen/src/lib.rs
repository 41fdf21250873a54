//! Differentiates a mechanism given as formulae, and writes plain Rust for its equations of motion.
//!
//! A build script needs three lines (feature `engine`):
//!
//! ```ignore
//! fn main() {
//!     qrm_codegen::build::build(&["scene.toml"]);
//! }
//! ```
//!
//! and the crate includes the result by `include!(concat!(env!("OUT_DIR"), "/scenes.rs"));`. Without the feature scenes
//! are read, checked and evaluated, which is what a simulator needs of them.
//!
//! The phases, each with plain data for the next: [`document`] (text to syntax), [`resolve`] (syntax to [`scene`]),
//! `engine` (scene to [`term`]s), [`lower`] and [`share`] (terms to a [`graph`]), [`emit`] (graph to Rust), [`verify`]
//! (Rust against the scene), `generate` (files in, files out).

#[cfg(feature = "engine")]
pub mod build;
pub mod chart;
pub mod derivation;
pub mod diagnostic;
pub mod document;
pub mod emit;
#[cfg(feature = "engine")]
pub mod engine;
pub mod evaluate;
pub mod expression;
pub mod formula;
pub mod function;
#[cfg(feature = "engine")]
pub mod generate;
pub mod graph;
pub mod header;
pub mod kernel;
pub mod lexer;
pub mod lower;
pub mod names;
pub mod omissions;
pub mod parser;
pub mod resolve;
pub mod scene;
pub mod share;
pub mod source;
pub mod term;
pub mod verify;
pub mod words;
