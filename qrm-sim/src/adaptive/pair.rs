//! What tells one embedded Runge-Kutta pair from another.

/// Places of stages and their coefficients, zeros left out.
pub type Row = &'static [(usize, f64)];

/// Most stages of any pair, those of the dense output included.
pub const MOST_STAGES: usize = 16;

/// An embedded pair: a step, and an estimate of its error.
pub trait Pair: Copy {
    /// How many stages a step takes; the accelerations at its end are the stage after them.
    const STAGES: usize;
    /// Order of the step.
    const ORDER: i32;
    /// How much the step length heeds the error before the last one.
    const MEMORY: f64;
    /// At which fraction of the step each stage is evaluated.
    const NODES: &'static [f64];
    /// How the argument of each stage is made of those before it.
    const STAGE_ROWS: &'static [Row];
    /// How the end of the step is made of the stages.
    const WEIGHTS: Row;
    /// Estimates of the error, one or two.
    const ERRORS: &'static [Row];
    /// The higher coefficients of the dense output; none where a polynomial of degree 5 through both ends does.
    const DENSE: &'static [Row];

    /// The error from the sums of squares of the scaled estimates of `count` numbers; 1 is just good enough.
    fn error(sums: [f64; 2], h: f64, count: f64) -> f64;
}
