//! The places of the numbers of a batch, and its options.

use crate::description::Description;

/// The options of a batch, which all its lanes share.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BatchRequest {
    /// Whether the scene's event ends a motion.
    pub watches_event: bool,
    /// Whether each step is looked at from outside: the caller has a stop condition of its own.
    pub waits_each_step: bool,
    /// Whether the ranges of outputs are wanted.
    pub ranges: bool,
    /// Whether the state is kept after each number of steps that is a power of two.
    pub checkpoints: bool,
}

/// The places of the numbers of a batch; at each place stands one number of every lane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BatchLayout {
    /// Number of coordinates.
    pub(crate) n: usize,
    /// Number of constraints.
    pub(crate) m: usize,
    /// Number of parameters.
    pub(crate) parameter_count: usize,
    /// Number of outputs whose ranges are wanted.
    pub(crate) output_count: usize,
}

/// The steps that were made.
pub(crate) const MADE: usize = 0;
/// A lane's [`LaneSchedule`].
pub(crate) const STEP: usize = 1;
pub(crate) const END_TIME: usize = 2;
pub(crate) const TOLERANCE: usize = 3;
pub(crate) const LONGEST: usize = 4;
pub(crate) const MOST_STEPS: usize = 5;
/// The value of the scene's event after the step that is waited for.
pub(crate) const EVENT: usize = 6;
/// Growth factor, residual and check for finite numbers of that step.
pub(crate) const QUALITY: usize = 7;
/// Zero, or not a number once an output was not finite.
pub(crate) const DEFINED: usize = 10;
/// The number of the step after which the state is kept next.
pub(crate) const CHECKPOINT_STEP: usize = 11;
/// The smallest, then the largest value of each coordinate.
pub(crate) const COORDINATE_RANGES: usize = 12;

/// The number of checkpoints that a lane keeps.
pub const CHECKPOINTS: usize = 2;

/// A lane waits when the steps that it chooses become shorter than this part of its end time.
pub(crate) const SHORTEST: f64 = 1e-12;

/// Outputs are computed at the end of each of so many equal parts of a step.
pub(crate) const PARTS: usize = 4;

impl BatchLayout {
    /// The layout for this mechanism.
    #[inline(always)]
    pub(crate) const fn new(mechanism: &Description, request: &BatchRequest) -> Self {
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

    /// The row of the motion.
    #[inline(always)]
    pub(crate) const fn row(self) -> usize {
        COORDINATE_RANGES + 2 * self.n
    }

    /// The row of the motion at its last checkpoint (0), or at the one before (1).
    #[inline(always)]
    pub(crate) const fn checkpoint(self, age: usize) -> usize {
        self.row() + (1 + age) * self.width()
    }

    /// The row before the step that is waited for.
    #[inline(always)]
    pub(crate) const fn row_before(self) -> usize {
        self.row() + (1 + CHECKPOINTS) * self.width()
    }

    /// The outputs of the last row.
    #[inline(always)]
    pub(crate) const fn outputs(self) -> usize {
        self.row() + (2 + CHECKPOINTS) * self.width()
    }

    /// The smallest values of the outputs.
    #[inline(always)]
    pub(crate) const fn lowest(self) -> usize {
        self.outputs() + self.output_count
    }

    /// The largest values of the outputs.
    #[inline(always)]
    pub(crate) const fn highest(self) -> usize {
        self.lowest() + self.output_count
    }

    /// The smallest values of the outputs in the last step.
    #[inline(always)]
    pub(crate) const fn step_lowest(self) -> usize {
        self.highest() + self.output_count
    }

    /// The largest values of the outputs in that step.
    #[inline(always)]
    pub(crate) const fn step_highest(self) -> usize {
        self.step_lowest() + self.output_count
    }

    /// The outputs at the end of a part of that step; `part` counts from 1.
    #[inline(always)]
    pub(crate) const fn sample(self, part: usize) -> usize {
        self.step_highest() + part * self.output_count
    }

    /// The parameters.
    #[inline(always)]
    pub(crate) const fn parameters(self) -> usize {
        self.sample(1 + PARTS)
    }

    /// The number of places.
    #[inline(always)]
    pub(crate) const fn places(self) -> usize {
        self.parameters() + self.parameter_count
    }
}
