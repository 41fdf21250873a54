//! The integration methods and projections as values of options.

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use qrm_sim::integrate::{METHODS, Method, RK4, method_named};
use qrm_sim::solve::Projection;

/// Reads the name of an integration method.
pub(crate) fn method_parser() -> impl TypedValueParser<Value = &'static Method> {
    let names = METHODS.iter().map(|method| PossibleValue::new(method.name).help(method.doc));
    PossibleValuesParser::new(names).map(|name| method_named(&name).unwrap_or(RK4))
}

/// Reads the name of a projection.
pub(crate) fn projection_parser() -> impl TypedValueParser<Value = Projection> {
    let names = Projection::ALL.map(|(name, _)| name);
    PossibleValuesParser::new(names).map(|name| Projection::named(&name).unwrap_or_default())
}

/// The name of a method with a projection in tables and pictures.
pub(crate) fn series_name(method: &Method, projection: Projection) -> String {
    let projection = match projection {
        Projection::None => "no projection",
        Projection::Euclidean => "Euclidean",
        Projection::Mass => "mass metric",
    };
    format!("{}, {projection}", method.name)
}
