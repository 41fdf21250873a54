//! Steps by an embedded Runge-Kutta pair.

use std::marker::PhantomData;

use qrm_core::Mechanism;

use super::segment::{Segment, Stages};
use super::{Formula, Pair, Task, Work, corrected, end, scales};
use crate::acceleration;
use crate::linear::{Ldl, Vector, along};
use crate::motion::{Breakdown, Moment};

/// A pair with the stages of its last step.
#[derive(Clone, Copy, Debug)]
pub struct Explicit<P, const N: usize> {
    pair: PhantomData<P>,
    stages: Stages<N>,
}

impl<P: Pair, const N: usize, const M: usize> Formula<N, M> for Explicit<P, N> {
    fn new() -> Self {
        Self { pair: PhantomData, stages: Stages::new() }
    }

    fn order(&self) -> i32 {
        P::ORDER
    }

    fn memory(&self) -> f64 {
        P::MEMORY
    }

    fn attempt<X: Mechanism<N, M>>(
        &mut self,
        mechanism: &X,
        from: &Moment<N, M>,
        h: f64,
        task: &Task,
        work: &mut Work,
    ) -> Result<(Moment<N, M>, f64), Breakdown> {
        (self.stages.rates[0], self.stages.accelerations[0]) = (from.qd, from.qdd);
        for stage in 1..P::STAGES {
            self.evaluate(mechanism, from, h, stage, work)?;
        }
        let (rate, acceleration) = self.stages.sum(P::WEIGHTS);
        let (q, qd) = (along(&from.q, h, &rate), along(&from.qd, h, &acceleration));
        // Some estimates heed the end of the step; the others save the work on it.
        let heeds_end = P::ERRORS.iter().any(|row| row.iter().any(|(stage, _)| *stage == P::STAGES));
        let early = (!heeds_end).then(|| self.error::<X, M>(task, from, &q, &qd, h));
        if let Some(error) = early.filter(|error| !(*error <= 1.0)) {
            return Ok((*from, error));
        }
        let mass = Ldl::new(&mechanism.mass_matrix(&q));
        let to = corrected(mechanism, end(from.t, h, task), (q, qd), mass, task.projection, work.care)?;
        *work.evaluations += 1;
        (self.stages.rates[P::STAGES], self.stages.accelerations[P::STAGES]) = (to.qd, to.qdd);
        Ok((to, early.unwrap_or_else(|| self.error::<X, M>(task, from, &to.q, &to.qd, h))))
    }

    fn refine<X: Mechanism<N, M>>(
        &mut self,
        mechanism: &X,
        segment: &mut Segment<N, M>,
        work: &mut Work,
    ) -> Result<(), Breakdown> {
        if !segment.needs_more::<P>() {
            return Ok(());
        }
        let (from, h) = (segment.from, segment.to.t - segment.from.t);
        for stage in P::STAGES + 1..P::STAGE_ROWS.len() {
            self.evaluate(mechanism, &from, h, stage, work)?;
        }
        segment.complete::<P>(&self.stages);
        Ok(())
    }
}

impl<P: Pair, const N: usize> Explicit<P, N> {
    /// The fastest rate of the motion times the step that was made, from how far the last stage and the end of the step lie apart
    /// and how much their derivatives differ (Hairer, Wanner II, IV.2); rates count for what they change in a step.
    pub(super) fn stiffness<const M: usize>(&self, from: &Moment<N, M>, to: &Moment<N, M>) -> f64 {
        let h = to.t - from.t;
        let last = P::STAGES - 1;
        let (rate, acceleration) = self.stages.sum(P::STAGE_ROWS[last]);
        let (mut apart, mut differ) = (0.0, 0.0);
        for i in 0..N {
            let dq = to.q[i] - (from.q[i] + h * rate[i]);
            let dv = h * (to.qd[i] - (from.qd[i] + h * acceleration[i]));
            let da = h * h * (to.qdd[i] - self.stages.accelerations[last][i]);
            apart += dq * dq + dv * dv;
            differ += dv * dv + da * da;
        }
        if apart > 0.0 { (differ / apart).sqrt() } else { 0.0 }
    }

    /// Evaluates a stage.
    #[inline(never)]
    fn evaluate<X: Mechanism<N, M>, const M: usize>(
        &mut self,
        mechanism: &X,
        from: &Moment<N, M>,
        h: f64,
        stage: usize,
        work: &mut Work,
    ) -> Result<(), Breakdown> {
        let (rate, acceleration) = self.stages.sum(P::STAGE_ROWS[stage]);
        let (q, qd) = (along(&from.q, h, &rate), along(&from.qd, h, &acceleration));
        let t = from.t + P::NODES[stage] * h;
        let (qdd, _) = acceleration::evaluate(mechanism, t, &q, &qd, work.care)?;
        (self.stages.rates[stage], self.stages.accelerations[stage]) = (qd, qdd);
        *work.evaluations += 1;
        Ok(())
    }

    /// The estimated error of a step against the tolerance.
    #[inline(always)]
    fn error<X: Mechanism<N, M>, const M: usize>(
        &self,
        task: &Task,
        from: &Moment<N, M>,
        q: &Vector<N>,
        qd: &Vector<N>,
        h: f64,
    ) -> f64 {
        let mut sums = [0.0; 2];
        for (sum, row) in sums.iter_mut().zip(P::ERRORS) {
            let (rate, acceleration) = self.stages.sum(row);
            for i in 0..N {
                let [of_q, of_qd] = scales::<X, N, M>(task.tolerance, i, from, q, qd);
                *sum += (rate[i] / of_q).powi(2) + (acceleration[i] / of_qd).powi(2);
            }
        }
        P::error(sums, h, 2.0 * N as f64)
    }
}
