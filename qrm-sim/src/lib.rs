//! Simulates mechanisms with closed loops.
//!
//! Constant data (a [`Mechanism`](qrm_mechanism::Mechanism) with its parameters) and the state of a run are separate;
//! the algorithms are free functions, generic over the mechanism and its size. Nothing is allocated inside a step.

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
mod shadow;
pub mod simulate;
pub mod solve;
#[cfg(feature = "stability")]
pub mod spectrum;
#[cfg(feature = "sweep")]
pub mod sweep;
pub mod turn;

#[cfg_attr(not(feature = "pictures"), allow(dead_code, reason = "pictures need most of it"))]
mod album;
#[cfg(feature = "pictures")]
mod animation;
mod balance;
pub mod command;
#[cfg(feature = "pictures")]
mod drawing;
#[cfg_attr(not(feature = "pictures"), allow(dead_code, reason = "pictures need most of it"))]
mod envelope;
mod extremes;
#[cfg(feature = "pictures")]
mod figures;
#[cfg(feature = "sweep")]
mod lanes;
mod quadrature;
mod response;
#[cfg(feature = "pictures")]
mod stage;
mod stepper;
mod summary;
mod trajectory;
mod walk;
mod whole;
