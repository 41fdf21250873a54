//! The command `qrm`, for the script of the package.

use std::ffi::OsString;
use std::panic::catch_unwind;

use pyo3::prelude::*;

/// The exit status of a program that panics.
const PANICKED: u8 = 101;

/// Runs a command line, the first word of which is the name of the program; returns its exit status.
#[pyfunction]
pub(crate) fn command(py: Python, arguments: Vec<OsString>) -> u8 {
    // What panics has said so.
    py.detach(|| catch_unwind(|| qrm_cli::execute(qrm_model::MODELS, arguments)).unwrap_or(PANICKED))
}
