//! Differentiates a mechanism given as formulae, and writes plain Rust for its equations of motion.
//!
//! The phases, each with plain data for the next: `qrm_scene` (text to [`Scene`](qrm_scene::scene::Scene)), the program
//! `qrm-engine` (scene to [`term`]s; the only part that contains symbolica), [`lower`] and [`share`] (terms to a
//! [`graph`]), [`functions`] (graph to [`tape`]), [`rust`] (tape to text). [`verify`] compares the tape with the scene.

pub mod derivation;
pub mod formula;
pub mod functions;
pub mod graph;
pub mod header;
mod identifier;
pub mod kernel;
pub mod lower;
pub mod names;
pub mod omissions;
pub mod rust;
pub mod share;
pub mod tape;
pub mod term;
#[cfg(test)]
mod translations;
pub mod verify;
pub mod words;
