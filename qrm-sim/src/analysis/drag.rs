//! A mechanism that is dragged by one of its points.

use qrm_core::Mechanism;

use crate::solve::{LoopConstraints, Residuals, least_squares};

/// The way from a point of a mechanism to the place that it is dragged to.
#[derive(Clone, Debug)]
pub struct Pull {
    /// Its components in m.
    pub way: [f64; 2],
    /// Their derivatives by the coordinates.
    pub derivatives: [Vec<f64>; 2],
}

/// The weight of the way beside that of the constraints: where the place cannot be reached, loops stay all but closed.
const WEIGHT: f64 = 0.01;

/// The coordinates near `q` at which the constraints are met and the way is shortest.
///
/// Each residual counts by its size over that of its derivatives at `q`, so that units do not matter.
pub fn dragged(mechanism: &dyn Mechanism, q: &[f64], mut pull: impl FnMut(&[f64]) -> Pull) -> Vec<f64> {
    let m = mechanism.description().constraints.len();
    let mut constraints = LoopConstraints::zero(q.len(), m);
    let mut evaluate = |q: &[f64], residuals: &mut Residuals| {
        constraints.evaluate(mechanism, 0.0, q);
        let Pull { way, derivatives } = pull(q);
        residuals.values[..m].copy_from_slice(&constraints.residuals);
        residuals.values[m..].copy_from_slice(&way);
        let rows = constraints.constraint_jacobian.iter().chain(derivatives.iter().map(Vec::as_slice));
        rows.enumerate().for_each(|(i, row)| residuals.jacobian[i].copy_from_slice(row));
    };
    let mut first = Residuals::zero(m + 2, q.len());
    evaluate(q, &mut first);
    let size = |i: usize| first.jacobian[i].iter().map(|entry| entry.powi(2)).sum::<f64>().sqrt();
    let way = size(m).max(size(m + 1));
    let weight = |size: f64, weight: f64| if size > 0.0 { weight / size } else { 0.0 };
    let weights: Vec<f64> =
        (0..m + 2).map(|i| if i < m { weight(size(i), 1.0) } else { weight(way, WEIGHT) }).collect();
    least_squares(q, &vec![false; q.len()], m + 2, &mut |q, residuals| {
        evaluate(q, residuals);
        for (i, weight) in weights.iter().enumerate() {
            residuals.values[i] *= weight;
            residuals.jacobian[i].iter_mut().for_each(|entry| *entry *= weight);
        }
    })
}
