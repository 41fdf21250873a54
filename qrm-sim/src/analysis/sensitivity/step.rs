//! Runge-Kutta steps on dual numbers.

use qrm_core::{Mechanism, Scalar, Tape, TapeEvaluator};

use super::SensitivityError;
use super::number::{Number, PARTS, derivatives, has_derivatives, number};
use super::saddle::{DualSaddlePoint, Equations};
use crate::integrate::StepError;
use crate::solve::{Projection, ProjectionTolerance, Solver};
use crate::state::State;

/// A state with its derivatives by parameters.
#[derive(Clone, Debug)]
pub(super) struct DualState {
    pub(super) t: Number,
    pub(super) q: Vec<Number>,
    pub(super) qd: Vec<Number>,
    pub(super) qdd: Vec<Number>,
    pub(super) multipliers: Vec<Number>,
}

/// Makes steps by the tape of a mechanism.
pub(super) struct DualStepper<'m> {
    pub(super) mechanism: &'m dyn Mechanism,
    pub(super) evaluator: TapeEvaluator<'m, Vec<Number>>,
    /// Projects values.
    solver: Solver,
    saddle: DualSaddlePoint,
    /// Results of the tape's functions.
    dynamics: Vec<Number>,
    constraints: Vec<Number>,
    mass_matrix: Vec<Number>,
    bias: Vec<Number>,
    zero: Vec<Number>,
}

impl<'m> DualStepper<'m> {
    pub(super) fn new(mechanism: &'m dyn Mechanism, tape: &'m Tape<'m>, parts: usize) -> Self {
        let (n, m) = (tape.coordinates as usize, tape.constraints as usize);
        let zero = |size| vec![Number::zero(); size];
        Self {
            mechanism,
            evaluator: TapeEvaluator::new(tape),
            solver: Solver::new(mechanism),
            saddle: DualSaddlePoint::zero(n, m, parts),
            dynamics: zero(tape.dynamics.results.len()),
            constraints: zero(tape.loop_constraints.results.len()),
            mass_matrix: zero(n * n),
            bias: zero(m),
            zero: zero(n),
        }
    }

    /// The state of given time, coordinates and rates on the constraints.
    ///
    /// # Errors
    /// The accelerations are not determined there, or have no derivatives.
    pub(super) fn state(&mut self, t: Number, q: Vec<Number>, qd: Vec<Number>) -> Result<DualState, SensitivityError> {
        let made = self.completed(t, q, qd);
        self.checked(t, made)
    }

    /// The state at `t` by one step of the classical Runge-Kutta method, projected onto the constraints in the mass
    /// metric.
    ///
    /// # Errors
    /// The step cannot be made, or its end has no derivatives.
    pub(super) fn step(&mut self, from: &DualState, t: Number) -> Result<DualState, SensitivityError> {
        let made = self.stepped(from, t);
        self.checked(from.t, made)
    }

    fn checked(&self, t: Number, made: Result<DualState, StepError>) -> Result<DualState, SensitivityError> {
        let t = t.0.re;
        let made = made.map_err(|error| SensitivityError::Step { t, error })?;
        // With dependent constraints the equations do not determine the derivatives.
        for stats in [&self.saddle.stats, &self.solver.stats] {
            if stats.suspicious_constraints != 0 || stats.dependent_constraints != 0 {
                return Err(SensitivityError::Singular { t });
            }
        }
        let numbers = || [&made.q, &made.qd, &made.qdd, &made.multipliers].into_iter().flatten();
        if !numbers().all(|number| number.0.re.is_finite()) {
            return Err(SensitivityError::Step { t, error: StepError::NotFinite });
        }
        if !numbers().all(has_derivatives) {
            return Err(SensitivityError::NotSmooth { t });
        }
        Ok(made)
    }

    fn stepped(&mut self, from: &DualState, t: Number) -> Result<DualState, StepError> {
        let h = t - from.t;
        let half = Number::from_f64(0.5) * h;
        let mut multipliers = from.multipliers.clone();
        let mut slope = (from.qd.clone(), from.qdd.clone());
        let mut sum = slope.clone();
        for (part, weight) in [(half, 2.0), (half, 2.0), (h, 1.0)] {
            let (q, qd) = (along(&from.q, part, &slope.0), along(&from.qd, part, &slope.1));
            self.accelerations(from.t + part, &q, &qd, &mut slope.1, &mut multipliers)?;
            slope.0 = qd;
            let weight = Number::from_f64(weight);
            sum = (along(&sum.0, weight, &slope.0), along(&sum.1, weight, &slope.1));
        }
        let sixth = h / Number::from_f64(6.0);
        let (mut q, mut qd) = (along(&from.q, sixth, &sum.0), along(&from.qd, sixth, &sum.1));
        self.project(t, &mut q, &mut qd)?;
        self.completed(t, q, qd)
    }

    fn completed(&mut self, t: Number, q: Vec<Number>, qd: Vec<Number>) -> Result<DualState, StepError> {
        let (mut qdd, mut multipliers) = (self.zero.clone(), vec![Number::zero(); self.bias.len()]);
        self.accelerations(t, &q, &qd, &mut qdd, &mut multipliers)?;
        Ok(DualState { t, q, qd, qdd, multipliers })
    }

    fn accelerations(
        &mut self,
        t: Number,
        q: &[Number],
        qd: &[Number],
        qdd: &mut [Number],
        multipliers: &mut [Number],
    ) -> Result<(), StepError> {
        self.evaluator.dynamics(t, q, qd, &mut self.dynamics);
        let [mass_matrix, forces, jacobian, bias] = self.evaluator.tape().split_dynamics(&self.dynamics);
        Ok(self.saddle.solve(&Equations { mass_matrix, forces, jacobian, bias }, qdd, multipliers)?)
    }

    /// Projects coordinates and rates: values by Gauss-Newton iteration, derivatives by those of the equations of the
    /// projection, `M dx + C_q' w = 0` with `C(q + dx) = 0` for the coordinates and `C_q (qd + dx) + C_t = 0` for the
    /// rates.
    fn project(&mut self, t: Number, q: &mut [Number], qd: &mut [Number]) -> Result<(), StepError> {
        if self.bias.is_empty() {
            return Ok(());
        }
        let (mut position, mut rates) = (values(q), values(qd));
        self.solver.factor_mass(self.mechanism, &position);
        let projection = (Projection::Mass, ProjectionTolerance::default());
        self.solver.project(self.mechanism, projection, t.0.re, &mut position, &mut rates)?;
        let moved: Vec<f64> = position.iter().zip(&*q).map(|(to, from)| to - from.0.re).collect();
        set_values(q, &position);
        // The constraints by their tangent at the end of the correction: their values at its beginning are -C_q dx.
        let mut correction = self.zero.clone();
        self.correction(t, q, &mut correction, |residual, row, _| {
            row.iter().zip(&moved).fold(residual, |open, (entry, moved)| open - *entry * Number::from_f64(*moved))
        })?;
        add_derivatives(q, &correction);
        self.correction(t, q, &mut correction, |_, row, rate| {
            row.iter().zip(&*qd).fold(rate, |open, (entry, qd)| open + *entry * *qd)
        })?;
        add_derivatives(qd, &correction);
        set_values(qd, &rates);
        Ok(())
    }

    /// The smallest `dx` with `C_q dx = -open` at a position; `open` is a function of a constraint's residual, its row
    /// of `C_q` and its entry of `C_t`.
    fn correction(
        &mut self,
        t: Number,
        q: &[Number],
        correction: &mut [Number],
        open: impl Fn(Number, &[Number], Number) -> Number,
    ) -> Result<(), StepError> {
        self.evaluator.loop_constraints(t, q, &mut self.constraints);
        let [residuals, jacobian, rates] = self.evaluator.tape().split_loop_constraints(&self.constraints);
        let rows = residuals.iter().zip(jacobian.chunks_exact(q.len())).zip(rates);
        for (bias, ((residual, row), rate)) in self.bias.iter_mut().zip(rows) {
            *bias = open(*residual, row, *rate);
        }
        self.evaluator.mass_matrix(q, &mut self.mass_matrix);
        if !self.solver.has_metric() {
            let identity = |i| Number::from_f64(if i % (q.len() + 1) == 0 { 1.0 } else { 0.0 });
            self.mass_matrix.iter_mut().enumerate().for_each(|(i, entry)| *entry = identity(i));
        }
        let equations = Equations { mass_matrix: &self.mass_matrix, forces: &self.zero, jacobian, bias: &self.bias };
        let mut multipliers = vec![Number::zero(); self.bias.len()];
        Ok(self.saddle.solve(&equations, correction, &mut multipliers)?)
    }
}

/// `x + h v`
fn along(x: &[Number], h: Number, v: &[Number]) -> Vec<Number> {
    x.iter().zip(v).map(|(x, v)| *x + h * *v).collect()
}

/// The values of a state.
pub(super) fn real(at: &DualState) -> State {
    State {
        t: at.t.0.re,
        q: values(&at.q),
        qd: values(&at.qd),
        qdd: values(&at.qdd),
        multipliers: values(&at.multipliers),
        corrections: 0,
    }
}

fn values(numbers: &[Number]) -> Vec<f64> {
    numbers.iter().map(|number| number.0.re).collect()
}

fn set_values(numbers: &mut [Number], values: &[f64]) {
    for (number, value) in numbers.iter_mut().zip(values) {
        number.0.re = *value;
    }
}

fn add_derivatives(numbers: &mut [Number], others: &[Number]) {
    for (sum, other) in numbers.iter_mut().zip(others) {
        let (own, other) = (derivatives(sum), derivatives(other));
        let mut both = [0.0; PARTS];
        for part in 0..PARTS {
            both[part] = own[part] + other[part];
        }
        *sum = number(sum.0.re, both);
    }
}
