//! Simulates mechanisms with closed loops.
//!
//! Constant data (a [`Mechanism`](qrm_core::Mechanism) with its parameters) and the state of a run are separate;
//! the algorithms are free functions, generic over the mechanism and its size. Nothing is allocated inside a step.
//!
//! [`simulation::Simulation`] is a motion that a program advances at its own pace, [`simulate::simulate`] a whole run with all that is
//! known of its errors. Without default features this crate is these methods alone; the feature `command` adds the command `qrm`.

mod acceleration;
pub mod adaptive;
pub mod assembly;
mod book;
pub mod document;
pub mod energy_integral;
pub mod kinematics;
pub mod linear;
pub mod measure;
pub mod motion;
pub mod observer;
pub mod outcome;
pub mod projection;
pub mod rank;
pub mod rest;
pub mod rk4;
pub mod scenes;
#[cfg(feature = "sensitivity")]
pub mod sensitivity;
mod shadow;
pub mod simulate;
pub mod simulation;
pub mod solve;
#[cfg(feature = "stability")]
pub mod spectrum;
#[cfg(feature = "sweep")]
pub mod sweep;
pub mod trouble;
pub mod turn;
pub mod unit;

#[cfg(feature = "command")]
#[cfg_attr(not(feature = "pictures"), allow(dead_code, reason = "pictures need most of it"))]
mod album;
#[cfg(feature = "pictures")]
mod animation;
mod balance;
#[cfg(feature = "command")]
pub mod command;
#[cfg(feature = "pictures")]
mod drawing;
#[cfg(feature = "command")]
#[cfg_attr(not(feature = "pictures"), allow(dead_code, reason = "pictures need most of it"))]
mod envelope;
#[cfg(any(feature = "command", feature = "sensitivity"))]
mod extremes;
#[cfg(feature = "pictures")]
mod figures;
#[cfg(feature = "sensitivity")]
mod integral;
#[cfg(feature = "sweep")]
mod lanes;
mod quadrature;
mod response;
#[cfg(feature = "pictures")]
mod stage;
mod stepper;
#[cfg(feature = "command")]
mod summary;
#[cfg(feature = "command")]
mod trajectory;
mod walk;
#[cfg(feature = "command")]
mod whole;
