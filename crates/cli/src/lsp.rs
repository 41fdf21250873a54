//! A language server for scene files: diagnostics, completion, hover, definitions, references and renaming.
//!
//! Positions are those of the protocol: lines, and characters in UTF-16. [`text`] converts them to bytes,
//! [`declaration`] finds the names that a scene declares, [`place`] the surroundings of a position, and [`completion`] what fits there.
//! [`values`] computes numbers at the start.

mod completion;
mod declaration;
mod edit;
mod hover;
mod place;
mod server;
mod text;
mod values;

pub(crate) use server::{capabilities, serve};
