//! A scene and what is computed of it.

use std::path::PathBuf;

use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use qrm_cli::api::{self, LoadedScene, Run, SteadyOptions};
use qrm_core::{Description, QuantityDescription};
use qrm_model::MODELS;
use qrm_sim::columns::columns;
use qrm_sim::integrate::METHODS;

use crate::error::{exception, made};
use crate::interrupt::detached;
use crate::options::{options, whole};

/// A scene that is loaded.
#[pyclass(frozen, module = "qrm._native")]
pub(crate) struct Scene {
    pub(crate) loaded: LoadedScene,
}

/// Loads a scene by its name, or from a file.
#[pyfunction]
pub(crate) fn load(py: Python, name: &str) -> PyResult<Scene> {
    let loaded = detached(py, || LoadedScene::load(MODELS, name))?;
    Ok(Scene { loaded: loaded.map_err(|error| exception(py, &error))? })
}

/// Loads the scene of a text that was read from a file.
#[pyfunction]
pub(crate) fn load_source(py: Python, path: &str, source: &str) -> PyResult<Scene> {
    let loaded = detached(py, || LoadedScene::from_source(MODELS, path, source))?;
    Ok(Scene { loaded: loaded.map_err(|error| exception(py, &error))? })
}

/// The names of the compiled scenes.
#[pyfunction]
pub(crate) fn scenes() -> Vec<&'static str> {
    MODELS.iter().map(|model| model.description.name).collect()
}

/// The integration methods, each with what it is.
#[pyfunction]
pub(crate) fn methods() -> Vec<(&'static str, &'static str)> {
    METHODS.iter().map(|method| (method.name, method.doc)).collect()
}

/// Makes a file the symbolic engine that derives scene files.
#[pyfunction]
pub(crate) fn choose_engine(program: PathBuf) {
    api::choose_engine(program);
}

/// Name, unit and meaning.
type Quantity = (String, String, String);

#[pymethods]
impl Scene {
    #[getter]
    fn name(&self) -> &'static str {
        self.description().name
    }

    #[getter]
    fn doc(&self) -> &'static str {
        self.description().doc
    }

    #[getter]
    fn source(&self) -> &'static str {
        self.description().source
    }

    #[getter]
    fn is_compiled(&self) -> bool {
        !self.loaded.model().is_interpreted()
    }

    /// The columns of its trajectories.
    fn columns(&self) -> Vec<Quantity> {
        columns(self.description()).into_iter().map(|column| (column.name, column.unit, column.doc)).collect()
    }

    fn coordinates(&self) -> Vec<Quantity> {
        quantities(self.description().coordinates)
    }

    fn constraints(&self) -> Vec<Quantity> {
        quantities(self.description().constraints)
    }

    fn outputs(&self) -> Vec<Quantity> {
        quantities(self.description().outputs)
    }

    /// The parameters of the scene.
    fn parameters(&self) -> Vec<Quantity> {
        let parameters = self.description().parameters.iter();
        parameters.map(|p| (p.name.to_owned(), p.unit.to_owned(), p.doc.to_owned())).collect()
    }

    /// The values of the parameters.
    fn values(&self, py: Python, asked: &Bound<PyDict>) -> PyResult<Vec<f64>> {
        let asked = options(asked)?;
        self.loaded.parameters(&asked).map_err(|error| exception(py, &error))
    }

    /// A run: its rows, the text of its summary, its warnings, and the exception for its problem.
    fn run<'py>(
        &self,
        py: Python<'py>,
        asked: &Bound<'py, PyDict>,
        every: &Bound<'py, PyAny>,
        estimate_error: bool,
    ) -> PyResult<RunOfPython<'py>> {
        let asked = options(asked)?;
        let every = whole("every", every, 1..=u32::MAX.into())?;
        let run = detached(py, || self.loaded.run(&asked, every.into(), estimate_error))?;
        run_of(py, run.map_err(|error| exception(py, &error))?)
    }

    /// A steady motion: the text of `steady.json`, and a run over its period.
    fn steady<'py>(
        &self,
        py: Python<'py>,
        asked: &Bound<'py, PyDict>,
        period: Option<String>,
        phase: Option<String>,
        counts: [Bound<'py, PyAny>; 3],
        solve: Option<(String, String)>,
    ) -> PyResult<(String, RunOfPython<'py>)> {
        let run = options(asked)?;
        let [cycles, settle, rows] = &counts;
        let cycles = whole("cycles", cycles, 1..=1000)?;
        let settle = whole("settle", settle, 0..=1_000_000)?;
        let rows = whole("rows", rows, 4..=1_000_000)?;
        let asked = SteadyOptions { run, period, phase, cycles, settle, rows, solve };
        let (steady, run) = detached(py, || self.loaded.steady(&asked))?.map_err(|error| exception(py, &error))?;
        Ok((steady, run_of(py, run)?))
    }
}

/// Rows, the text of a summary, warnings, and the exception for a problem.
type RunOfPython<'py> = (Bound<'py, PyArray2<f64>>, String, Vec<String>, Option<Bound<'py, PyAny>>);

fn run_of(py: Python, run: Run) -> PyResult<RunOfPython> {
    let width = run.columns.len();
    let values = PyArray1::from_vec(py, run.values);
    let rows = values.len()? / width;
    let problem = run.problem.as_ref().map(|error| made(py, error)).transpose()?;
    Ok((values.reshape([rows, width])?, run.summary, run.warnings, problem))
}

impl Scene {
    fn description(&self) -> &'static Description {
        self.loaded.description()
    }
}

fn quantities(of: &[QuantityDescription]) -> Vec<Quantity> {
    of.iter().map(|q| (q.name.to_owned(), q.unit.to_owned(), q.doc.to_owned())).collect()
}
