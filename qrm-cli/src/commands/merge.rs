//! `qrm merge`

use std::path::PathBuf;

use clap::Args;
use qrm_core::Model;

use super::sweep::join;
use crate::error::Error;
use crate::output::print;

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
    print(&format!("wrote {} ({rows} designs)", options.out.display()));
    Ok(())
}
