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
//! and the crate includes the result by `include!(concat!(env!("OUT_DIR"), "/scenes.rs"));`.
//!
//! The phases, each with plain data for the next: `qrm_scene` (text to [`Scene`](qrm_scene::scene::Scene)), `engine`
//! (scene to [`term`]s), [`lower`] and [`share`] (terms to a [`graph`]), [`emit`] (graph to Rust), [`tape`] (Rust to operations), [`verify`] (Rust
//! against the scene), `generate` (files in, files out).

#[cfg(feature = "engine")]
pub mod build;
pub mod derivation;
pub mod emit;
#[cfg(feature = "engine")]
pub mod engine;
pub mod formula;
#[cfg(feature = "engine")]
pub mod generate;
pub mod graph;
pub mod header;
mod interpret;
#[cfg(feature = "engine")]
pub mod interpretable;
pub mod kernel;
pub mod lower;
pub mod names;
pub mod omissions;
pub mod share;
pub mod tape;
pub mod term;
#[cfg(test)]
mod translations;
pub mod verify;
pub mod words;
