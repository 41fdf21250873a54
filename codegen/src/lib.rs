//! Differentiates a mechanism given as formulae, and generates plain Rust code for its equations of motion.
//!
//! The phases pass plain data to each other: `qrm_scene` (text to [`Scene`](qrm_scene::scene::Scene)), the program
//! `qrm-engine` (scene to [`term`]s; the only part that contains symbolica), [`lower`] and [`share`] (terms to a
//! [`graph`]), [`functions`] (graph to a [`NamedTape`](qrm_core::NamedTape)). [`verify`] compares the tape with the
//! scene.

pub mod derivation;
pub mod formula;
pub mod functions;
pub mod graph;
pub mod kernel;
#[cfg(test)]
mod language_tests;
pub mod lower;
pub mod names;
mod notes;
pub mod omissions;
pub mod share;
pub mod term;
pub mod verify;
