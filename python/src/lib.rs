//! The extension module of the Python package `qrm`: what the command computes, as arrays.
//!
//! The classes that users see are written in Python, in `python/qrm`; this module has the functions below them.

mod analysis;
mod command;
mod error;
mod interrupt;
mod options;
mod scene;
mod sweep;

use mimalloc::MiMalloc;
use pyo3::pymodule;

#[global_allocator]
static ALLOCATOR: MiMalloc = MiMalloc;

// The functions of FMI below the command ask for the scenes by this symbol.
qrm_fmu::export!(qrm_model::MODELS);

#[pymodule]
mod _native {
    #[pymodule_export]
    use super::command::command;
    #[pymodule_export]
    use super::scene::{Scene, choose_engine, load, load_source, methods, scenes};
}
