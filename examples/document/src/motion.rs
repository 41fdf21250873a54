//! The classical Runge-Kutta method of order 4 with a projection after each step, on the generated functions.

use nalgebra::{Matrix2x3, Matrix3, SMatrix, SVector, Vector2, Vector3};
use qrm_model::quick_return::{QuickReturn, constraint_jacobian, constraints, dynamics, energy, mass_matrix, outputs};

use crate::exact::EnergyIntegral;

/// The crank has completed two revolutions at this angle.
pub const END_ANGLE: f64 = 4.0 * std::f64::consts::PI;
/// Residuals of the constraints up to this one end the projection, in m.
const TOLERANCE: f64 = 1e-12;
/// The projection fails after so many corrections.
const MAX_ITERATIONS: u32 = 10;

/// The quantities of one row.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    pub t: f64,
    pub q: Vector3<f64>,
    pub qd: Vector3<f64>,
    pub qdd: Vector3<f64>,
    pub multipliers: Vector2<f64>,
    /// `x6`, `x6_dot`, `x6_ddot`, `v_slide`, `N3`, `N6`.
    pub outputs: [f64; 6],
}

impl Row {
    /// The row whose quantities all follow from the state at `t`.
    pub fn from_state(mechanism: &QuickReturn, t: f64, q: Vector3<f64>, qd: Vector3<f64>) -> Result<Self, String> {
        let (qdd, multipliers) = accelerations(mechanism, t, &q, &qd)?;
        Ok(Self::new(mechanism, t, q, qd, qdd, multipliers))
    }

    /// The row with given accelerations and multipliers, which the outputs are computed from.
    pub fn new(
        mechanism: &QuickReturn,
        t: f64,
        q: Vector3<f64>,
        qd: Vector3<f64>,
        qdd: Vector3<f64>,
        multipliers: Vector2<f64>,
    ) -> Self {
        let outputs = outputs(mechanism, t, &q.into(), &qd.into(), &qdd.into(), &multipliers.into());
        Self { t, q, qd, qdd, multipliers, outputs }
    }

    /// The values in the order of [`NAMES`](crate::comparison::NAMES).
    pub fn values(&self) -> Vec<f64> {
        let coordinates = (0..3).flat_map(|i| [self.q[i], self.qd[i], self.qdd[i]]);
        coordinates.chain(self.multipliers.iter().copied()).chain(self.outputs).collect()
    }
}

/// The metric in which the corrections of a projection are smallest.
#[derive(Clone, Copy, Debug)]
pub enum Metric {
    Euclidean,
    Mass,
}

/// How a state is projected onto the constraints.
#[derive(Clone, Copy, Debug)]
pub struct Projection {
    pub metric: Metric,
    /// Whether a further correction follows when the residuals are within the tolerance.
    pub has_further_correction: bool,
}

impl Projection {
    /// The projection of the script.
    pub const SCRIPT: Self = Self { metric: Metric::Euclidean, has_further_correction: false };
    /// The projection of `qrm run`.
    pub const COMMAND: Self = Self { metric: Metric::Mass, has_further_correction: true };

    /// Projects positions first, then velocities.
    fn apply(self, mechanism: &QuickReturn, t: f64, q: &mut Vector3<f64>, qd: &mut Vector3<f64>) -> Result<(), String> {
        let weight = match self.metric {
            Metric::Euclidean => Matrix3::identity(),
            Metric::Mass => square(&mass_matrix(mechanism, &(*q).into())),
        };
        for iteration in 0.. {
            let residual = Vector2::from(constraints(mechanism, &(*q).into()));
            let is_closed = residual.amax() <= TOLERANCE;
            if is_closed && !self.has_further_correction {
                break;
            }
            if iteration == MAX_ITERATIONS || !residual.amax().is_finite() {
                return Err(format!("the projection does not converge at t = {t} s"));
            }
            *q -= smallest_change(&weight, &jacobian(mechanism, q), &residual)?;
            if is_closed {
                break;
            }
        }
        let jacobian = jacobian(mechanism, q);
        *qd -= smallest_change(&weight, &jacobian, &(jacobian * *qd))?;
        Ok(())
    }
}

/// The smallest `dx` with `C_q dx = residual`.
fn smallest_change(
    weight: &Matrix3<f64>,
    jacobian: &Matrix2x3<f64>,
    residual: &Vector2<f64>,
) -> Result<Vector3<f64>, String> {
    saddle_point(weight, jacobian, &Vector3::zeros(), residual).map(|(change, _)| change)
}

/// The accelerations and multipliers of a state.
pub fn accelerations(
    mechanism: &QuickReturn,
    t: f64,
    q: &Vector3<f64>,
    qd: &Vector3<f64>,
) -> Result<(Vector3<f64>, Vector2<f64>), String> {
    let dynamics = dynamics(mechanism, t, &(*q).into(), &(*qd).into());
    saddle_point(
        &square(&dynamics.mass_matrix),
        &rectangular(&dynamics.constraint_jacobian),
        &dynamics.generalized_forces.into(),
        &-Vector2::from(dynamics.constraint_bias),
    )
}

/// Solves `M x + C_q' lambda = f`, `C_q x = b`.
fn saddle_point(
    m: &Matrix3<f64>,
    jacobian: &Matrix2x3<f64>,
    f: &Vector3<f64>,
    b: &Vector2<f64>,
) -> Result<(Vector3<f64>, Vector2<f64>), String> {
    let mut matrix = SMatrix::<f64, 5, 5>::zeros();
    matrix.fixed_view_mut::<3, 3>(0, 0).copy_from(m);
    matrix.fixed_view_mut::<2, 3>(3, 0).copy_from(jacobian);
    matrix.fixed_view_mut::<3, 2>(0, 3).copy_from(&jacobian.transpose());
    let mut right_side = SVector::<f64, 5>::zeros();
    right_side.fixed_rows_mut::<3>(0).copy_from(f);
    right_side.fixed_rows_mut::<2>(3).copy_from(b);
    let solution = matrix.lu().solve(&right_side).ok_or("the equations of motion are singular")?;
    Ok((solution.fixed_rows::<3>(0).into(), solution.fixed_rows::<2>(3).into()))
}

/// The Jacobian of the constraints.
pub fn jacobian(mechanism: &QuickReturn, q: &Vector3<f64>) -> Matrix2x3<f64> {
    rectangular(&constraint_jacobian(mechanism, &(*q).into()))
}

fn square(rows: &[[f64; 3]; 3]) -> Matrix3<f64> {
    Matrix3::from_fn(|i, j| rows[i][j])
}

fn rectangular(rows: &[[f64; 3]; 2]) -> Matrix2x3<f64> {
    Matrix2x3::from_fn(|i, j| rows[i][j])
}

/// The total energy of a state.
pub fn total_energy(mechanism: &QuickReturn, q: &Vector3<f64>, qd: &Vector3<f64>) -> f64 {
    energy(mechanism, &(*q).into(), &(*qd).into()).iter().sum()
}

/// The state at the end of a step, with averages of the stages.
#[derive(Clone, Copy, Debug)]
pub struct StepResult {
    pub t: f64,
    pub q: Vector3<f64>,
    pub qd: Vector3<f64>,
    /// The average of the accelerations at the four stages, with the weights of the method.
    pub mean_qdd: Vector3<f64>,
    /// The average of the multipliers at the four stages, with the weights of the method.
    pub mean_multipliers: Vector2<f64>,
}

/// Integrates until the crank has completed two revolutions.
///
/// The averages of the first result are the values at the start.
pub fn integrate(mechanism: &QuickReturn, step: f64, projection: Projection) -> Result<Vec<StepResult>, String> {
    let (q, qd) = EnergyIntegral::new(mechanism)?.start();
    let (mean_qdd, mean_multipliers) = accelerations(mechanism, 0.0, &q, &qd)?;
    let mut last = StepResult { t: 0.0, q, qd, mean_qdd, mean_multipliers };
    let mut results = vec![last];
    while last.q[0] < END_ANGLE {
        last = rk4_step(mechanism, &last, step * results.len() as f64, projection)?;
        results.push(last);
    }
    Ok(results)
}

fn rk4_step(
    mechanism: &QuickReturn,
    from: &StepResult,
    t_next: f64,
    projection: Projection,
) -> Result<StepResult, String> {
    let h = t_next - from.t;
    let stage = |part: f64, qd: &Vector3<f64>, qdd: &Vector3<f64>| {
        let (q, qd) = (from.q + part * h * qd, from.qd + part * h * qdd);
        let (qdd, multipliers) = accelerations(mechanism, from.t + part * h, &q, &qd)?;
        Ok::<_, String>((qd, qdd, multipliers))
    };
    let zero = Vector3::zeros();
    let (v1, a1, l1) = stage(0.0, &zero, &zero)?;
    let (v2, a2, l2) = stage(0.5, &v1, &a1)?;
    let (v3, a3, l3) = stage(0.5, &v2, &a2)?;
    let (v4, a4, l4) = stage(1.0, &v3, &a3)?;
    let mean_qdd = (a1 + 2.0 * (a2 + a3) + a4) / 6.0;
    let mean_multipliers = (l1 + 2.0 * (l2 + l3) + l4) / 6.0;
    let mut q = from.q + h * (v1 + 2.0 * (v2 + v3) + v4) / 6.0;
    let mut qd = from.qd + h * mean_qdd;
    projection.apply(mechanism, t_next, &mut q, &mut qd)?;
    Ok(StepResult { t: t_next, q, qd, mean_qdd, mean_multipliers })
}

/// The rows of `qrm run`: every quantity belongs to the time of its row.
pub fn command_rows(mechanism: &QuickReturn, step: f64) -> Result<Vec<Row>, String> {
    let states = integrate(mechanism, step, Projection::COMMAND)?;
    states.iter().map(|state| Row::from_state(mechanism, state.t, state.q, state.qd)).collect()
}
