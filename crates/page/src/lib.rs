//! The simulator of a page: a derived scene that runs in a browser, with the same crates as the command.
//!
//! `crates/page/build` compiles the simulator, for WebAssembly only. Other programs contain the result, [`MODULE`], and
//! pack scenes for it.

#[cfg(target_family = "wasm")]
#[expect(unreachable_pub, reason = "the page calls them by their names")]
mod exports;
#[cfg(target_family = "wasm")]
mod named_values;
mod packed;
#[cfg(target_family = "wasm")]
mod simulator;

pub use packed::packed;

/// This crate as a WebAssembly module, compressed by gzip; created by `crates/page/build`.
#[cfg(not(target_family = "wasm"))]
pub const MODULE: &[u8] = include_bytes!("../simulator.wasm.gz");
