//! The command `qrm`, for the script of the package.

use std::ffi::OsString;

use pyo3::prelude::*;

/// Runs a command line, the first word of which is the name of the program; returns its exit status.
#[pyfunction]
pub(crate) fn command(py: Python, arguments: Vec<OsString>) -> u8 {
    py.detach(|| qrm_cli::execute(qrm_model::MODELS, arguments))
}
