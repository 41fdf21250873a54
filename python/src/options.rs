//! The options of a run from a dictionary.

use std::ops::RangeInclusive;

use pyo3::exceptions::{PyOverflowError, PyTypeError};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict};
use qrm_cli::api::{Error, RunOptions};

use crate::error::exception;

/// The options in a dictionary, whose keys are the fields of [`RunOptions`]; `None` is as good as no entry.
pub(crate) fn options(dict: &Bound<PyDict>) -> PyResult<RunOptions> {
    let mut options = RunOptions::default();
    for (key, value) in dict {
        let key: String = key.extract()?;
        if value.is_none() {
            continue;
        }
        let field = match key.as_str() {
            "set" => {
                options.set = assignments(&key, &value)?;
                continue;
            }
            "start" => {
                options.start = assignments(&key, &value)?;
                continue;
            }
            "closure_iterations" => {
                options.closure_iterations = Some(whole(&key, &value, 0..=u32::MAX.into())?);
                continue;
            }
            "step" => &mut options.step,
            "end_time" => &mut options.end_time,
            "until" => &mut options.until,
            "method" => &mut options.method,
            "tolerance" => &mut options.tolerance,
            "max_step" => &mut options.max_step,
            "projection" => &mut options.projection,
            "closure_tolerance" => &mut options.closure_tolerance,
            _ => return Err(PyTypeError::new_err(format!("there is no option `{key}`"))),
        };
        *field = Some(text(&key, &value)?);
    }
    Ok(options)
}

/// The names and values of a dictionary.
fn assignments(option: &str, values: &Bound<PyAny>) -> PyResult<Vec<(String, String)>> {
    let wrong = || PyTypeError::new_err(format!("`{option}` must be a dict of names and numbers"));
    let values = values.cast::<PyDict>().map_err(|_| wrong())?;
    let assignment = |(name, value): (Bound<PyAny>, Bound<PyAny>)| {
        let name: String = name.extract().map_err(|_| wrong())?;
        let value = text(&name, &value)?;
        Ok((name, value))
    };
    values.iter().map(assignment).collect()
}

/// A whole number in a range.
pub(crate) fn whole(name: &str, value: &Bound<PyAny>, range: RangeInclusive<i64>) -> PyResult<u32> {
    let (least, most) = (range.start(), range.end());
    let outside = || wrong(value, &format!("`{name}` must be from {least} to {most}, but is {value}"));
    match value.extract::<u32>() {
        Ok(number) if range.contains(&number.into()) => Ok(number),
        Ok(_) => Err(outside()),
        Err(error) if error.is_instance_of::<PyOverflowError>(value.py()) => Err(outside()),
        Err(_) => Err(PyTypeError::new_err(format!("`{name}` must be a whole number, not {}", value.get_type()))),
    }
}

/// A number, or a formula, in the digits that read back as the same number.
fn text(name: &str, value: &Bound<PyAny>) -> PyResult<String> {
    if let Ok(text) = value.extract::<String>() {
        return Ok(text);
    }
    match value.extract::<f64>() {
        // A boolean would count as 0 or 1.
        Ok(number) if !value.is_instance_of::<PyBool>() => match number.is_finite() {
            true => Ok(format!("{number:?}")),
            false => Err(wrong(value, &format!("`{name}` must be finite, but is {value}"))),
        },
        Err(error) if error.is_instance_of::<PyOverflowError>(value.py()) => {
            Err(wrong(value, &format!("`{name}` is too large: it must be below 1.8e308")))
        }
        _ => Err(PyTypeError::new_err(format!("`{name}` must be a number or a text, not {}", value.get_type()))),
    }
}

/// The exception for a value that cannot be.
fn wrong(value: &Bound<PyAny>, message: &str) -> PyErr {
    exception(value.py(), &Error::usage(message))
}
