//! Simulates mechanisms with closed loops.
//!
//! A mechanism is a [`Mechanism`](qrm_core::Mechanism): plain functions over slices, generated and compiled once for
//! each scene. This crate also works on slices and is compiled once for all scenes. The state of a run is separate from
//! the mechanism, and fixed steps do not allocate.
//!
//! [`run::Simulation`] is a motion that a program advances step by step, [`run::simulate`] a whole run with error
//! estimates, [`batch::sweep`] many designs simultaneously.

pub mod analysis;
pub mod batch;
pub mod columns;
mod differentiated;
pub mod integrate;
pub mod position;
pub mod run;
pub mod solve;
pub mod state;

mod bounds;
mod event;
mod maximum;
mod polynomial;
mod quadrature;
mod stopwatch;
