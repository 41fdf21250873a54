//! `mode-1.gif`: the mechanism moving in a mode.

use std::f64::consts::TAU;

use qrm_core::Mechanism;
use qrm_pictures::{Recording, motion};
use qrm_sim::analysis::{Equilibrium, Mode, ModeKind};
use qrm_sim::columns::{Kind, columns};
use qrm_sim::position::{LoopSolver, Start};
use qrm_view::gif::gif;

use crate::error::Error;
use crate::format::number;
use crate::setup::Setup;

/// The most modes that are drawn.
pub(super) const MOST: usize = 6;
/// The amplitude, in rad, or relative to the largest length.
const AMPLITUDE: f64 = 0.15;
/// The number of positions in a period.
const FRAMES: u32 = 48;
/// The period of a mode that does not oscillate, in s.
const PERIOD: f64 = 2.0;

/// Draws a period of a mode, with loops closed at a visible amplitude.
pub(super) fn picture(
    setup: &Setup,
    mechanism: &dyn Mechanism,
    at: &Equilibrium,
    (place, mode): (usize, &Mode),
) -> Result<Vec<u8>, Error> {
    let description = setup.description;
    let has_angles = (0..at.q.len()).any(|i| description.is_angle(i));
    let longest = at.q.iter().fold(0.0, |most: f64, q| most.max(q.abs()));
    let amplitude = if has_angles || longest == 0.0 { AMPLITUDE } else { AMPLITUDE * longest };
    let (rate, kind) = (mode.rate().0, mode.kind());
    let period = if kind == ModeKind::Oscillation { TAU / rate } else { PERIOD };
    let drive = LoopSolver::new(mechanism, Start::new(mechanism).given);
    let kinds: Vec<Kind> = columns(description).iter().map(|column| column.kind).collect();
    let mut recording = Recording::new(description);
    for frame in 0..=FRAMES {
        let part = f64::from(frame) / f64::from(FRAMES);
        let moved = amplitude * (TAU * part).sin();
        let linear: Vec<f64> = at.q.iter().zip(&mode.shape).map(|(q, shape)| q + moved * shape).collect();
        let closed = drive.as_ref().and_then(|drive| drive.solve_loops(linear.clone()));
        let q = closed.map_or(linear, |position| position.q);
        let column = |kind: &Kind| match *kind {
            Kind::Time => part * period,
            Kind::Coordinate(i) => q[i],
            _ => 0.0,
        };
        recording.frames.push(kinds.iter().map(column).collect());
    }
    let (mut motion, _) = motion(&setup.scene, &setup.parameters(), &recording)?;
    motion.title = match kind {
        ModeKind::Oscillation => format!("mode {place}: {} Hz", number(rate / TAU)),
        ModeKind::Free => format!("mode {place}: a free motion"),
        ModeKind::Growth => format!("mode {place}: grows by {} 1/s", number(rate)),
    };
    motion.arrows.clear();
    motion.plots.clear();
    gif(&motion).map_err(|e| Error::run(format!("no picture of mode {place} could be made: {e}")))
}
