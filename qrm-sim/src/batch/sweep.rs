//! A sweep: designs of a mechanism, each with parameters of its own.

use qrm_core::{Model, ParameterOverrides, Width};

use super::design::{DesignResult, SweepRequest, run_alone};
use super::lanes::LaneSweep;

/// The number of designs in the lanes of a core.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LaneCount {
    /// As many as the processor has lanes for.
    Most,
    /// Four at most.
    Four,
    /// One.
    One,
}

/// Runs designs, each with some parameters replaced, and returns their ends in their order.
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
