//! Outputs as the assignment's script derives them from its states.

use std::io;

use qrm_scene::evaluate::State;
use qrm_scene::scene::{OutputKind, Scene};

use crate::observer::{Observer, Row};

/// Hands rows on in which positions and accelerations are a step late and rates are differences of positions.
pub(super) struct Late<'s> {
    scene: &'s Scene,
    parameters: Vec<f64>,
    inner: &'s mut dyn Observer,
    /// Of the row before: its time, its outputs, and the positions whose rates are asked for.
    before: Option<(f64, Vec<f64>, Vec<f64>)>,
}

impl<'s> Late<'s> {
    pub(super) fn new(scene: &'s Scene, parameters: Vec<f64>, inner: &'s mut dyn Observer) -> Self {
        Self { scene, parameters, inner, before: None }
    }
}

impl Observer for Late<'_> {
    fn row(&mut self, row: &Row) -> io::Result<()> {
        let state = State::plain(self.scene, &self.parameters, row.t, row.q, row.qd);
        let position = |kind: &OutputKind| match kind {
            OutputKind::Rate(value) => state.value(value),
            _ => f64::NAN,
        };
        let positions: Vec<f64> = self.scene.outputs.iter().map(|output| position(&output.kind)).collect();
        let mut outputs = row.outputs.to_vec();
        if let Some((t, late, earlier)) = &self.before {
            for (i, output) in self.scene.outputs.iter().enumerate() {
                match output.kind {
                    OutputKind::Value(_) | OutputKind::SecondRate(_) => outputs[i] = late[i],
                    OutputKind::Rate(_) => outputs[i] = (positions[i] - earlier[i]) / (row.t - t),
                    _ => {}
                }
            }
        }
        self.before = Some((row.t, row.outputs.to_vec(), positions));
        self.inner.row(&Row { outputs: &outputs, ..*row })
    }

    fn goes_on(&mut self, t: f64, end_time: f64) -> io::Result<bool> {
        self.inner.goes_on(t, end_time)
    }

    fn finish(&mut self) -> io::Result<()> {
        self.inner.finish()
    }
}
