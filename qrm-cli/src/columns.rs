//! Files that describe the columns of a table.

use std::path::{Path, PathBuf};

use qrm_sim::columns::Column;
use serde::Serialize;

use crate::error::Error;
use crate::output::{Named, save_json};

/// The unit and the meaning of a column.
#[derive(Serialize)]
struct Meaning<'c> {
    unit: &'c str,
    doc: &'c str,
}

/// Writes `NAME.units.json` beside the table `NAME.csv`: unit and meaning of each column.
pub(crate) fn write_units<K>(table: &Path, columns: &[Column<K>]) -> Result<PathBuf, Error> {
    let path = table.with_extension("units.json");
    let entries = columns.iter().map(|column| (column.name.clone(), Meaning { unit: &column.unit, doc: &column.doc }));
    save_json(&path, &Named(entries.collect()))?;
    Ok(path)
}
