//! The variables of an FMU.

use qrm_core::Description;
use qrm_sim::columns::{Column, Kind, columns};

/// The variables of an FMU: time, parameters, then the columns of a trajectory except the residuals. The value
/// reference of a variable is its index.
pub fn variables(description: &Description) -> Vec<Column> {
    let mut variables = vec![Column::new("time", "s", "time", Kind::Time)];
    let parameters = description.parameters.iter().enumerate();
    variables.extend(parameters.map(|(i, p)| Column::new(p.name, p.unit, p.doc, Kind::Parameter(i))));
    let is_variable = |column: &Column| !matches!(column.kind, Kind::Time | Kind::Residual | Kind::ResidualRate);
    variables.extend(columns(description).into_iter().filter(is_variable));
    variables
}
