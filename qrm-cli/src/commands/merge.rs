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
    let mut files = format!("wrote {} ({rows} designs", options.out.display());
    let units = options.out.with_extension("units.json");
    // Parts may have been copied without their units; those of an earlier table would pass for this one's.
    let found = options.parts.iter().find_map(|part| std::fs::read(part.with_extension("units.json")).ok());
    match found {
        Some(text) => {
            save(&units, &text)?;
            files += &format!("; units in {}", units.file_name().unwrap_or_default().display());
        }
        None => _ = std::fs::remove_file(&units),
    }
    print(&(files + ")"));
    Ok(())
}
