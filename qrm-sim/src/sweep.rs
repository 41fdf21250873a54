//! Many designs of one mechanism at once, in lanes: each lane makes the steps of one design until that has come to its end, and
//! then takes the next.

#[cfg(target_arch = "x86_64")]
mod crowd;
#[cfg(target_arch = "x86_64")]
mod ranges;
#[cfg(target_arch = "x86_64")]
mod settle;
#[cfg(target_arch = "x86_64")]
mod turnover;

use std::io;

use qrm_core::{Kernel, LARGE, Mechanism};

#[cfg(target_arch = "x86_64")]
use crowd::Crowd;

use crate::motion::Method;
use crate::observer::{Observer, Row};
use crate::outcome::{NoStart, Status};
use crate::simulate::{End, Request, simulate};

/// What every design of a sweep is asked to do.
pub struct SweepRequest<'a> {
    /// Length of the steps; the scene's if `None`.
    pub step: Option<f64>,
    /// The end; the scene's if `None`.
    pub end: Option<SweepEnd<'a>>,
    /// Whether smallest and largest values of the outputs are wanted.
    pub extremes: bool,
    /// Whether a second motion at twice the step estimates the error.
    pub estimate_error: bool,
}

/// Where designs end.
pub enum SweepEnd<'a> {
    /// At a time.
    Time(f64),
    /// When a function of the design's place, of time, coordinates and rates rises through zero.
    Condition(&'a DesignCondition<'a>),
}

/// A function of a design's place, of time, coordinates and rates.
pub type DesignCondition<'a> = dyn Fn(usize, f64, &[f64], &[f64]) -> f64 + Sync + 'a;

/// What became of a design.
#[derive(Debug)]
pub struct Finished {
    /// Why it ended; or why it could not begin.
    pub status: Result<Status, NoStart>,
    /// Steps made.
    pub steps: u64,
    /// Where it ended.
    pub end_time: f64,
    /// Coordinates there.
    pub q: Vec<f64>,
    /// Rates there.
    pub qd: Vec<f64>,
    /// Smallest and largest value of each output in any row, if they are wanted.
    pub extremes: Vec<[f64; 2]>,
    /// Estimated largest error of a coordinate in any row.
    pub estimated_error: Option<f64>,
}

/// How many designs are made at once.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Width {
    /// As many as the processor has lanes for.
    Most,
    /// Four at most.
    Four,
    /// One.
    One,
}

/// Runs designs, each a mechanism with parameters of its own, and says what became of each, in their order.
pub fn sweep<X: Mechanism<N, M>, const N: usize, const M: usize>(
    designs: &[X],
    request: &SweepRequest,
    width: Width,
) -> Vec<Finished> {
    #[cfg(target_arch = "x86_64")]
    {
        // Constants, so that what is not used is not compiled: each set of instructions takes as long as the kernel is large.
        let four: Option<InLanes<X, pulp::x86::V3>> =
            const { if X::Kernel::<f64>::OPERATIONS <= LARGE { Some(in_four::<X, N, M>) } else { None } };
        let eight: Option<InLanes<X, pulp::x86::V4>> =
            const { if X::Kernel::<f64>::OPERATIONS <= HUGE { Some(in_eight::<X, N, M>) } else { None } };
        match (pulp::Arch::new(), width) {
            (pulp::Arch::V4(simd), Width::Most) => {
                if let Some(eight) = eight {
                    return eight(simd, designs, request);
                }
            }
            (pulp::Arch::V4(_) | pulp::Arch::V3(_), Width::Most | Width::Four) => {
                if let Some((four, simd)) = four.zip(pulp::x86::V3::try_new()) {
                    return four(simd, designs, request);
                }
            }
            _ => {}
        }
    }
    let _ = width;
    designs.iter().enumerate().map(|(place, design)| alone(place, design, request)).collect()
}

/// Runs designs in lanes.
#[cfg(target_arch = "x86_64")]
type InLanes<X, S> = fn(S, &[X], &SweepRequest) -> Vec<Finished>;

#[cfg(target_arch = "x86_64")]
fn in_four<X: Mechanism<N, M>, const N: usize, const M: usize>(
    simd: pulp::x86::V3,
    designs: &[X],
    request: &SweepRequest,
) -> Vec<Finished> {
    simd.vectorize(Crowd::<X, pulp::x86::V3, N, M>::new(designs, request))
}

#[cfg(target_arch = "x86_64")]
fn in_eight<X: Mechanism<N, M>, const N: usize, const M: usize>(
    simd: pulp::x86::V4,
    designs: &[X],
    request: &SweepRequest,
) -> Vec<Finished> {
    simd.vectorize(Crowd::<X, pulp::x86::V4, N, M>::new(designs, request))
}

/// Kernels of more operations are not compiled for lanes.
const HUGE: usize = 2000;

/// A design by a run of its own.
fn alone<X: Mechanism<N, M>, const N: usize, const M: usize>(
    place: usize,
    design: &X,
    request: &SweepRequest,
) -> Finished {
    let mut extremes = Extremes::default();
    let until = |t: f64, q: &[f64], qd: &[f64]| match request.end {
        Some(SweepEnd::Condition(condition)) => condition(place, t, q, qd),
        _ => 0.0,
    };
    let end = match request.end {
        None => None,
        Some(SweepEnd::Time(t)) => Some(End::Time(t)),
        Some(SweepEnd::Condition(_)) => Some(End::Condition(&until)),
    };
    let method = Method::default();
    let wants_extremes = request.extremes;
    let request = Request { method, step: request.step, end, estimate_error: request.estimate_error };
    match simulate(design, &request, &mut extremes) {
        Err(reason) => Finished::unable(Err(reason)),
        Ok(outcome) => Finished {
            status: Ok(outcome.status),
            steps: outcome.counts.accepted,
            end_time: outcome.end_time,
            q: outcome.q,
            qd: outcome.qd,
            extremes: if wants_extremes { extremes.0 } else { Vec::new() },
            estimated_error: outcome.estimated_error,
        },
    }
}

/// Smallest and largest value of each output.
#[derive(Default)]
struct Extremes(Vec<[f64; 2]>);

impl Observer for Extremes {
    fn row(&mut self, row: &Row) -> io::Result<()> {
        if self.0.is_empty() {
            self.0 = row.outputs.iter().map(|value| [*value; 2]).collect();
        }
        for (extremes, value) in self.0.iter_mut().zip(row.outputs) {
            *extremes = [extremes[0].min(*value), extremes[1].max(*value)];
        }
        Ok(())
    }
}

impl Finished {
    /// A design that did not begin.
    fn unable(status: Result<Status, NoStart>) -> Self {
        Self {
            status,
            steps: 0,
            end_time: 0.0,
            q: Vec::new(),
            qd: Vec::new(),
            extremes: Vec::new(),
            estimated_error: None,
        }
    }
}
