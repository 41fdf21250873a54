//! Sweeps.

use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList, PyString};
use qrm_cli::api::{Processor, SweepOptions, THREADS, Values};

use crate::error::exception;
use crate::interrupt::detached;
use crate::options::{options, whole};
use crate::scene::Scene;

/// Name, unit and meaning of a column, and its values: an array, or a list of texts.
type Column<'py> = (String, String, String, Bound<'py, PyAny>);

#[pymethods]
impl Scene {
    /// Runs many designs.
    #[pyo3(signature = (asked, vary, is_paired, extremes, estimate_error, threads, device))]
    #[expect(clippy::too_many_arguments, reason = "arguments of Python")]
    fn sweep<'py>(
        &self,
        py: Python<'py>,
        asked: &Bound<'py, PyDict>,
        vary: Vec<(String, Vec<f64>)>,
        is_paired: bool,
        extremes: bool,
        estimate_error: bool,
        threads: Option<Bound<'py, PyAny>>,
        device: &str,
    ) -> PyResult<(Vec<Column<'py>>, Vec<String>)> {
        let device = Processor::named(device).map_err(|error| exception(py, &error))?;
        let asked = SweepOptions {
            run: options(asked)?,
            vary,
            is_paired,
            no_extremes: !extremes,
            no_error_estimate: !estimate_error,
            threads: threads.map(|threads| whole("threads", &threads, THREADS)).transpose()?,
            device,
        };
        let sweep = detached(py, || self.loaded.sweep(&asked))?.map_err(|error| exception(py, &error))?;
        let columns = sweep
            .columns
            .into_iter()
            .map(|(column, values)| Ok((column.name, column.unit, column.doc, converted(py, values)?)));
        Ok((columns.collect::<PyResult<_>>()?, sweep.warnings))
    }
}

fn converted(py: Python, values: Values) -> PyResult<Bound<PyAny>> {
    Ok(match values {
        Values::Whole(values) => PyArray1::from_vec(py, values).into_any(),
        Values::Number(values) => PyArray1::from_vec(py, values).into_any(),
        Values::Text(values) => {
            // Most texts are the same.
            let mut last: Option<(String, Bound<PyString>)> = None;
            let texts = values.into_iter().map(|text| match &last {
                Some((same, object)) if *same == text => object.clone(),
                _ => {
                    let object = PyString::new(py, &text);
                    last = Some((text, object.clone()));
                    object
                }
            });
            PyList::new(py, texts.collect::<Vec<_>>())?.into_any()
        }
    })
}
