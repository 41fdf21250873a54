//! `qrm merge`

use std::path::PathBuf;

use clap::Args;
use qrm_core::Model;

use super::sweep::join;
use crate::error::Error;
use crate::output::{print, save};

#[derive(Args)]
pub(crate) struct Options {
    /// The table to write, ending in `.csv` or `.parquet`
    #[arg(value_name = "OUT")]
    out: PathBuf,
    /// The parts in their order, in CSV
    #[arg(value_name = "PART", required = true)]
    parts: Vec<PathBuf>,
}

/// Joins the parts of a sweep that were computed apart.
pub(crate) fn run(_models: &'static [Model], options: &Options) -> Result<(), Error> {
    let rows = join(&options.parts, &options.out)?;
    let units = options.parts[0].with_extension("units.json");
    let mut files = format!("wrote {} ({rows} designs", options.out.display());
    // Parts may have been copied without their units.
    if let Ok(text) = std::fs::read(&units) {
        let path = options.out.with_extension("units.json");
        save(&path, &text)?;
        files += &format!("; units in {}", path.file_name().unwrap_or_default().display());
    }
    print(&(files + ")"));
    Ok(())
}
