//! A motion under way, at its user's pace: for programs that ask for the state at times of their own.

use qrm_core::Mechanism;

use crate::assembly::assemble;
use crate::linear::{Matrix, Vector};
use crate::motion::{Breakdown, Method, Moment, moment};
use crate::outcome::NoStart;
use crate::projection::{Projection, project};
use crate::solve::Care;
use crate::stepper::Stepper;
use crate::trouble::{Reason, Trouble};
use crate::walk::{Walker, is_walked, parameters, walk};

/// A motion under way. Between the times that are asked for it makes the steps of [`simulate`](crate::simulate::simulate), whatever
/// these times are.
///
/// ```
/// # use qrm_core::Mechanism;
/// # use qrm_sim::{motion::Method, simulation::Simulation};
/// # fn swing<X: Mechanism<N, M> + Clone, const N: usize, const M: usize>(mechanism: X) -> Result<(), String> {
/// let mut simulation = Simulation::new(mechanism, Method::default(), None).map_err(|e| e.to_string())?;
/// for i in 1..=100 {
///     let at = simulation.advance(0.01 * f64::from(i)).map_err(|e| e.to_string())?;
///     println!("{} {:?}", at.t, at.q);
/// }
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Debug)]
pub struct Simulation<X, const N: usize, const M: usize> {
    mechanism: X,
    /// The values of its parameters.
    parameters: Vec<f64>,
    method: Method,
    step: f64,
    stepper: Stepper<N, M>,
    /// When the rows began.
    origin: f64,
    /// How many followed.
    rows: u64,
    /// The last of them.
    row: Moment<N, M>,
    /// What was asked for last.
    now: Moment<N, M>,
}

impl<X: Mechanism<N, M>, const N: usize, const M: usize> Simulation<X, N, M> {
    /// The motion at its start, t = 0, as the scene asks for it.
    ///
    /// `step` is the step in seconds, or the time between rows of a method that chooses its steps; the scene's if `None`.
    ///
    /// # Errors
    /// The mechanism cannot be assembled, its accelerations are not determined, or the step is not above zero.
    pub fn new(mechanism: X, method: Method, step: Option<f64>) -> Result<Self, Trouble> {
        let made = Self::begin(mechanism, method, step);
        let made = made.map_err(|reason| trouble::<X, N, M>(Reason::NoStart(reason)))?;
        made.massive()
    }

    /// The same, if every motion has an energy that is not negative.
    fn massive(self) -> Result<Self, Trouble> {
        let is_massive = is_positive(self.mechanism.mass_matrix(&self.now.q));
        if is_massive { Ok(self) } else { Err(trouble::<X, N, M>(Reason::NegativeMass)) }
    }

    fn begin(mechanism: X, method: Method, step: Option<f64>) -> Result<Self, NoStart> {
        let step = step.unwrap_or(mechanism.schedule().step);
        if !(step > 0.0) {
            return Err(NoStart::StepTooShort { step, end_time: f64::INFINITY });
        }
        let (q, qd) = assemble(&mechanism, &mechanism.start()).map_err(NoStart::NotAssembled)?;
        let (first, stepper) = beginning(&mechanism, &method, 0.0, (q, qd)).map_err(NoStart::Broken)?;
        let parameters = parameters(&mechanism);
        Ok(Self { mechanism, parameters, method, step, stepper, origin: 0.0, rows: 0, row: first, now: first })
    }

    /// The mechanism.
    pub fn mechanism(&self) -> &X {
        &self.mechanism
    }

    /// The values of its parameters, in the order of the description.
    pub fn parameters(&self) -> &[f64] {
        &self.parameters
    }

    /// The state that was asked for last.
    pub fn now(&self) -> &Moment<N, M> {
        &self.now
    }

    /// The outputs there, in the order of the description, as far as `outputs` has room.
    pub fn outputs(&self, outputs: &mut [f64]) {
        let Moment { t, q, qd, qdd, multipliers, .. } = &self.now;
        self.mechanism.outputs(*t, q, qd, qdd, multipliers, outputs);
    }

    /// The state at time `t`, which is not before the last one.
    ///
    /// # Errors
    /// The motion does not get there; the state stays what it was.
    pub fn advance(&mut self, t: f64) -> Result<&Moment<N, M>, Trouble> {
        let from = self.now.t;
        // Not a number is no time that can be reached either.
        if !(t - from <= MOST_STEPS * self.step) {
            return Err(trouble::<X, N, M>(Reason::NoTime { from, to: t }));
        }
        if t < from - NEAR * self.step {
            return Err(trouble::<X, N, M>(Reason::Backwards { from, to: t }));
        }
        self.go(t).map_err(|breakdown| trouble::<X, N, M>(Reason::Broken { t: from, breakdown }))?;
        Ok(&self.now)
    }

    fn go(&mut self, t: f64) -> Result<(), Breakdown> {
        let mut care = Care::default();
        let mut ahead = Ahead { stepper: self.stepper, rows: self.rows, row: self.row };
        if is_walked(&self.method) && self.row_time(self.rows + 1) <= self.latest(t) {
            let mut walker = Until { simulation: self, latest: self.latest(t), rows: ahead.rows, row: ahead.row };
            walk(&self.mechanism, &self.parameters, &self.method, ahead.row, &mut care, &mut walker)?;
            (ahead.rows, ahead.row) = (walker.rows, walker.row);
        }
        while self.row_time(ahead.rows + 1) <= self.latest(t) {
            let next = self.row_time(ahead.rows + 1);
            ahead.row = ahead.stepper.next(&self.mechanism, &self.method, &ahead.row, next, &mut care)?;
            ahead.rows += 1;
        }
        let now = if ahead.row.t >= t - NEAR * self.step {
            ahead.row
        } else {
            ahead.stepper.between(&self.mechanism, &self.method, &ahead.row, t, &mut care)?
        };
        (self.stepper, self.rows, self.row, self.now) = (ahead.stepper, ahead.rows, ahead.row, now);
        Ok(())
    }

    /// Goes on with another mechanism of the same kind, from where this one is: other masses, springs, loads.
    ///
    /// # Errors
    /// Its loops cannot be closed near this position, or its accelerations are not determined; then nothing has changed.
    pub fn replace(&mut self, mechanism: X) -> Result<(), Trouble> {
        let t = self.now.t;
        let changed = self.changed(mechanism);
        *self = changed.map_err(|breakdown| trouble::<X, N, M>(Reason::Broken { t, breakdown }))?.massive()?;
        Ok(())
    }

    fn changed(&self, mechanism: X) -> Result<Self, Breakdown> {
        let mut care = Care::default();
        let Moment { t, mut q, mut qd, .. } = self.now;
        if self.method.projection != Projection::None {
            let how = (self.method.projection, self.method.tolerance);
            project(&mechanism, how, None, t, &mut q, &mut qd, &mut care)?;
        }
        let (first, stepper) = beginning(&mechanism, &self.method, t, (q, qd))?;
        let parameters = parameters(&mechanism);
        let (method, step) = (self.method, self.step);
        Ok(Self { mechanism, parameters, method, step, stepper, origin: t, rows: 0, row: first, now: first })
    }

    /// Goes on from other coordinates and rates, at another time.
    ///
    /// # Errors
    /// The accelerations are not determined there; then nothing has changed.
    pub fn place(&mut self, t: f64, q: Vector<N>, qd: Vector<N>) -> Result<(), Trouble> {
        let (first, stepper) = beginning(&self.mechanism, &self.method, t, (q, qd))
            .map_err(|breakdown| trouble::<X, N, M>(Reason::Broken { t, breakdown }))?;
        (self.origin, self.rows, self.row, self.now, self.stepper) = (t, 0, first, first, stepper);
        Ok(())
    }

    fn row_time(&self, row: u64) -> f64 {
        self.origin + row as f64 * self.step
    }

    /// Rows up to this time are made on the way to `t`.
    fn latest(&self, t: f64) -> f64 {
        t + NEAR * self.step
    }
}

/// What steps need where they begin.
fn beginning<X: Mechanism<N, M>, const N: usize, const M: usize>(
    mechanism: &X,
    method: &Method,
    t: f64,
    (q, qd): (Vector<N>, Vector<N>),
) -> Result<(Moment<N, M>, Stepper<N, M>), Breakdown> {
    let mut care = Care::default();
    let first = moment(mechanism, t, q, qd, &mut care)?;
    let stepper = Stepper::new(mechanism, method.scheme, first, f64::INFINITY, &mut care)?;
    Ok((first, stepper))
}

fn trouble<X: Mechanism<N, M>, const N: usize, const M: usize>(reason: Reason) -> Trouble {
    Trouble { reason, description: X::DESCRIPTION }
}

/// Whether a symmetric matrix is positive semidefinite, by elimination from the largest entry of its diagonal on.
fn is_positive<const N: usize>(mut matrix: Matrix<N, N>) -> bool {
    let largest = |matrix: &Matrix<N, N>| (0..N).map(|i| matrix[i][i]).fold(f64::NEG_INFINITY, f64::max);
    let rounding = 1e-12 * largest(&matrix).max(0.0);
    for _ in 0..N {
        if (0..N).any(|i| matrix[i][i] < -rounding) {
            return false;
        }
        let pivot = (0..N).max_by(|&i, &j| matrix[i][i].total_cmp(&matrix[j][j])).unwrap_or(0);
        let row = matrix[pivot];
        if !(row[pivot] > rounding) {
            return true;
        }
        for i in 0..N {
            for j in 0..N {
                matrix[i][j] -= row[i] * row[j] / row[pivot];
            }
        }
    }
    true
}

/// Steps that nobody waits for.
const MOST_STEPS: f64 = 1e11;
/// Times nearer to each other than this part of a step are the same.
const NEAR: f64 = 1e-9;

/// How far a simulation has come that may still break off.
struct Ahead<const N: usize, const M: usize> {
    stepper: Stepper<N, M>,
    rows: u64,
    row: Moment<N, M>,
}

/// Takes rows up to a time.
struct Until<'s, X, const N: usize, const M: usize> {
    simulation: &'s Simulation<X, N, M>,
    latest: f64,
    rows: u64,
    row: Moment<N, M>,
}

impl<X: Mechanism<N, M>, const N: usize, const M: usize> Walker<N, M> for Until<'_, X, N, M> {
    #[inline(always)]
    fn next_time(&self) -> f64 {
        self.simulation.row_time(self.rows + 1)
    }

    #[inline(always)]
    fn arrive(&mut self, moment: Moment<N, M>, _care: &mut Care) -> bool {
        self.row = moment;
        self.rows += 1;
        self.next_time() <= self.latest
    }
}
