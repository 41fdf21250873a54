//! Sweeps: many designs of one mechanism, several of them at once in the lanes of vectors.

mod lanes;
mod sweep;

pub use sweep::{DesignResult, LaneCount, SweepRequest, sweep};
