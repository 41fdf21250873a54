//! The equations of motion of the mechanisms in `scenes/`, each in a module of its own.
//!
//! The modules are generated when this crate is built. Each holds the functions of the TMT method for one mechanism,
//! generic over the number type, and a struct that implements [`Kernel`](qrm_core::Kernel). `MODELS` lists them for
//! simulators.
//!
//! Without the feature `std` it needs neither a standard library nor an allocator; `libm` computes its roots and powers
//! then.

#![no_std]

include!(concat!(env!("OUT_DIR"), "/scenes/scenes.rs"));
