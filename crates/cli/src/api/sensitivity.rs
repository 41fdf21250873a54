//! Derivatives of a motion as matrices.

use super::options::RunOptions;
use super::scene::LoadedScene;
use crate::commands::sensitivity::{DerivativeRequest, Quantity};
use crate::error::Error;

/// The options of a sensitivity analysis.
#[derive(Clone, Debug, Default)]
pub struct SensitivityOptions {
    /// The options of the run.
    pub run: RunOptions,
    /// The parameters; all if empty.
    pub by: Vec<String>,
    /// The outputs, and `end` for the state at the end; all if empty.
    pub of: Vec<String>,
    /// The vector for Hessian products: entries by parameter.
    pub hessian_vector: Vec<(String, f64)>,
    /// Whether errors are estimated and derivatives compared with difference quotients.
    pub check: bool,
}

/// Derivatives of quantities of a motion with respect to parameters. Matrices have a row for each quantity and a column
/// for each parameter, and are stored row by row.
#[derive(Debug)]
pub struct Derivatives {
    /// Kind (`end`, `minimum`, `time_of_minimum`, ...), name and unit of each quantity.
    pub quantities: Vec<[String; 3]>,
    /// The parameters.
    pub by: Vec<&'static str>,
    /// The values of the quantities.
    pub values: Vec<f64>,
    /// The derivatives.
    pub jacobian: Vec<f64>,
    /// The products of the Hessian of each quantity with the vector, if one is given.
    pub hessian_vector: Option<Vec<f64>>,
    /// The estimated errors of values, derivatives and products, if requested.
    pub errors: Option<[Vec<f64>; 3]>,
    /// The reason not to trust the derivatives.
    pub problem: Option<Error>,
}

impl LoadedScene {
    /// Computes derivatives of a motion with respect to parameters: `qrm sensitivity`.
    ///
    /// # Errors
    /// An option is invalid, or the motion has no derivatives.
    pub fn sensitivity(&self, options: &SensitivityOptions) -> Result<Derivatives, Error> {
        let setup = self.setup(&options.run)?;
        if setup.has_own_start() {
            return Err(Error::usage("derivatives are taken of the motion from the start of the scene")
                .help("leave out `start`"));
        }
        let vector = options.hessian_vector.iter().cloned().collect();
        let found = DerivativeRequest::new(&setup, &options.by, &options.of, vector, options.check)?.compute(&setup)?;
        let rows = found.quantities(&setup);
        let matrix = |part: fn(&Quantity) -> Option<Vec<f64>>| -> Option<Vec<f64>> {
            let parts: Option<Vec<Vec<f64>>> = rows.iter().map(part).collect();
            parts.map(|parts| parts.concat())
        };
        let values = matrix(|row| row.errors.as_ref().map(|errors| vec![errors.value]));
        let derivatives = matrix(|row| row.errors.as_ref().map(|errors| errors.by.clone()));
        let products = matrix(|row| row.errors.as_ref().map(|errors| errors.hessian_vector.clone()));
        let errors = values.zip(derivatives).zip(products).map(|((a, b), c)| [a, b, c]);
        Ok(Derivatives {
            quantities: rows.iter().map(|row| [row.what.to_owned(), row.name.clone(), row.unit.clone()]).collect(),
            values: rows.iter().map(|row| row.value.value).collect(),
            jacobian: rows.iter().flat_map(|row| row.value.by.clone()).collect(),
            hessian_vector: (!options.hessian_vector.is_empty())
                .then(|| rows.iter().flat_map(|row| row.value.hessian_vector.clone()).collect()),
            errors: errors.filter(|_| options.check),
            problem: found.verdict().err(),
            by: found.by.clone(),
        })
    }
}
