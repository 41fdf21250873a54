//! From one row to the next, by whichever method.

use qrm_core::Mechanism;

use crate::adaptive::{Adaptive, Auto, Counts, Dop853, Dopri5, Explicit, Implicit};
use crate::document;
use crate::motion::{Breakdown, Method, Moment, Scheme, advance};
use crate::solve::Care;

/// What a method keeps between rows.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Stepper<const N: usize, const M: usize> {
    /// Nothing: each row is a step.
    Fixed,
    /// Nothing: each row is a step as the document makes it.
    Document,
    /// A pair of order 5.
    Five(Adaptive<Explicit<Dopri5, N>, N, M>),
    /// A pair of order 8.
    Eight(Adaptive<Explicit<Dop853, N>, N, M>),
    /// A linearly implicit method.
    Implicit(Adaptive<Implicit, N, M>),
    /// Whichever of the last two suits.
    Auto(Adaptive<Auto<N>, N, M>),
}

impl<const N: usize, const M: usize> Stepper<N, M> {
    pub(crate) fn new<X: Mechanism<N, M>>(
        mechanism: &X,
        scheme: Scheme,
        first: Moment<N, M>,
        end_time: f64,
        care: &mut Care,
    ) -> Result<Self, Breakdown> {
        Ok(match scheme {
            Scheme::Rk4 => Self::Fixed,
            Scheme::Document => Self::Document,
            Scheme::Dopri5 { tolerance } => Self::Five(Adaptive::new(mechanism, first, end_time, tolerance, care)?),
            Scheme::Dop853 { tolerance } => Self::Eight(Adaptive::new(mechanism, first, end_time, tolerance, care)?),
            Scheme::Rodas { .. } if !X::HAS_LINEARIZATION => return Err(Breakdown::NoLinearization),
            Scheme::Auto { tolerance } => Self::Auto(Adaptive::new(mechanism, first, end_time, tolerance, care)?),
            Scheme::Rodas { tolerance } => Self::Implicit(Adaptive::new(mechanism, first, end_time, tolerance, care)?),
        })
    }

    /// Whether each row is a step.
    pub(crate) fn is_fixed(&self) -> bool {
        matches!(self, Self::Fixed | Self::Document)
    }

    /// The row at `t`, after the row `from`.
    #[inline(never)]
    pub(crate) fn next<X: Mechanism<N, M>>(
        &mut self,
        mechanism: &X,
        method: &Method,
        from: &Moment<N, M>,
        t: f64,
        care: &mut Care,
    ) -> Result<Moment<N, M>, Breakdown> {
        let projection = (method.projection, method.tolerance);
        match self {
            Self::Fixed => advance(mechanism, method, from, t, care),
            Self::Document => document::advance(mechanism, from, t, care),
            Self::Five(adaptive) => adaptive.moment_at(mechanism, t, projection, care),
            Self::Eight(adaptive) => adaptive.moment_at(mechanism, t, projection, care),
            Self::Implicit(adaptive) => adaptive.moment_at(mechanism, t, projection, care),
            Self::Auto(adaptive) => adaptive.moment_at(mechanism, t, projection, care),
        }
    }

    /// A moment between the row `from` and the last one.
    pub(crate) fn between<X: Mechanism<N, M>>(
        &self,
        mechanism: &X,
        method: &Method,
        from: &Moment<N, M>,
        t: f64,
        care: &mut Care,
    ) -> Result<Moment<N, M>, Breakdown> {
        let mut again = match self {
            Self::Fixed => Self::Fixed,
            Self::Document => Self::Document,
            Self::Five(adaptive) => Self::Five(adaptive.from(*from)),
            Self::Eight(adaptive) => Self::Eight(adaptive.from(*from)),
            Self::Implicit(adaptive) => Self::Implicit(adaptive.from(*from)),
            Self::Auto(adaptive) => Self::Auto(adaptive.from(*from)),
        };
        again.next(mechanism, method, from, t, care)
    }

    /// Largest difference between energy and work at the end of any step; `None` if rows are the steps.
    pub(crate) fn imbalance(&self) -> Option<f64> {
        match self {
            Self::Fixed | Self::Document => None,
            Self::Five(adaptive) => Some(adaptive.imbalance),
            Self::Eight(adaptive) => Some(adaptive.imbalance),
            Self::Implicit(adaptive) => Some(adaptive.imbalance),
            Self::Auto(adaptive) => Some(adaptive.imbalance),
        }
    }

    /// What was done in a run of so many rows.
    pub(crate) fn counts(&self, rows: u64) -> Counts {
        match self {
            Self::Fixed | Self::Document => Counts { accepted: rows, evaluations: 4 * rows, ..Counts::default() },
            Self::Five(adaptive) => adaptive.counts,
            Self::Eight(adaptive) => adaptive.counts,
            Self::Implicit(adaptive) => adaptive.counts,
            Self::Auto(adaptive) => adaptive.counts,
        }
    }
}
