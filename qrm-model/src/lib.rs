//! The equations of motion of the mechanisms in `scenes/`, one module for each.
//!
//! The build script generates the modules. Each holds the functions of the TMT method for one mechanism, generic over
//! the number type, and a struct that implements [`Kernel`](qrm_core::Kernel). `MODELS` lists them for simulators.
//!
//! Without the feature `std` the crate needs neither a standard library nor an allocator; `libm` then computes roots
//! and powers.

#![no_std]

include!(concat!(env!("OUT_DIR"), "/scenes/scenes.rs"));
