//! Parameters with tolerances.

use qrm_core::Description;

use crate::error::Error;
use crate::options::{check_parameter, check_units, number, unit_of_parameter};
use crate::setup::Setup;

/// A parameter that varies around its value.
pub(super) struct TolerancedParameter {
    pub(super) name: String,
    pub(super) unit: &'static str,
    /// The given value; the scene's if `None`.
    given: Option<f64>,
    pub(super) value: f64,
    /// The largest difference from the value.
    pub(super) tolerance: f64,
}

impl TolerancedParameter {
    /// Reads a parameter written as `NAME=VALUE+-TOLERANCE` or `NAME=+-TOLERANCE`.
    pub(super) fn new(text: &str, description: &Description) -> Result<Self, Error> {
        let parts = text.split_once('=').and_then(|(name, rest)| {
            let (value, tolerance) = rest.split_once("+-").or_else(|| rest.split_once('±'))?;
            Some((name.trim(), value.trim(), tolerance.trim()))
        });
        let Some((name, value, tolerance)) = parts else {
            return Err(wrong(text, "has no tolerance"));
        };
        let option = format!("--vary {name}");
        let unit = unit_of_parameter(description, name);
        let given = if value.is_empty() { None } else { Some(number(&option, value, unit)?) };
        if tolerance.contains("+-") || tolerance.contains('±') {
            return Err(wrong(text, &format!("has no number after `+-`, but `{tolerance}`")));
        }
        if !value.is_empty() {
            check_units(&option, &[value, tolerance])?;
        }
        let tolerance = number(&option, tolerance, unit)?;
        if !(tolerance > 0.0 && tolerance.is_finite()) {
            return Err(wrong(text, "has a tolerance that is not above zero"));
        }
        Ok(Self { name: name.to_owned(), unit: "", given, value: f64::NAN, tolerance })
    }

    /// The assignment of the given value, as for `--set`; `None` without one.
    pub(super) fn assignment(&self) -> Option<String> {
        self.given.map(|value| format!("{}={value:?}", self.name))
    }
}

/// Returns an error if a parameter is unknown, or named twice.
pub(super) fn check(parameters: &[TolerancedParameter], setup: &Setup) -> Result<(), Error> {
    for (i, TolerancedParameter { name, .. }) in parameters.iter().enumerate() {
        check_parameter(setup.description, name)?;
        if parameters[..i].iter().any(|other| other.name == *name) {
            return Err(Error::given_twice(&format!("--vary {name}")));
        }
        if setup.set.contains_key(name) {
            return Err(Error::usage(format!("`{name}` is both set and varied"))
                .help(format!("omit `--set {name}`, and write `--vary {name}=VALUE+-TOLERANCE`")));
        }
    }
    Ok(())
}

/// Adds values and units from a scene in which the given values are set.
pub(super) fn complete(parameters: &mut [TolerancedParameter], setup: &Setup) {
    let values = setup.model.parameter_values(&setup.replace());
    for (described, value) in setup.description.parameters.iter().zip(values) {
        for parameter in parameters.iter_mut().filter(|parameter| parameter.name == described.name) {
            (parameter.value, parameter.unit) = (value, described.unit);
        }
    }
}

fn wrong(text: &str, why: &str) -> Error {
    Error::usage(format!("`--vary {text}` {why}"))
        .help("write `--vary NAME=VALUE+-TOLERANCE`, or `--vary NAME=+-TOLERANCE` for the value of the scene")
}
