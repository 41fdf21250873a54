//! Coordinates at which a point of a mechanism reaches its target.

use qrm_core::Mechanism;

use crate::solve::{LoopConstraints, Residuals, least_squares};

/// The position of a point minus that of its target.
#[derive(Clone, Debug)]
pub struct PositionError {
    /// The components of the position error, in m.
    pub components: [f64; 2],
    /// The derivatives of the components with respect to the coordinates.
    pub jacobian: [Vec<f64>; 2],
}

/// The weight of the position error relative to the constraints: if the target cannot be reached, loops stay nearly
/// closed.
const WEIGHT: f64 = 0.01;

/// Finds the coordinates near `q` that satisfy the constraints with the smallest position error.
///
/// Each residual is divided by the size of its derivatives at `q`, so that units do not matter.
pub fn inverse_kinematics(
    mechanism: &dyn Mechanism,
    q: &[f64],
    mut position_error: impl FnMut(&[f64]) -> PositionError,
) -> Vec<f64> {
    let m = mechanism.description().constraints.len();
    let mut constraints = LoopConstraints::zero(q.len(), m);
    let mut evaluate = |q: &[f64], residuals: &mut Residuals| {
        constraints.evaluate(mechanism, 0.0, q);
        let PositionError { components, jacobian } = position_error(q);
        residuals.values[..m].copy_from_slice(&constraints.residuals);
        residuals.values[m..].copy_from_slice(&components);
        let rows = constraints.constraint_jacobian.iter().chain(jacobian.iter().map(Vec::as_slice));
        rows.enumerate().for_each(|(i, row)| residuals.jacobian[i].copy_from_slice(row));
    };
    let mut first = Residuals::zero(m + 2, q.len());
    evaluate(q, &mut first);
    let size = |i: usize| first.jacobian[i].iter().map(|entry| entry.powi(2)).sum::<f64>().sqrt();
    let position = size(m).max(size(m + 1));
    let weight = |size: f64, weight: f64| if size > 0.0 { weight / size } else { 0.0 };
    let weights: Vec<f64> =
        (0..m + 2).map(|i| if i < m { weight(size(i), 1.0) } else { weight(position, WEIGHT) }).collect();
    least_squares(q, &vec![false; q.len()], m + 2, &mut |q, residuals| {
        evaluate(q, residuals);
        for (i, weight) in weights.iter().enumerate() {
            residuals.values[i] *= weight;
            residuals.jacobian[i].iter_mut().for_each(|entry| *entry *= weight);
        }
    })
}
