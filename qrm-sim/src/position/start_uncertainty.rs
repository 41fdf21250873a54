//! The uncertainty of a start that given coordinates hardly determine.

use qrm_core::Mechanism;

use super::assembly::rates;
use super::start::Start;
use crate::solve::{LoopConstraints, Matrix, SmallestSingularValue, largest};

/// Smaller uncertainties, relative to a turn or to the largest coordinate, are rounding errors like others.
const SMALL: f64 = 1e-14;
/// Smaller uncertainties, by the same measure, need no warning.
const WARNED: f64 = 1e-12;
/// The smallest uncertainty at a dead point, by the same measure: positions on both sides cannot be told apart.
const DEAD: f64 = 1e-9;
/// The smallest relative change of rates within the uncertainty that leaves them undetermined.
const UNDETERMINED: f64 = 0.1;
/// The distance, relative to a turn or to the largest coordinate, at which the curvature of the constraints is
/// measured.
const DISTANCE: f64 = 1e-3;

/// Another start, at the edge of what is known of the start.
#[derive(Clone, Debug)]
pub(crate) struct StartUncertainty {
    /// The coordinate that is known least.
    pub(crate) coordinate: usize,
    /// Its possible error.
    pub(crate) error: f64,
    /// The coordinates and rates of the other start, twice as far away.
    pub(crate) q: Vec<f64>,
    pub(crate) qd: Vec<f64>,
}

impl StartUncertainty {
    /// Another start with all coordinates and rates, by which one is known to be wrong.
    #[cfg(feature = "events")]
    pub(crate) fn known(other: &Start) -> Self {
        Self { coordinate: 0, error: 0.0, q: other.q.clone(), qd: other.qd.clone() }
    }

    /// The least known coordinate and its possible error, if a warning is due.
    pub(crate) fn warning(&self) -> Option<(usize, f64)> {
        (self.error > WARNED * size(&self.q)).then_some((self.coordinate, self.error))
    }

    /// The coordinate whose rate, `qd` at the start, is as uncertain as large.
    pub(crate) fn undetermined_rate(&self, qd: &[f64]) -> Option<usize> {
        if self.error == 0.0 {
            return None;
        }
        let changes: Vec<f64> = self.qd.iter().zip(qd).map(|(other, own)| other - own).collect();
        let (place, change) = largest(&changes);
        (change > UNDETERMINED * largest(qd).1).then_some(place)
    }

    /// Whether the given coordinates are at a dead point.
    pub(super) fn is_at_dead_point(&self) -> bool {
        self.error > DEAD * size(&self.q)
    }
}

/// The largest coordinate, at least a radian.
fn size(q: &[f64]) -> f64 {
    largest(q).1.max(1.0)
}

/// The uncertainty of the coordinates `q` that follow from the given ones; `None` if it is as small as rounding errors.
///
/// A move by `d` along the direction `v` that changes the constraints least, of those that keep given coordinates,
/// leaves residuals of `s d + k d^2/2`, with the smallest singular value `s` of the columns of `C_q` that are not
/// given, and the curvature `k` of `C` along `v`. It is not seen where that is below the rounding errors `e` of the
/// residuals:
///
/// ```text
/// d = 2 e / (s + sqrt(s^2 + 2 k e))
/// ```
///
/// At a dead point, where `s = 0`, it is the root of `e`.
pub(crate) fn start_uncertainty(mechanism: &dyn Mechanism, start: &Start, q: &[f64]) -> Option<StartUncertainty> {
    let (n, m) = (q.len(), mechanism.description().constraints.len());
    let open: Vec<usize> = (0..n).filter(|&i| !start.given[i]).collect();
    if open.is_empty() || open.len() > m {
        return None;
    }
    let mut constraints = LoopConstraints::zero(n, m);
    constraints.evaluate(mechanism, 0.0, q);
    let jacobian = &constraints.constraint_jacobian;
    let terms = jacobian.iter().map(|row| row.iter().zip(q).map(|(entry, q)| (entry * q).abs()).sum());
    let rounding = f64::EPSILON * terms.fold(0.0, f64::max);
    let columns = Matrix::from_fn(open.len(), m, |i, k| jacobian[k][open[i]]);
    let mut smallest = SmallestSingularValue::new(open.len(), m);
    let slope = smallest.find(&columns)?;
    let size = size(q);
    let along = |distance: f64| {
        let mut moved = q.to_vec();
        open.iter().zip(&smallest.combination).for_each(|(&i, part)| moved[i] += distance * part);
        moved
    };
    let mut residuals = |distance: f64| {
        constraints.evaluate(mechanism, 0.0, &along(distance));
        constraints.residuals.clone()
    };
    if rounding <= SMALL * size * slope {
        return None;
    }
    let h = DISTANCE * size;
    let [before, at, behind] = [-h, 0.0, h].map(&mut residuals);
    let bend = (0..m).map(|k| ((before[k] + behind[k] - 2.0 * at[k]) / (h * h)).powi(2)).sum::<f64>().sqrt();
    let distance = 2.0 * rounding / (slope + (slope * slope + 2.0 * bend * rounding).sqrt());
    if !(distance > SMALL * size && distance.is_finite()) {
        return None;
    }
    let moved = along(2.0 * distance);
    constraints.evaluate(mechanism, 0.0, &moved);
    let qd = rates(&constraints, start, &moved).ok()?;
    let (place, part) = largest(&smallest.combination);
    Some(StartUncertainty { coordinate: open[place], error: distance * part, q: moved, qd })
}
