//! Formulae that choose their steps, each step followed by a projection, with rows at any time.

mod auto;
mod dop853;
mod dopri5;
mod explicit;
mod implicit;
mod pair;
mod rodas;
mod segment;

use qrm_core::Mechanism;

use crate::acceleration::evaluate;
use crate::kinematics::is_angle;
use crate::linear::{Ldl, Vector, along};
use crate::motion::{Breakdown, Moment, moment};
use crate::projection::{Projection, Tolerance, project};
use crate::solve::Care;
pub use auto::Auto;
pub use dop853::Dop853;
pub use dopri5::Dopri5;
pub use explicit::Explicit;
pub use implicit::Implicit;
pub use pair::{MOST_STAGES, Pair, Row};
pub use segment::Segment;

/// How one step is made.
pub trait Formula<const N: usize, const M: usize>: Copy {
    /// Before the first step.
    fn new() -> Self;

    /// Order of the step.
    fn order(&self) -> i32;

    /// How much the step length heeds the error before the last one.
    fn memory(&self) -> f64;

    /// A step of length `h`, corrected, and its error; 1 is just good enough.
    ///
    /// # Errors
    /// The step could not be made.
    fn attempt<X: Mechanism<N, M>>(
        &mut self,
        mechanism: &X,
        from: &Moment<N, M>,
        h: f64,
        task: &Task,
        work: &mut Work,
    ) -> Result<(Moment<N, M>, f64), Breakdown>;

    /// Takes note of a step that was kept.
    fn accepted<X: Mechanism<N, M>>(&mut self, _mechanism: &X, _from: &Moment<N, M>, _to: &Moment<N, M>) -> Kept {
        Kept::default()
    }

    /// What the motion inside the last step needs beside its ends.
    ///
    /// # Errors
    /// It could not be computed.
    fn refine<X: Mechanism<N, M>>(
        &mut self,
        _mechanism: &X,
        _segment: &mut Segment<N, M>,
        _work: &mut Work,
    ) -> Result<(), Breakdown> {
        Ok(())
    }
}

/// What every step is asked to do.
#[derive(Clone, Copy, Debug)]
pub struct Task {
    /// Largest error of a step, in the unit of each coordinate and rate.
    pub tolerance: f64,
    /// Steps that come so far end there exactly.
    pub end_time: f64,
    /// How states are put back onto the constraints.
    pub projection: (Projection, Tolerance),
}

/// What was done, and with how much care.
pub struct Work<'a> {
    /// Evaluations of the accelerations.
    pub evaluations: &'a mut u64,
    /// How often the fast way did not do.
    pub care: &'a mut Care,
}

/// What is worth knowing of a step that was kept.
#[derive(Clone, Copy, Debug, Default)]
pub struct Kept {
    /// Whether it was made by an implicit method.
    pub is_implicit: bool,
    /// Whether it was as long as stability allows.
    pub is_bound: bool,
}

/// A motion under way with steps of its own choice.
#[derive(Clone, Copy, Debug)]
pub struct Adaptive<F, const N: usize, const M: usize> {
    formula: F,
    /// Largest error of a step, in the unit of each coordinate and rate.
    tolerance: f64,
    end_time: f64,
    /// The last step.
    segment: Segment<N, M>,
    /// Length of the next step.
    h: f64,
    last_error: f64,
    /// Whether the last attempt failed.
    failed: bool,
    /// What was done.
    pub counts: Counts,
    /// Rows that were asked for.
    rows: u64,
    /// Energy at the start, and work of the loads without potential since.
    energy: f64,
    work: f64,
    /// Largest difference between the change of the energy and that work at the end of any step.
    pub imbalance: f64,
}

/// What a run with steps of its own choice has done.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Steps that were kept.
    pub accepted: u64,
    /// Steps that were not good enough.
    pub rejected: u64,
    /// Evaluations of the accelerations.
    pub evaluations: u64,
    /// Steps by an implicit method.
    pub implicit: u64,
    /// Explicit steps that were as long as stability allows, though accuracy would have allowed more.
    pub bound: u64,
}

/// Places between -1 and 1, and their weights (Gauss, order 6).
const GAUSS: [(f64, f64); 3] =
    [(-0.774_596_669_241_483_4, 5.0 / 9.0), (0.0, 8.0 / 9.0), (0.774_596_669_241_483_4, 5.0 / 9.0)];

/// The step is aimed at this part of the tolerance.
const SAFETY: f64 = 0.8;
/// Steps beyond these many, and these many more for each row, are taken for a motion that cannot be followed.
const PATIENCE: u64 = 1_000_000;
const PATIENCE_PER_ROW: u64 = 1000;
/// After so many steps their progress is looked at; less than this part of the way to the next row is none.
const CHECKED: u64 = 5000;
const CRAWL: f64 = 1e-3;
/// By what a step may shrink and grow at once.
const SHRINK: f64 = 0.2;
const GROW: f64 = 6.0;

impl<F: Formula<N, M>, const N: usize, const M: usize> Adaptive<F, N, M> {
    /// Begins at a moment; the first step is guessed from how fast the motion changes.
    ///
    /// # Errors
    /// The accelerations near the start are not determined.
    pub fn new<X: Mechanism<N, M>>(
        mechanism: &X,
        first: Moment<N, M>,
        end_time: f64,
        tolerance: f64,
        care: &mut Care,
    ) -> Result<Self, Breakdown> {
        let mut adaptive = Self {
            formula: F::new(),
            tolerance,
            end_time,
            segment: Segment::new(first, first),
            h: 0.0,
            last_error: 1e-4,
            failed: false,
            counts: Counts::default(),
            rows: 0,
            energy: mechanism.energy(&first.q, &first.qd).iter().sum(),
            work: 0.0,
            imbalance: 0.0,
        };
        adaptive.h = adaptive.first_step(mechanism, &first, care)?;
        Ok(adaptive)
    }

    /// The same motion for another look at what comes after a moment in its last step, or before.
    #[must_use]
    pub fn from(&self, moment: Moment<N, M>) -> Self {
        let mut again = *self;
        if moment.t < self.segment.from.t {
            again.segment = Segment::new(moment, moment);
        }
        again
    }

    /// The corrected moment at a time not before the last one that was asked for.
    ///
    /// # Errors
    /// The motion does not get there.
    #[inline(never)]
    pub fn moment_at<X: Mechanism<N, M>>(
        &mut self,
        mechanism: &X,
        t: f64,
        projection: (Projection, Tolerance),
        care: &mut Care,
    ) -> Result<Moment<N, M>, Breakdown> {
        self.rows += 1;
        let (mut checked, mut then) = (self.attempts(), self.segment.to.t);
        while self.segment.to.t < t {
            let (attempts, now) = (self.attempts(), self.segment.to.t);
            if attempts > checked + CHECKED {
                let is_stuck = now - then < CRAWL * (t - then);
                if is_stuck || attempts > PATIENCE + PATIENCE_PER_ROW * self.rows {
                    return Err(Breakdown::TooManySteps { attempts, h: self.h });
                }
                (checked, then) = (attempts, now);
            }
            self.step(mechanism, projection, care)?;
        }
        if self.segment.to.t == t {
            return Ok(self.segment.to);
        }
        let mut work = Work { evaluations: &mut self.counts.evaluations, care };
        self.formula.refine(mechanism, &mut self.segment, &mut work)?;
        let (q, qd) = self.segment.at(t);
        let mass = Ldl::new(&mechanism.mass_matrix(&q));
        *work.evaluations += 1;
        corrected(mechanism, t, (q, qd), mass, projection, work.care)
    }

    /// How many steps were tried.
    fn attempts(&self) -> u64 {
        self.counts.accepted + self.counts.rejected
    }

    /// Makes one step that is good enough.
    fn step<X: Mechanism<N, M>>(
        &mut self,
        mechanism: &X,
        projection: (Projection, Tolerance),
        care: &mut Care,
    ) -> Result<(), Breakdown> {
        let from = self.segment.to;
        let left = self.end_time - from.t;
        loop {
            // Two even steps to the end are better than a long and a very short one.
            let h = if self.h >= left {
                left
            } else if self.h > 0.5 * left {
                0.5 * left
            } else {
                self.h
            };
            if !(h > 4.0 * f64::EPSILON * from.t.abs()) {
                return Err(Breakdown::StepTooShort { h });
            }
            let task = Task { tolerance: self.tolerance, end_time: self.end_time, projection };
            let mut work = Work { evaluations: &mut self.counts.evaluations, care };
            let attempt = self.formula.attempt(mechanism, &from, h, &task, &mut work);
            let (to, error) = match attempt {
                Ok((to, error)) if error <= 1.0 => (to, error),
                Ok((_, error)) => {
                    let factor = if error.is_finite() {
                        SAFETY * error.powf(-1.0 / f64::from(self.formula.order()))
                    } else {
                        SHRINK
                    };
                    self.reject(h * factor.clamp(SHRINK, 0.9));
                    continue;
                }
                // A formula may leave its domain, or a projection its branch, where the step is too long.
                Err(reason) if h < 1e-10 * (1.0 + from.t.abs()) => return Err(reason),
                Err(_) => {
                    self.reject(h * SHRINK);
                    continue;
                }
            };
            let (order, memory) = (f64::from(self.formula.order()), self.formula.memory());
            let error = error.max(1e-10);
            let factor = SAFETY * error.powf(0.75 * memory - 1.0 / order) * self.last_error.powf(memory);
            let most = if self.failed { 1.0 } else { GROW };
            self.h = h * factor.clamp(SHRINK, most);
            self.last_error = error.max(1e-4);
            self.failed = false;
            let kept = self.formula.accepted(mechanism, &from, &to);
            self.counts.accepted += 1;
            self.counts.implicit += u64::from(kept.is_implicit);
            self.counts.bound += u64::from(kept.is_bound);
            self.segment = Segment::new(from, to);
            self.balance(mechanism);
            return Ok(());
        }
    }

    /// Sets the energy at the end of the last step against the work of its loads, whose power is integrated inside the step.
    fn balance<X: Mechanism<N, M>>(&mut self, mechanism: &X) {
        let Segment { from, to, .. } = &self.segment;
        if [from, to].iter().any(|at| mechanism.power(at.t, &at.q, &at.qd, &at.multipliers) != 0.0) {
            let half = 0.5 * (to.t - from.t);
            for (place, weight) in GAUSS {
                let t = from.t + half * (1.0 + place);
                let (q, qd) = self.segment.at(t);
                // The multipliers matter where closures do work.
                let multipliers = if X::IS_DRIVEN {
                    evaluate(mechanism, t, &q, &qd, &mut Care::default()).map_or([f64::NAN; M], |(_, lambda)| lambda)
                } else {
                    [0.0; M]
                };
                self.work += half * weight * mechanism.power(t, &q, &qd, &multipliers);
            }
        }
        let energy: f64 = mechanism.energy(&to.q, &to.qd).iter().sum();
        self.imbalance = self.imbalance.max((energy - self.energy - self.work).abs());
    }

    fn reject(&mut self, h: f64) {
        self.h = h;
        self.failed = true;
        self.counts.rejected += 1;
    }

    /// A first step from the sizes of state, rates and their change (Hairer, Norsett, Wanner I, II.4).
    fn first_step<X: Mechanism<N, M>>(
        &mut self,
        mechanism: &X,
        first: &Moment<N, M>,
        care: &mut Care,
    ) -> Result<f64, Breakdown> {
        let scales: [[f64; 2]; N] =
            std::array::from_fn(|i| scales::<X, N, M>(self.tolerance, i, first, &first.q, &first.qd));
        let norm = |of_q: &Vector<N>, of_qd: &Vector<N>| {
            let squares =
                scales.iter().zip(of_q.iter().zip(of_qd)).map(|([q, qd], (x, v))| (x / q).powi(2) + (v / qd).powi(2));
            (squares.sum::<f64>() / (2.0 * N as f64)).sqrt()
        };
        let (size, speed) = (norm(&first.q, &first.qd), norm(&first.qd, &first.qdd));
        let guess = if size < 1e-5 || speed < 1e-5 { 1e-6 } else { 0.01 * size / speed };
        let guess = guess.min(self.end_time - first.t);
        let (q, qd) = (along(&first.q, guess, &first.qd), along(&first.qd, guess, &first.qdd));
        let untouched = (Projection::None, Tolerance::default());
        let later = corrected(mechanism, first.t + guess, (q, qd), None, untouched, care)?;
        self.counts.evaluations += 1;
        let change = |a: &Vector<N>, b: &Vector<N>| -> Vector<N> { std::array::from_fn(|i| (a[i] - b[i]) / guess) };
        let bend = norm(&change(&later.qd, &first.qd), &change(&later.qdd, &first.qdd));
        let largest = speed.max(bend);
        let second = if largest <= 1e-15 {
            (guess * 1e-3).max(1e-6)
        } else {
            (0.01 / largest).powf(1.0 / f64::from(self.formula.order()))
        };
        Ok((100.0 * guess).min(second).min(self.end_time))
    }
}

/// A state put back onto the constraints, with what belongs to it. It is called once a step, and large: every copy of it would
/// be compiled anew after a change of a scene.
#[inline(never)]
fn corrected<X: Mechanism<N, M>, const N: usize, const M: usize>(
    mechanism: &X,
    t: f64,
    (mut q, mut qd): (Vector<N>, Vector<N>),
    mass: Option<Ldl<N>>,
    projection: (Projection, Tolerance),
    care: &mut Care,
) -> Result<Moment<N, M>, Breakdown> {
    let corrections = project(mechanism, projection, mass.as_ref(), t, &mut q, &mut qd, care)?;
    Ok(Moment { corrections, ..moment(mechanism, t, q, qd, care)? })
}

/// How large an error of a coordinate and of its rate may be. An angle is no less accurate for having turned often.
#[inline(always)]
fn scales<X: Mechanism<N, M>, const N: usize, const M: usize>(
    tolerance: f64,
    i: usize,
    from: &Moment<N, M>,
    q: &Vector<N>,
    qd: &Vector<N>,
) -> [f64; 2] {
    let size = if is_angle::<X, N, M>(i) { 0.0 } else { from.q[i].abs().max(q[i].abs()) };
    [tolerance * (1.0 + size), tolerance * (1.0 + from.qd[i].abs().max(qd[i].abs()))]
}

/// When a step that begins at `t` ends.
fn end(t: f64, h: f64, task: &Task) -> f64 {
    if t + h >= task.end_time { task.end_time } else { t + h }
}
