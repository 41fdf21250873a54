//! The simulator of a page: a derived scene that runs in a browser, by the crates of the command.
//!
//! The simulator itself is compiled for WebAssembly alone, by `crates/page/build`. Other programs contain the result,
//! [`MODULE`], and pack scenes for it.

#[cfg(target_family = "wasm")]
#[expect(unreachable_pub, reason = "the page calls them by their names")]
mod exports;
#[cfg(target_family = "wasm")]
mod named_values;
mod packed;
#[cfg(target_family = "wasm")]
mod simulator;

pub use packed::packed;

/// This crate as a module of WebAssembly, compressed by gzip: `crates/page/build` makes it.
#[cfg(not(target_family = "wasm"))]
pub const MODULE: &[u8] = include_bytes!("../simulator.wasm.gz");
