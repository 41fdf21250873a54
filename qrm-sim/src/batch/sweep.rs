//! A sweep: designs of a mechanism, each with its own parameters.

use qrm_core::{Batch, BatchRequest, Mechanism, Model, ParameterOverrides, Width};

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

/// A processor with lanes of its own, such as a GPU.
pub trait Device: Sync {
    /// A batch of motions, whose steps count as reliable up to this residual of the constraints; `None` if the device
    /// cannot make it.
    fn batch(&self, request: BatchRequest, residual: f64) -> Option<Batch>;
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
        LaneCount::Most => &WIDTHS,
        LaneCount::Four => &[Width::Four],
        LaneCount::One => &[],
    };
    run(in_lanes(model, &designs, request, widths), &designs, request)
}

/// Runs designs in the lanes of a device, or in those of the processor if the device has none for them.
pub fn sweep_on(
    device: &dyn Device,
    model: &Model,
    designs: &[ParameterOverrides],
    request: &SweepRequest,
) -> Vec<DesignResult> {
    let designs = model.mechanisms(designs);
    let lanes = LaneSweep::new(model, &designs, request, &|of_batch, residual| device.batch(of_batch, residual));
    run(lanes.or_else(|| in_lanes(model, &designs, request, &WIDTHS)), &designs, request)
}

/// All widths, the preferred one first.
const WIDTHS: [Width; 2] = [Width::Eight, Width::Four];

/// A sweep in lanes of the first width that there is.
fn in_lanes<'a>(
    model: &Model,
    designs: &'a [Box<dyn Mechanism>],
    request: &'a SweepRequest<'a>,
    widths: &[Width],
) -> Option<LaneSweep<'a>> {
    let of_width = |width: &Width| {
        LaneSweep::new(model, designs, request, &|of_batch, residual| model.batch(*width, of_batch, residual))
    };
    widths.iter().find_map(of_width)
}

/// Runs designs in lanes, or one by one without any.
fn run(lanes: Option<LaneSweep>, designs: &[Box<dyn Mechanism>], request: &SweepRequest) -> Vec<DesignResult> {
    match lanes {
        Some(lanes) => lanes.run(),
        None => (0..designs.len()).map(|design| run_alone(design, &*designs[design], request)).collect(),
    }
}
