//! Equations of motion by the symbolic engine.

mod formula;
mod golden;
mod names;
mod structure;
mod verify;
