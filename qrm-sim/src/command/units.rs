//! What stands in the columns of a table, for programs that read it: a JSON file beside it, with unit and meaning of each column.

use std::path::{Path, PathBuf};

use qrm_core::Description;
use serde::Serialize;

use crate::summary::Named;
use crate::unit::{Variable, variables};

/// Writes the file that belongs to a table, `NAME.units.json` beside `NAME.csv`, and says where.
///
/// # Errors
/// What is said when it cannot be written.
pub(super) fn write(table: &Path, columns: &[String], description: &Description) -> Result<PathBuf, String> {
    let path = table.with_extension("units.json");
    let variables = variables(description);
    let entries = columns.iter().map(|column| (column.clone(), meaning(column, &variables)));
    let text = serde_json::to_string_pretty(&Named(entries.collect())).map_err(std::io::Error::other);
    let written = text.and_then(|text| super::write(&path, format!("{text}\n").as_bytes()));
    written.map(|()| path.clone()).map_err(|e| super::unwritable(&path, &e))
}

/// What stands in a column.
#[derive(Serialize)]
struct Meaning {
    unit: String,
    doc: String,
}

fn meaning(column: &str, variables: &[Variable]) -> Meaning {
    let own = |unit: &str, doc: &str| Meaning { unit: unit.to_owned(), doc: doc.to_owned() };
    match column {
        "t" => return own("s", "time"),
        "design" => return own("", "number of the design"),
        "status" => return own("", "whether the design came to its end: done or failed"),
        "reason" => return own("", "why it did not"),
        "steps" => return own("", "steps made"),
        "end_time" => return own("s", "when the motion ended"),
        "estimated_error" => return own("rad or m", "largest error of a coordinate in any row, estimated"),
        "residual_position" => return own("m or rad", "largest residual of a constraint"),
        "residual_velocity" => return own("m/s or rad/s", "largest rate of a residual"),
        _ => {}
    }
    let find = |name: &str| variables.iter().find(|variable| variable.name == name);
    if let Some(variable) = find(column) {
        return own(&variable.unit, &variable.doc);
    }
    for (ending, what) in [("_min", "smallest"), ("_max", "largest")] {
        if let Some(variable) = column.strip_suffix(ending).and_then(find) {
            return own(&variable.unit, &format!("{what} value in the motion: {}", variable.doc));
        }
    }
    own("", "")
}
