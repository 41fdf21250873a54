//! The derivatives of quantities with respect to toleranced parameters.

use std::collections::BTreeMap;

use qrm_scene::names::suggestion;

use super::parameter::TolerancedParameter;
use crate::commands::sensitivity::{DerivativeRequest, Quantity as Row};
use crate::error::Error;
use crate::setup::Setup;

/// A quantity with its unconfirmed derivatives.
pub(super) struct Derived {
    /// The column of a sweep.
    pub(super) name: String,
    pub(super) unit: String,
    /// The derivative with respect to each toleranced parameter.
    pub(super) derivatives: Vec<f64>,
}

/// The requested quantities with their derivatives.
pub(super) fn find(setup: &Setup, parameters: &[TolerancedParameter], of: &[String]) -> Result<Vec<Derived>, Error> {
    let names: Vec<String> = parameters.iter().map(|parameter| parameter.name.clone()).collect();
    let found = DerivativeRequest::new(setup, &names, &[], BTreeMap::new(), false)?.compute(setup)?;
    let place = |name: &String| found.by.iter().position(|by| by == name).unwrap_or(0);
    let quantity = |row: &Row| {
        let name = match (row.what, row.name.as_str()) {
            ("end", "t") => "end_time".to_owned(),
            ("end", name) if !setup.description.outputs.iter().any(|output| output.name == name) => name.to_owned(),
            ("minimum", name) => format!("{name}_min"),
            ("maximum", name) => format!("{name}_max"),
            _ => return None,
        };
        let derivatives = names.iter().map(|name| row.value.by[place(name)]).collect();
        let is_default = row.what != "end" || name == "end_time";
        Some((is_default, Derived { name, unit: row.unit.clone(), derivatives }))
    };
    let all: Vec<(bool, Derived)> = found.quantities(setup).iter().filter_map(quantity).collect();
    let known = || all.iter().map(|(_, derived)| derived.name.as_str());
    if let Some(unknown) = of.iter().find(|of| !known().any(|name| name == of.as_str())) {
        let help = suggestion(unknown, known(), || format!("columns: {}", known().collect::<Vec<_>>().join(", ")));
        return Err(Error::usage(format!("`--of {unknown}`: no column of a sweep has this name")).help(help));
    }
    let is_asked = |(is_default, derived): &(bool, Derived)| {
        if of.is_empty() { *is_default } else { of.contains(&derived.name) }
    };
    let chosen: Vec<Derived> = all.into_iter().filter(is_asked).map(|(_, derived)| derived).collect();
    if chosen.is_empty() {
        return Err(Error::usage(format!("scene `{}` has no outputs", setup.description.name))
            .help("name a coordinate by `--of`, or give the scene outputs"));
    }
    Ok(chosen)
}
