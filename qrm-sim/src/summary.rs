//! `summary.json`: what a run was asked, how it ended, and how far its numbers can be trusted.

use std::io;
use std::path::Path;

use serde::Serialize;
use serde::ser::{SerializeMap, Serializer};

use crate::whole::write_whole;

/// A finished run, in the order of the file.
#[derive(Debug, Serialize)]
pub(crate) struct Summary {
    pub(crate) scene: String,
    pub(crate) method: &'static str,
    pub(crate) projection: &'static str,
    pub(crate) tolerance: Option<f64>,
    pub(crate) closure_tolerance: f64,
    pub(crate) step: f64,
    pub(crate) steps: u64,
    pub(crate) rejected_steps: u64,
    pub(crate) implicit_steps: u64,
    pub(crate) evaluations: u64,
    pub(crate) rows: u64,
    pub(crate) status: &'static str,
    pub(crate) message: String,
    pub(crate) end_time: f64,
    pub(crate) end_state: Named<f64>,
    pub(crate) run_seconds: f64,
    pub(crate) estimated_error: Option<f64>,
    pub(crate) max_residual_position: f64,
    pub(crate) max_residual_velocity: f64,
    /// Before the coordinates were corrected after a step, and by how much a coordinate was corrected at most.
    pub(crate) max_residual_before_correction: f64,
    pub(crate) max_correction: f64,
    pub(crate) smallest_singular_value: Option<SingularEntry>,
    /// Solves for which the fast factorisation did not do.
    pub(crate) careful_solves: u64,
    pub(crate) energy_drift: Option<f64>,
    pub(crate) energy_imbalance: f64,
    pub(crate) extremes: Named<ExtremesEntry>,
    pub(crate) parameters: Named<f64>,
    pub(crate) figures: Vec<String>,
    /// Why the numbers are not to be trusted, if so.
    pub(crate) distrust: Vec<String>,
    pub(crate) warnings: Vec<String>,
}

/// Extremes of a column.
#[derive(Debug, Serialize)]
pub(crate) struct ExtremesEntry {
    pub(crate) min: f64,
    pub(crate) min_time: f64,
    pub(crate) max: f64,
    pub(crate) max_time: f64,
}

/// Where the smallest singular value of C_q was smallest.
#[derive(Debug, Serialize)]
pub(crate) struct SingularEntry {
    pub(crate) value: f64,
    /// The largest that it was in any row.
    pub(crate) largest: f64,
    pub(crate) row: u64,
    pub(crate) time: f64,
    /// The constraint that has the largest part in what is nearest to saying nothing.
    pub(crate) constraint: &'static str,
}

/// Values under names, in their order.
#[derive(Debug)]
pub(crate) struct Named<T>(pub(crate) Vec<(String, T)>);

impl<T: Serialize> Serialize for Named<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(self.0.len()))?;
        for (name, value) in &self.0 {
            map.serialize_entry(name, value)?;
        }
        map.end()
    }
}

impl Summary {
    /// Writes the file.
    pub(crate) fn write(&self, path: &Path) -> io::Result<()> {
        let mut text = serde_json::to_string_pretty(self)?;
        text.push('\n');
        path.parent().map_or(Ok(()), std::fs::create_dir_all)?;
        write_whole(path, text.as_bytes())
    }

    /// The figures that the summary of an earlier run in a folder lists; none if there is no such summary.
    pub(crate) fn figures_of(folder: &Path) -> Vec<String> {
        let text = std::fs::read_to_string(folder.join("summary.json")).unwrap_or_default();
        let summary: serde_json::Value = serde_json::from_str(&text).unwrap_or_default();
        let listed = summary["figures"].as_array().cloned().unwrap_or_default();
        let names = listed.iter().filter_map(|figure| figure.as_str());
        // Whatever the file says, nothing else is meant.
        let is_figure = |name: &&str| {
            name.strip_prefix("figures/").is_some_and(|name| name.ends_with(".svg") && !name.contains(['/', '\\']))
        };
        names.filter(is_figure).map(str::to_owned).collect()
    }
}
