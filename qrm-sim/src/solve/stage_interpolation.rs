//! Accelerations of stages at singular positions, where the constraints are insufficient: interpolated across them.

use qrm_core::Mechanism;

use super::matrix::largest;
use super::precise::Number;
use super::projection_settings::{Projection, ProjectionTolerance};
use super::singular_position::interpolated;
use super::solver::Solver;
use super::stats::SolverStats;

/// Distances of the interpolation points, in rad or m: rounding errors grow with their inverse square, and errors of
/// the interpolation with their eighth power.
const DISTANCES: [f64; 2] = [1e-2, 1e-4];
/// The largest estimated error of precise accelerations, relative to the largest one or to the square of the rates.
const PRECISE: f64 = 1e-8;
/// The largest estimated error, relative to the largest multiplier, for which multipliers are interpolated: near a pole
/// no polynomial follows them.
const SMOOTH: f64 = 1e-3;

/// Replaces accelerations and multipliers at a singular position by those of the polynomial through projected
/// positions on both sides, along the rates, if its error, relative to the largest of them or to the square of the
/// rates, is below `own_error`. They stay unchanged at rest, and if the constraints are insufficient everywhere;
/// multipliers also stay unchanged near a pole.
#[cold]
pub(super) fn interpolate(
    mechanism: &dyn Mechanism,
    solver: &mut Solver,
    t: f64,
    (q, qd): (&[f64], &[f64]),
    own_error: f64,
    (qdd, multipliers): (&mut [f64], &mut [f64]),
) {
    let speed = largest(qd).1;
    if !(speed > 0.0 && speed.is_finite()) {
        return;
    }
    let n = q.len();
    let mut least = own_error;
    for distance in DISTANCES {
        let duration = distance / speed;
        let at = |place: f64| later(mechanism, solver, t, (q, qd), place * duration);
        let Some((values, differences)) = interpolated(at) else { continue };
        let (accelerations, forces) = values.split_at(n);
        let (of_accelerations, of_forces) = differences.split_at(n);
        let error = largest(of_accelerations).1 / largest(accelerations).1.max(speed * speed);
        if error < least {
            least = error;
            qdd.copy_from_slice(accelerations);
            if largest(of_forces).1 <= SMOOTH * largest(forces).1 {
                multipliers.copy_from_slice(forces);
            }
        }
        if least <= PRECISE {
            break;
        }
    }
}

/// The accelerations and multipliers on the constraints after a time along the rates, which may be negative. The result
/// is `None` if the constraints are insufficient there too.
fn later(
    mechanism: &dyn Mechanism,
    solver: &mut Solver,
    t: f64,
    (q, qd): (&[f64], &[f64]),
    duration: f64,
) -> Option<Vec<Number>> {
    solver.stats = SolverStats::default();
    // Constraints that depend on time are evaluated at the time at which the motion is there.
    let t = if mechanism.is_driven() { t + duration } else { t };
    let mut position: Vec<f64> = q.iter().zip(qd).map(|(q, qd)| q + duration * qd).collect();
    let mut rates = qd.to_vec();
    solver.factor_mass(mechanism, &position);
    solver.project(mechanism, (Projection::Mass, ProjectionTolerance::default()), t, &mut position, &mut rates).ok()?;
    solver.saddle.dynamics.evaluate(mechanism, t, &position, &rates);
    let mut values = vec![0.0; q.len() + solver.weights.len()];
    let (qdd, multipliers) = values.split_at_mut(q.len());
    solver.saddle.solve(qdd, multipliers, &mut solver.stats).ok()?;
    (solver.stats.suspicious_constraints == 0).then(|| values.into_iter().map(Number::from).collect())
}
