//! Errors of the command as exceptions of the package, which `qrm/errors.py` defines.

use pyo3::prelude::*;
use pyo3::types::PyList;
use qrm_cli::api::{Error, Finding};

/// The exception for a wrong option, a wrong scene, or a run that failed.
pub(crate) fn exception(py: Python, error: &Error) -> PyErr {
    made(py, error).map_or_else(|failed| failed, PyErr::from_value)
}

/// The exception as an object that is not raised.
pub(crate) fn made<'py>(py: Python<'py>, error: &Error) -> PyResult<Bound<'py, PyAny>> {
    let findings = error.findings();
    let name = if error.is_of_run() {
        "RunError"
    } else if findings.is_empty() {
        "OptionError"
    } else {
        "SceneError"
    };
    let class = py.import("qrm.errors")?.getattr(name)?;
    let exception = class.call1((error.to_string(), error.hints()))?;
    if name == "SceneError" {
        let finding = |finding: &Finding| {
            let [line, column] = finding.place.map_or([None; 2], |place| place.map(Some));
            (finding.path.clone(), line, column, finding.text.clone(), finding.help.clone())
        };
        exception.call_method1("_set_findings", (PyList::new(py, findings.iter().map(finding))?,))?;
    }
    Ok(exception)
}
