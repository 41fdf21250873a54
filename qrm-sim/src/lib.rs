//! Simulates mechanisms with closed loops.
//!
//! A mechanism is a [`Mechanism`](qrm_core::Mechanism): plain functions over slices, generated and compiled once for
//! each scene. Everything here works on slices too and is compiled once for all of them. The state of a run is separate
//! from the mechanism, and nothing is allocated in a step of a fixed length.
//!
//! [`run::Simulation`] is a motion that a program advances at its own pace, [`run::simulate`] a whole run with
//! everything that is known of its errors, [`batch::sweep`] many designs at once.

pub mod analysis;
pub mod batch;
pub mod columns;
pub mod integrate;
pub mod position;
pub mod run;
pub mod solve;
pub mod state;

mod event;
mod maximum;
mod quadrature;
mod stopwatch;
