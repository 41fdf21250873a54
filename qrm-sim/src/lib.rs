//! Simulates mechanisms with closed loops.
//!
//! Constant data (a [`Mechanism`](qrm_mechanism::Mechanism) with its parameters) and the state of a run are separate;
//! the algorithms are free functions, generic over the mechanism and its size. Nothing is allocated inside a step.

pub mod assembly;
mod book;
pub mod linear;
pub mod motion;
pub mod observer;
pub mod outcome;
pub mod projection;
pub mod rk4;
pub mod scenes;
pub mod simulate;
pub mod solve;

pub mod command;
mod extremes;
mod summary;
mod trajectory;
