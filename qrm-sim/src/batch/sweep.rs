//! A sweep: designs of a mechanism, each with its own parameters.

use qrm_core::{Model, ParameterOverrides, Width};

use super::design::{DesignResult, SweepRequest, run_alone};
use super::lanes::LaneSweep;

/// The number of designs that a core runs simultaneously.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LaneCount {
    /// One design for each lane of the processor.
    Most,
    /// At most four designs.
    Four,
    /// One design.
    One,
}

/// Runs designs, each with some parameters replaced, and returns their results in order.
pub fn sweep(
    model: &Model,
    designs: &[ParameterOverrides],
    request: &SweepRequest,
    lanes: LaneCount,
) -> Vec<DesignResult> {
    let designs = model.mechanisms(designs);
    let widths: &[Width] = match lanes {
        LaneCount::Most => &[Width::Eight, Width::Four],
        LaneCount::Four => &[Width::Four],
        LaneCount::One => &[],
    };
    match widths.iter().find_map(|width| LaneSweep::new(model, &designs, request, *width)) {
        Some(lanes) => lanes.run(),
        None => (0..designs.len()).map(|design| run_alone(design, &*designs[design], request)).collect(),
    }
}
