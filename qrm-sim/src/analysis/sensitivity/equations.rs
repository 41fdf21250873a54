//! The equations of motion on dual numbers.

use num_dual::Dual64;
use qrm_core::{Dual, Mechanism, Scalar, Tape, TapeEvaluator};

use super::SensitivityRequest;
use super::error::SensitivityError;
use super::number::{Inner, Number, has_derivatives, values};
use super::saddle::{DualSaddlePoint, Equations, less_product};
use super::slope::Slope;
use crate::integrate::{MethodSettings, StepError};
use crate::solve::{NEAR, NotConverged, Projection, Solver, largest};
use crate::state::State;

/// A state with its derivatives by parameters.
#[derive(Clone, Debug)]
pub(super) struct DualState<T: Inner> {
    pub(super) t: Number<T>,
    pub(super) q: Vec<Number<T>>,
    pub(super) qd: Vec<Number<T>>,
    pub(super) qdd: Vec<Number<T>>,
    pub(super) multipliers: Vec<Number<T>>,
}

impl<T: Inner> DualState<T> {
    /// Coordinates and rates.
    pub(super) fn place(&self) -> Slope<T> {
        Slope { q: self.q.clone(), qd: self.qd.clone() }
    }

    /// The derivatives of coordinates and rates by time.
    pub(super) fn slope(&self) -> Slope<T> {
        Slope { q: self.qd.clone(), qd: self.qdd.clone() }
    }

    /// The values of the state, without derivatives.
    pub(super) fn real(&self) -> State {
        State {
            t: self.t.to_f64(),
            q: values(&self.q),
            qd: values(&self.qd),
            qdd: values(&self.qdd),
            multipliers: values(&self.multipliers),
            corrections: 0,
        }
    }
}

/// A time, coordinates and rates, with their derivatives by time along the motion.
pub(super) type Moving = Dual<Dual64>;

/// The equations of motion of a mechanism by its tape, with derivatives by parameters.
pub(super) struct DualEquations<'m, T: Inner> {
    pub(super) mechanism: &'m dyn Mechanism,
    pub(super) evaluator: TapeEvaluator<'m, Vec<Number<T>>>,
    /// The number of parameters.
    pub(super) parts: usize,
    /// The equations with derivatives by time.
    moving: TapeEvaluator<'m, Vec<Moving>>,
    settings: MethodSettings,
    /// Tells whether the mass matrix is a metric, and how far positions are from singular ones.
    solver: Solver,
    /// Whether an output that was asked for takes accelerations or multipliers.
    takes_forces: bool,
    saddle: DualSaddlePoint,
    /// Results of the tape's functions.
    dynamics: Vec<Number<T>>,
    constraints: Vec<Number<T>>,
    mass_matrix: Vec<Number<T>>,
}

/// Residuals that a correction did not halve, and that are as small as this, are rounding errors.
const SETTLED: f64 = 1e-9;

impl<'m, T: Inner> DualEquations<'m, T> {
    /// Creates the equations of a request, with derivatives by this number of parameters.
    pub(super) fn new(
        mechanism: &'m dyn Mechanism,
        tape: &'m Tape,
        parts: usize,
        SensitivityRequest { settings, outputs, .. }: &SensitivityRequest,
    ) -> Self {
        let (n, m) = (tape.coordinates as usize, tape.constraints as usize);
        let is_asked = |output: &usize| outputs.is_none_or(|outputs| outputs.contains(output));
        let by_forces = tape.outputs_by_forces();
        let zero = |size| vec![Number::zero(); size];
        Self {
            mechanism,
            evaluator: TapeEvaluator::new(tape),
            parts,
            moving: TapeEvaluator::with_parameters(tape, mechanism.parameters()),
            settings: *settings,
            solver: Solver::new(mechanism),
            takes_forces: (0..by_forces.len()).any(|output| by_forces[output] && is_asked(&output)),
            saddle: DualSaddlePoint::zero(n, m, parts),
            dynamics: zero(tape.dynamics_length()),
            constraints: zero(tape.loop_constraints.results.len()),
            mass_matrix: zero(n * n),
        }
    }

    /// The state of given time, coordinates and rates, which are moved onto the constraints.
    ///
    /// # Errors
    /// The projection does not converge, or the accelerations are not determined.
    pub(super) fn projected(
        &mut self,
        t: Number<T>,
        mut q: Vec<Number<T>>,
        mut qd: Vec<Number<T>>,
    ) -> Result<DualState<T>, StepError> {
        self.project(t, &mut q, &mut qd)?;
        self.completed(t, q, qd)
    }

    /// The state of given time, coordinates and rates on the constraints.
    ///
    /// # Errors
    /// The accelerations are not determined there.
    pub(super) fn completed(
        &mut self,
        t: Number<T>,
        q: Vec<Number<T>>,
        qd: Vec<Number<T>>,
    ) -> Result<DualState<T>, StepError> {
        let [qdd, multipliers] = self.accelerations(t, &q, &qd)?;
        Ok(DualState { t, q, qd, qdd, multipliers })
    }

    /// Accelerations and multipliers.
    ///
    /// # Errors
    /// They are not determined.
    pub(super) fn accelerations(
        &mut self,
        t: Number<T>,
        q: &[Number<T>],
        qd: &[Number<T>],
    ) -> Result<[Vec<Number<T>>; 2], StepError> {
        self.evaluator.dynamics(t, q, qd, &mut self.dynamics);
        let [mass_matrix, forces, jacobian, bias] = self.evaluator.tape().split_dynamics(&self.dynamics);
        let mut qdd = self.saddle.solve(&Equations { mass_matrix, forces, jacobian, bias })?;
        let multipliers = qdd.split_off(q.len());
        Ok([qdd, multipliers])
    }

    /// The outputs of a state.
    ///
    /// # Errors
    /// They take forces, which have no derivatives near singular positions.
    pub(super) fn outputs(&mut self, at: &DualState<T>) -> Result<Vec<Number<T>>, SensitivityError> {
        if self.takes_forces {
            let (t, q, qd) = (at.t.to_f64(), values(&at.q), values(&at.qd));
            if self.solver.singularity_fraction(self.mechanism, NEAR, t, (&q, &qd)).is_some() {
                return Err(SensitivityError::ForcesNearSingular { t });
            }
        }
        let mut outputs = vec![Number::zero(); self.evaluator.tape().outputs.results.len()];
        self.evaluator.outputs(at.t, &at.q, &at.qd, &at.qdd, &at.multipliers, &mut outputs);
        Ok(outputs)
    }

    /// A state that a step from `t` on has led to.
    ///
    /// # Errors
    /// The step could not be made, or the state has no derivatives.
    pub(super) fn checked(
        &self,
        t: Number<T>,
        made: Result<DualState<T>, StepError>,
    ) -> Result<DualState<T>, SensitivityError> {
        let t = t.to_f64();
        let made = made.map_err(|error| SensitivityError::Step { t, error })?;
        // With dependent constraints the equations do not determine the derivatives.
        let stats = &self.saddle.stats;
        if stats.singular_constraints != 0 || stats.dependent_constraints != 0 {
            return Err(SensitivityError::Singular { t });
        }
        let numbers = || [&made.q, &made.qd, &made.qdd, &made.multipliers].into_iter().flatten();
        if !numbers().all(|number| number.to_f64().is_finite()) {
            return Err(SensitivityError::Step { t, error: StepError::NotFinite });
        }
        if !numbers().all(has_derivatives) {
            return Err(SensitivityError::NotSmooth { t });
        }
        Ok(made)
    }

    /// The values of a function of the tape at a state, with their derivatives by time along the motion.
    pub(super) fn along_motion<R>(
        &mut self,
        at: &State,
        function: impl FnOnce(&mut TapeEvaluator<'m, Vec<Moving>>, Moving, &[Moving], &[Moving]) -> R,
    ) -> R {
        let (t, q, qd) = moving(at);
        function(&mut self.moving, t, &q, &qd)
    }

    /// Projects coordinates and rates by Gauss-Newton iteration, derivatives included: each correction squares their
    /// errors too.
    fn project(&mut self, t: Number<T>, q: &mut [Number<T>], qd: &mut [Number<T>]) -> Result<(), StepError> {
        if self.settings.projection == Projection::None || self.evaluator.tape().constraints == 0 {
            return Ok(());
        }
        let tolerance = self.settings.projection_tolerance;
        let (mut before, mut closed) = (f64::INFINITY, 0);
        let mut iterations = 0;
        while closed < T::ORDER {
            self.evaluate_constraints(t, q);
            let [residuals, _, _] = self.evaluator.tape().split_loop_constraints(&self.constraints);
            let open = residuals.to_vec();
            let (constraint, residual) = largest(&values(&open));
            let is_closed = residual <= tolerance.residual || residual > 0.5 * before && residual <= SETTLED;
            if !is_closed && (iterations == tolerance.iterations || !residual.is_finite()) {
                return Err(NotConverged { constraint, residual, iterations }.into());
            }
            self.correct(&open, q)?;
            closed += usize::from(is_closed);
            (before, iterations) = (residual, iterations + 1);
        }
        self.evaluate_constraints(t, q);
        let [_, jacobian, rates] = self.evaluator.tape().split_loop_constraints(&self.constraints);
        let rows = jacobian.chunks_exact(q.len()).zip(rates);
        let open: Vec<Number<T>> = rows.map(|(row, rate)| -less_product(-*rate, row, qd)).collect();
        self.correct(&open, qd)
    }

    /// Evaluates constraints and metric at a position.
    fn evaluate_constraints(&mut self, t: Number<T>, q: &[Number<T>]) {
        self.evaluator.loop_constraints(t, q, &mut self.constraints);
        self.evaluator.mass_matrix(q, &mut self.mass_matrix);
        self.solver.factor_mass(self.mechanism, &values(q));
        if self.settings.projection != Projection::Mass || !self.solver.has_metric() {
            let identity = |i| Number::from_f64(if i % (q.len() + 1) == 0 { 1.0 } else { 0.0 });
            self.mass_matrix.iter_mut().enumerate().for_each(|(i, entry)| *entry = identity(i));
        }
    }

    /// Moves `x` by the smallest `dx` with `C_q dx = -open`.
    fn correct(&mut self, open: &[Number<T>], x: &mut [Number<T>]) -> Result<(), StepError> {
        let [_, jacobian, _] = self.evaluator.tape().split_loop_constraints(&self.constraints);
        let forces = vec![Number::zero(); x.len()];
        let equations = Equations { mass_matrix: &self.mass_matrix, forces: &forces, jacobian, bias: open };
        let change = self.saddle.solve(&equations)?;
        x.iter_mut().zip(change).for_each(|(x, change)| *x = *x + change);
        Ok(())
    }
}

/// Time, coordinates and rates of a state, with their derivatives by time.
pub(super) fn moving(at: &State) -> (Moving, Vec<Moving>, Vec<Moving>) {
    let along = |(x, rate): (&f64, &f64)| Dual(Dual64::new(*x, *rate));
    let numbers = |x: &[f64], rates: &[f64]| x.iter().zip(rates).map(along).collect();
    (Dual(Dual64::new(at.t, 1.0)), numbers(&at.q, &at.qd), numbers(&at.qd, &at.qdd))
}
