//! Explicit steps where they do, implicit ones where the motion is stiff.

use qrm_core::Mechanism;

use super::segment::Segment;
use super::{Dop853, Explicit, Formula, Implicit, Kept, Task, Work};
use crate::linear::{Vector, dot};
use crate::motion::{Breakdown, Moment};
use crate::response::Response;

/// Steps of the explicit pair with a larger product of fastest rate and length are bound by stability.
const BOUND: f64 = 5.0;
/// Steps in a row after which that is believed.
const BELIEVED: u32 = 15;
/// An implicit step of which the product is smaller could as well have been an explicit one.
const EASY: f64 = 2.0;

/// Both methods, and what speaks for a change.
#[derive(Clone, Copy, Debug)]
pub struct Auto<const N: usize> {
    explicit: Explicit<Dop853, N>,
    is_implicit: bool,
    /// Whether the last step that was kept was implicit.
    was_implicit: bool,
    /// How many steps in a row spoke for the other method.
    doubts: u32,
    /// Steps in a row that did not, since.
    quiet: u32,
    /// The direction in which the equations of motion react most, coordinates and rates.
    fastest: (Vector<N>, Vector<N>),
}

impl<const N: usize, const M: usize> Formula<N, M> for Auto<N> {
    fn new() -> Self {
        // Any direction will do that is not by chance at right angles to the fastest one.
        let start = std::array::from_fn(|i| 1.0 / (1.0 + i as f64));
        Self {
            explicit: <Explicit<Dop853, N> as Formula<N, M>>::new(),
            is_implicit: false,
            was_implicit: false,
            doubts: 0,
            quiet: 0,
            fastest: (start, start),
        }
    }

    fn order(&self) -> i32 {
        if self.is_implicit { Formula::<N, M>::order(&Implicit) } else { Formula::<N, M>::order(&self.explicit) }
    }

    fn memory(&self) -> f64 {
        0.0
    }

    fn attempt<X: Mechanism<N, M>>(
        &mut self,
        mechanism: &X,
        from: &Moment<N, M>,
        h: f64,
        task: &Task,
        work: &mut Work,
    ) -> Result<(Moment<N, M>, f64), Breakdown> {
        if self.is_implicit {
            Implicit.attempt(mechanism, from, h, task, work)
        } else {
            self.explicit.attempt(mechanism, from, h, task, work)
        }
    }

    fn accepted<X: Mechanism<N, M>>(&mut self, mechanism: &X, from: &Moment<N, M>, to: &Moment<N, M>) -> Kept {
        let is_implicit = self.is_implicit;
        self.was_implicit = is_implicit;
        let speaks_for_a_change = if is_implicit {
            self.rate(mechanism, to) * (to.t - from.t) < EASY
        } else {
            self.explicit.stiffness(from, to) > BOUND
        };
        if speaks_for_a_change {
            (self.doubts, self.quiet) = (self.doubts + 1, 0);
        } else {
            self.quiet += 1;
            if self.quiet == 6 {
                self.doubts = 0;
            }
        }
        let is_bound = !X::HAS_LINEARIZATION && self.doubts >= BELIEVED;
        if self.doubts >= BELIEVED && X::HAS_LINEARIZATION {
            (self.is_implicit, self.doubts, self.quiet) = (!is_implicit, 0, 0);
        }
        Kept { is_implicit, is_bound }
    }

    fn refine<X: Mechanism<N, M>>(
        &mut self,
        mechanism: &X,
        segment: &mut Segment<N, M>,
        work: &mut Work,
    ) -> Result<(), Breakdown> {
        if self.was_implicit { Ok(()) } else { self.explicit.refine(mechanism, segment, work) }
    }
}

impl<const N: usize> Auto<N> {
    /// The fastest rate of the linearized equations by two more steps of the power method.
    fn rate<X: Mechanism<N, M>, const M: usize>(&mut self, mechanism: &X, at: &Moment<N, M>) -> f64 {
        let Some(response) = Response::generated(mechanism, at) else { return f64::INFINITY };
        // Every second step magnifies by the square of a frequency, the others by less than one.
        let mut growth = 1.0;
        for _ in 0..2 {
            let (u, w) = self.fastest;
            let Some(change) = response.accelerations(&u, &w) else { return f64::INFINITY };
            let size = (dot(&w, &w) + dot(&change, &change)).sqrt();
            if !(size > 0.0) {
                return 0.0;
            }
            growth *= size / (dot(&u, &u) + dot(&w, &w)).sqrt();
            self.fastest = (w.map(|x| x / size), change.map(|x| x / size));
        }
        growth.sqrt()
    }
}
