//! `qrm merge`

use std::path::PathBuf;

use clap::Args;
use qrm_core::Model;

use super::sweep::join;
use crate::error::Error;
use crate::format::counted;
use crate::output::print;

#[derive(Args)]
pub(crate) struct Options {
    /// The table to write, ending in `.csv` or `.parquet`
    #[arg(value_name = "OUT")]
    out: PathBuf,
    /// The tables of `qrm sweep --shard K/N`, in CSV, from the first part to the last
    #[arg(value_name = "PART", required = true)]
    parts: Vec<PathBuf>,
}

/// Joins the parts of a sweep that were computed separately.
pub(crate) fn run(_models: &'static [Model], options: &Options) -> Result<(), Error> {
    let (rows, units) = join(&options.parts, &options.out)?;
    let units = units.file_name().unwrap_or_default().display();
    print(&format!("wrote {} ({}; units in {units})", options.out.display(), counted(rows as u64, "design")));
    Ok(())
}
