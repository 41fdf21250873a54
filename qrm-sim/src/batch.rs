//! Sweeps: many designs of one mechanism, several of them simultaneously in the lanes of vectors.

mod design;
mod lanes;
mod sweep;

pub use design::{DesignResult, SweepRequest};
pub use sweep::{Device, LaneCount, sweep, sweep_on};
