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
    pub(crate) tolerance: f64,
    pub(crate) step: f64,
    pub(crate) steps: u64,
    pub(crate) rows: u64,
    pub(crate) status: &'static str,
    pub(crate) message: String,
    pub(crate) end_time: f64,
    pub(crate) end_state: Named<f64>,
    pub(crate) run_seconds: f64,
    pub(crate) estimated_error: Option<f64>,
    pub(crate) max_residual_position: f64,
    pub(crate) max_residual_velocity: f64,
    pub(crate) energy_drift: Option<f64>,
    pub(crate) extremes: Named<ExtremesEntry>,
    pub(crate) parameters: Named<f64>,
    pub(crate) figures: Vec<String>,
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
    /// The text of the file.
    pub(crate) fn text(&self) -> io::Result<String> {
        let mut text = serde_json::to_string_pretty(self)?;
        text.push('\n');
        Ok(text)
    }

    /// Writes the file.
    pub(crate) fn write(&self, path: &Path) -> io::Result<()> {
        write_whole(path, self.text()?.as_bytes())
    }
}
