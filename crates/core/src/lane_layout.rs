//! The places of the numbers of a batch, its options, and the constants of its steps.

use crate::description::Description;
use crate::kernel::MAX_GROWTH;

/// The growth of rounding errors from which a position may be so near a singular one that forces lose digits.
pub(crate) const NEAR_GROWTH: f64 = 10.0;

/// The options of a batch, which all its lanes share.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BatchRequest {
    /// Whether the scene's event ends a motion.
    pub watches_event: bool,
    /// Whether the caller inspects each step, for a stop condition of its own.
    pub waits_each_step: bool,
    /// Whether the ranges of outputs are recorded.
    pub ranges: bool,
    /// Whether the caller inspects each step near a singular position, where forces lose digits.
    pub forces: bool,
    /// Whether the state is kept whenever the number of steps is a power of two.
    pub checkpoints: bool,
}

impl BatchRequest {
    /// The growth of rounding errors from which the caller inspects a step.
    pub fn most_growth(&self) -> f64 {
        if self.forces { NEAR_GROWTH } else { MAX_GROWTH }
    }
}

/// The places of the numbers of a lane. The vectors of a core are stored place by place, the numbers of a GPU lane by
/// lane.
#[derive(Clone, Copy, Debug)]
pub struct BatchLayout {
    /// Number of coordinates.
    pub n: usize,
    /// Number of constraints.
    pub m: usize,
    /// Number of parameters.
    pub parameter_count: usize,
    /// Number of outputs whose ranges are recorded.
    pub output_count: usize,
}

/// The place of the number of steps made.
pub(crate) const STEPS_MADE: usize = 0;
/// The first place of a lane's [`LaneSchedule`].
pub(crate) const STEP: usize = 1;
pub(crate) const END_TIME: usize = 2;
pub(crate) const TOLERANCE: usize = 3;
pub(crate) const LONGEST: usize = 4;
pub(crate) const MAX_STEPS: usize = 5;
/// The place of the scene's event value after the last step.
pub(crate) const EVENT: usize = 6;
/// The first place of growth factor, residual and finiteness check of the last step.
pub(crate) const QUALITY: usize = 7;
/// The place of a number that is zero until an output is not finite, and not a number from then on.
pub(crate) const DEFINED: usize = 10;
/// The place of the number of steps at which the next checkpoint is taken.
pub(crate) const CHECKPOINT_STEP: usize = 11;
/// The first place of the coordinates' ranges: all smallest values, then all largest ones.
pub(crate) const COORDINATE_RANGES: usize = 12;

/// The number of checkpoints that a lane keeps.
pub const CHECKPOINTS: usize = 2;

/// A lane waits when its steps become shorter than this fraction of its end time.
pub(crate) const SHORTEST: f64 = 1e-12;

/// The number of equal parts of a step; outputs are computed at the end of each.
pub(crate) const PARTS: usize = 4;

/// Steps with an error above this multiple of the tolerance are repeated. A lower limit costs more than it gains.
pub(crate) const REJECTED: f64 = 4.0;
/// The length of a step, relative to the length at which its error would equal the tolerance.
pub(crate) const SAFETY: f64 = 0.8;
/// The smallest and the largest ratio of a step's length to the previous one.
pub(crate) const CHANGES: [f64; 2] = [0.3, 3.0];
/// The largest ratio of fourth to second differences of a smooth output.
pub(crate) const SMOOTH: f64 = 0.5;
/// Twice the largest error of the polynomial through five values between them, as a part of the fifth difference.
pub(crate) const FIFTH: f64 = 0.06;

impl BatchLayout {
    /// The layout for this mechanism.
    #[inline(always)]
    pub const fn new(mechanism: &Description, request: &BatchRequest) -> Self {
        Self {
            n: mechanism.coordinates.len(),
            m: mechanism.constraints.len(),
            parameter_count: mechanism.parameters.len(),
            output_count: if request.ranges { mechanism.outputs.len() } else { 0 },
        }
    }

    /// The length of a row `[t, q, qd, qdd, multipliers]`.
    #[inline(always)]
    pub(crate) const fn width(self) -> usize {
        1 + 3 * self.n + self.m
    }

    /// The first place of the current row.
    #[inline(always)]
    pub(crate) const fn row(self) -> usize {
        COORDINATE_RANGES + 2 * self.n
    }

    /// The first place of the row at the last checkpoint (0), or at the one before (1).
    #[inline(always)]
    pub(crate) const fn checkpoint(self, age: usize) -> usize {
        self.row() + (1 + age) * self.width()
    }

    /// The first place of the row before the last step.
    #[inline(always)]
    pub(crate) const fn row_before(self) -> usize {
        self.row() + (1 + CHECKPOINTS) * self.width()
    }

    /// The first place of the outputs of the last row.
    #[inline(always)]
    pub(crate) const fn outputs(self) -> usize {
        self.row() + (2 + CHECKPOINTS) * self.width()
    }

    /// The first place of the smallest values of the outputs.
    #[inline(always)]
    pub(crate) const fn lowest(self) -> usize {
        self.outputs() + self.output_count
    }

    /// The first place of the largest values of the outputs.
    #[inline(always)]
    pub(crate) const fn highest(self) -> usize {
        self.lowest() + self.output_count
    }

    /// The first place of the smallest values of the outputs in the last step.
    #[inline(always)]
    pub(crate) const fn step_lowest(self) -> usize {
        self.highest() + self.output_count
    }

    /// The first place of the largest values of the outputs in the last step.
    #[inline(always)]
    pub(crate) const fn step_highest(self) -> usize {
        self.step_lowest() + self.output_count
    }

    /// The first place of the smallest values that the outputs may have had.
    #[inline(always)]
    pub(crate) const fn least(self) -> usize {
        self.step_highest() + self.output_count
    }

    /// The first place of the largest values that the outputs may have had.
    #[inline(always)]
    pub(crate) const fn most(self) -> usize {
        self.least() + self.output_count
    }

    /// The first place of the smallest values that the outputs may have had in the last step.
    #[inline(always)]
    pub(crate) const fn step_least(self) -> usize {
        self.most() + self.output_count
    }

    /// The first place of the largest values that the outputs may have had in the last step.
    #[inline(always)]
    pub(crate) const fn step_most(self) -> usize {
        self.step_least() + self.output_count
    }

    /// The first place of the outputs at the end of a part of the last step; `part` counts from 1.
    #[inline(always)]
    pub(crate) const fn sample(self, part: usize) -> usize {
        self.step_most() + part * self.output_count
    }

    /// The first place of the parameters.
    #[inline(always)]
    pub(crate) const fn parameters(self) -> usize {
        self.sample(1 + PARTS)
    }

    /// The number of places.
    #[inline(always)]
    pub const fn places(self) -> usize {
        self.parameters() + self.parameter_count
    }

    /// The places under the names that steps in other languages use.
    pub fn named_places(self) -> [(&'static str, usize); 29] {
        [
            ("STEPS_MADE", STEPS_MADE),
            ("STEP", STEP),
            ("END_TIME", END_TIME),
            ("TOLERANCE", TOLERANCE),
            ("LONGEST", LONGEST),
            ("MAX_STEPS", MAX_STEPS),
            ("EVENT", EVENT),
            ("QUALITY", QUALITY),
            ("DEFINED", DEFINED),
            ("CHECKPOINT_STEP", CHECKPOINT_STEP),
            ("COORDINATE_RANGES", COORDINATE_RANGES),
            ("ROW", self.row()),
            ("CHECKPOINT", self.checkpoint(0)),
            ("CHECKPOINT_BEFORE", self.checkpoint(1)),
            ("ROW_BEFORE", self.row_before()),
            ("AT_ROW", self.outputs()),
            ("LOWEST", self.lowest()),
            ("HIGHEST", self.highest()),
            ("STEP_LOWEST", self.step_lowest()),
            ("STEP_HIGHEST", self.step_highest()),
            ("LOWER_BOUND", self.least()),
            ("UPPER_BOUND", self.most()),
            ("STEP_LOWER_BOUND", self.step_least()),
            ("STEP_UPPER_BOUND", self.step_most()),
            ("SAMPLE", self.sample(0)),
            ("PARAMETERS", self.parameters()),
            ("PLACES", self.places()),
            ("OUTPUTS", self.output_count),
            ("PARTS", PARTS),
        ]
    }
}

/// The constants of steps under the names that steps in other languages use.
pub fn named_constants() -> [(&'static str, f64); 7] {
    [
        ("SHORTEST", SHORTEST),
        ("REJECTED", REJECTED),
        ("SAFETY", SAFETY),
        ("LEAST_CHANGE", CHANGES[0]),
        ("MOST_CHANGE", CHANGES[1]),
        ("SMOOTH", SMOOTH),
        ("FIFTH", FIFTH),
    ]
}
