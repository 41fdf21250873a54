//! Derivatives, equations of motion, accuracy and pages.

use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use qrm_cli::api::{AccuracyOptions, SensitivityOptions};

use crate::error::{exception, made};
use crate::interrupt::detached;
use crate::options::options;
use crate::scene::Scene;

#[pymethods]
impl Scene {
    /// Derivatives by parameters.
    fn sensitivity<'py>(
        &self,
        py: Python<'py>,
        asked: &Bound<'py, PyDict>,
        by: Vec<String>,
        of: Vec<String>,
        hessian_vector: Vec<(String, f64)>,
        check: bool,
    ) -> PyResult<Bound<'py, PyDict>> {
        let asked = SensitivityOptions { run: options(asked)?, by, of, hessian_vector, check };
        let found = detached(py, || self.loaded.sensitivity(&asked))?.map_err(|error| exception(py, &error))?;
        let shape = [found.values.len(), found.by.len()];
        let result = PyDict::new(py);
        result.set_item("quantities", found.quantities.iter().map(|[a, b, c]| (a, b, c)).collect::<Vec<_>>())?;
        result.set_item("by", &found.by)?;
        result.set_item("values", PyArray1::from_vec(py, found.values))?;
        result.set_item("jacobian", matrix(py, found.jacobian, shape)?)?;
        result.set_item("hessian_vector", found.hessian_vector.map(|it| matrix(py, it, shape)).transpose()?)?;
        if let Some([values, jacobian, hessian_vector]) = found.errors {
            result.set_item("value_errors", PyArray1::from_vec(py, values))?;
            result.set_item("jacobian_errors", matrix(py, jacobian, shape)?)?;
            if !hessian_vector.is_empty() {
                result.set_item("hessian_vector_errors", matrix(py, hessian_vector, shape)?)?;
            }
        }
        result.set_item("problem", found.problem.as_ref().map(|error| made(py, error)).transpose()?)?;
        Ok(result)
    }

    /// Equilibria and modes, in JSON.
    fn modes(&self, py: Python, asked: &Bound<PyDict>, at: Vec<String>, others: bool) -> PyResult<String> {
        let asked = options(asked)?;
        detached(py, || self.loaded.modes(&asked, &at, others))?.map_err(|error| exception(py, &error))
    }

    /// A linear model about an equilibrium, in JSON.
    fn linearize(
        &self,
        py: Python,
        asked: &Bound<PyDict>,
        at: Vec<String>,
        inputs: Vec<String>,
        outputs: Vec<String>,
    ) -> PyResult<String> {
        let asked = options(asked)?;
        detached(py, || self.loaded.linearize(&asked, &at, &inputs, &outputs))?.map_err(|error| exception(py, &error))
    }

    /// The equations of motion at a state.
    fn equations<'py>(
        &self,
        py: Python<'py>,
        asked: &Bound<'py, PyDict>,
        t: f64,
        q: Vec<f64>,
        qd: Vec<f64>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let asked = options(asked)?;
        let found = self.loaded.equations(&asked, t, &q, &qd).map_err(|error| exception(py, &error))?;
        let (n, m) = (q.len(), found.residuals.len());
        let result = PyDict::new(py);
        result.set_item("mass_matrix", matrix(py, found.mass_matrix, [n, n])?)?;
        result.set_item("forces", PyArray1::from_vec(py, found.generalized_forces))?;
        result.set_item("C", PyArray1::from_vec(py, found.residuals))?;
        result.set_item("C_q", matrix(py, found.constraint_jacobian, [m, n])?)?;
        result.set_item("C_t", PyArray1::from_vec(py, found.constraint_rate))?;
        let gamma = found.constraint_bias.iter().map(|bias| -bias).collect();
        result.set_item("gamma", PyArray1::from_vec(py, gamma))?;
        result.set_item("qdd", PyArray1::from_vec(py, found.accelerations))?;
        result.set_item("multipliers", PyArray1::from_vec(py, found.multipliers))?;
        result.set_item("outputs", PyArray1::from_vec(py, found.outputs))?;
        let [kinetic_energy, potential_energy] = found.energy;
        result.set_item("kinetic_energy", kinetic_energy)?;
        result.set_item("potential_energy", potential_energy)?;
        Ok(result)
    }

    /// Coordinates and rates at the start.
    fn start<'py>(&self, py: Python<'py>, asked: &Bound<'py, PyDict>) -> PyResult<[Bound<'py, PyArray1<f64>>; 2]> {
        let asked = options(asked)?;
        let start = self.loaded.start(&asked).map_err(|error| exception(py, &error))?;
        Ok(start.map(|vector| PyArray1::from_vec(py, vector)))
    }

    /// Run times and errors of every method.
    fn accuracy<'py>(
        &self,
        py: Python<'py>,
        asked: &Bound<'py, PyDict>,
        at: Vec<f64>,
        of: Option<String>,
        reference: Option<String>,
        budget: String,
    ) -> PyResult<Bound<'py, PyDict>> {
        let at = at.iter().map(|t| format!("{t:?}")).collect();
        let asked = AccuracyOptions { run: options(asked)?, at, of, reference, budget };
        let found = detached(py, || self.loaded.accuracy(&asked))?.map_err(|error| exception(py, &error))?;
        let result = PyDict::new(py);
        result.set_item("table", String::from_utf8_lossy(&found.table))?;
        result.set_item("text", found.text)?;
        result.set_item("reference", found.reference)?;
        result.set_item("recommendations", found.recommendations)?;
        result.set_item("figure", found.figure.ok())?;
        result.set_item("warnings", found.warnings)?;
        Ok(result)
    }

    /// The page that simulates the scene.
    fn page(&self, py: Python) -> PyResult<String> {
        detached(py, || self.loaded.page())?.map_err(|error| exception(py, &error))
    }

    /// The page that plays a run.
    fn animation(&self, py: Python, asked: &Bound<PyDict>) -> PyResult<String> {
        let asked = options(asked)?;
        detached(py, || self.loaded.animation(&asked))?.map_err(|error| exception(py, &error))
    }
}

fn matrix(py: Python, entries: Vec<f64>, shape: [usize; 2]) -> PyResult<Bound<PyArray2<f64>>> {
    PyArray1::from_vec(py, entries).reshape(shape)
}
