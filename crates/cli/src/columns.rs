//! Files that describe the columns of a table.

use std::path::{Path, PathBuf};

use qrm_sim::columns::Column;
use serde::{Deserialize, Serialize};

use crate::error::Error;
use crate::output::{Named, save_json};

/// The unit and the description of a column.
#[derive(Serialize, Deserialize)]
pub(crate) struct Meaning {
    unit: String,
    doc: String,
}

impl Meaning {
    pub(crate) fn new<K>(column: &Column<K>) -> Self {
        Self { unit: column.unit.clone(), doc: column.doc.clone() }
    }
}

/// Writes `NAME.units.json` next to the table `NAME.csv`: unit and description of each column.
pub(crate) fn write_units<K>(table: &Path, columns: &[Column<K>]) -> Result<PathBuf, Error> {
    save_units(table, columns.iter().map(|column| (column.name.clone(), Meaning::new(column))).collect())
}

/// Writes the units of columns that are given by name.
pub(crate) fn save_units(table: &Path, columns: Vec<(String, Meaning)>) -> Result<PathBuf, Error> {
    let path = table.with_extension("units.json");
    save_json(&path, &Named(columns))?;
    Ok(path)
}
