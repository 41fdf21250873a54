//! The algorithm of the assignment's MATLAB script for the quick-return mechanism, compared with the exact motion.
//!
//! ```text
//! document [STEP [FILE]]
//! ```
//!
//! `STEP` is the step in seconds (1e-3 by default). The columns of the script go to `FILE` (`out/document.csv` by
//! default), each beside its exact values. The largest errors are printed.

mod comparison;
mod exact;
mod motion;
mod script;
#[cfg(test)]
mod tests;

use std::error::Error;
use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use qrm_model::quick_return::QuickReturn;

use crate::comparison::{Comparison, NAMES};

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let step: f64 = match arguments.next() {
        Some(text) => text.parse().map_err(|e| format!("the step `{text}`: {e}"))?,
        None => 1e-3,
    };
    if !(step > 0.0 && step.is_finite()) {
        return Err("the step must be above zero".into());
    }
    let file = arguments.next().map_or_else(|| PathBuf::from("out/document.csv"), PathBuf::from);
    let comparison = Comparison::new(&QuickReturn::default(), step)?;
    print!("{}", comparison.table());
    save(&comparison, &file).map_err(|e| format!("{}: {e}", file.display()))?;
    println!("\nwrote {} ({} rows)", file.display(), comparison.script.len());
    Ok(())
}

/// Writes the file, and its folder where it is missing.
fn save(comparison: &Comparison, file: &Path) -> io::Result<()> {
    if let Some(folder) = file.parent() {
        fs::create_dir_all(folder)?;
    }
    let mut csv = BufWriter::new(File::create(file)?);
    write(comparison, &mut csv)?;
    csv.flush()
}

/// Writes the columns of the script, each beside its exact values.
fn write(comparison: &Comparison, csv: &mut impl Write) -> io::Result<()> {
    write!(csv, "t")?;
    for name in NAMES {
        write!(csv, ",{name},{name}_exact")?;
    }
    for (script, exact) in comparison.script.iter().zip(&comparison.exact) {
        write!(csv, "\n{}", script.t)?;
        for (value, exact) in script.values().iter().zip(exact.values()) {
            write!(csv, ",{value},{exact}")?;
        }
    }
    writeln!(csv)
}
