//! Accelerations at singular positions, where the constraints are insufficient: interpolated across them.

use qrm_core::Mechanism;

use super::matrix::largest;
use super::projection_settings::{Projection, ProjectionTolerance};
use super::solver::Solver;
use super::stats::SolverStats;

/// Distances of the interpolation points, in rad or m: rounding errors grow with their inverse square, and errors of
/// the interpolation with their eighth power.
const DISTANCES: [f64; 2] = [1e-2, 1e-4];
/// The largest estimated error of precise accelerations, relative to the largest one.
const PRECISE: f64 = 1e-8;
/// The largest estimated error, relative to the largest multiplier, for which multipliers are interpolated: near a pole
/// no polynomial follows them.
const SMOOTH: f64 = 1e-3;
/// The weights of positions at one to four distances on each side, in the polynomial of degree 7 through all of them.
const WEIGHTS: [f64; 4] = [4.0 / 5.0, -2.0 / 5.0, 4.0 / 35.0, -1.0 / 70.0];
/// The weights of the same positions in the polynomial of degree 5 through the inner six: the difference between the
/// two polynomials is the estimated error.
const INNER_WEIGHTS: [f64; 4] = [3.0 / 4.0, -3.0 / 10.0, 1.0 / 20.0, 0.0];

/// Replaces accelerations and multipliers at a singular position by those of the polynomial through projected positions
/// on both sides, along the rates. They stay unchanged at rest, and if the constraints are insufficient everywhere;
/// multipliers also stay unchanged near a pole.
#[cold]
pub(super) fn interpolate(
    mechanism: &dyn Mechanism,
    solver: &mut Solver,
    t: f64,
    (q, qd): (&[f64], &[f64]),
    (qdd, multipliers): (&mut [f64], &mut [f64]),
) {
    let speed = largest(qd).1;
    if !(speed > 0.0 && speed.is_finite()) {
        return;
    }
    let count = q.len() + multipliers.len();
    let mut motion = Motion { mechanism, solver, count, t, q, qd, duration: 0.0 };
    let mut least = f64::INFINITY;
    for distance in DISTANCES {
        motion.duration = distance / speed;
        let Some(([error, of_multipliers], values)) = motion.interpolated() else { continue };
        if error < least {
            least = error;
            let (accelerations, forces) = values.split_at(q.len());
            qdd.copy_from_slice(accelerations);
            if of_multipliers <= SMOOTH * largest(forces).1 {
                multipliers.copy_from_slice(forces);
            }
        }
        if error <= PRECISE * largest(qdd).1 {
            break;
        }
    }
}

/// The motion through a position, parametrized by the time in which its fastest coordinate moves by one distance.
struct Motion<'a> {
    mechanism: &'a dyn Mechanism,
    solver: &'a mut Solver,
    /// The number of accelerations and multipliers.
    count: usize,
    t: f64,
    q: &'a [f64],
    qd: &'a [f64],
    duration: f64,
}

impl Motion<'_> {
    /// The estimated errors of accelerations and multipliers, and both interpolated between positions on both sides;
    /// `None` if the constraints are insufficient there.
    fn interpolated(&mut self) -> Option<([f64; 2], Vec<f64>)> {
        let (mut values, mut difference) = (vec![0.0; self.count], vec![0.0; self.count]);
        for (k, (weight, inner)) in WEIGHTS.iter().zip(INNER_WEIGHTS).enumerate() {
            let place = (k + 1) as f64;
            for place in [-place, place] {
                let at = self.at(place)?;
                for ((value, difference), at) in values.iter_mut().zip(&mut difference).zip(at) {
                    *value += weight * at;
                    *difference += (weight - inner) * at;
                }
            }
        }
        let (of_accelerations, of_multipliers) = difference.split_at(self.q.len());
        Some(([of_accelerations, of_multipliers].map(|difference| largest(difference).1), values))
    }

    /// The accelerations and multipliers at a position, in distances; `None` if the constraints are insufficient.
    fn at(&mut self, place: f64) -> Option<Vec<f64>> {
        let Self { mechanism, solver, q, qd, .. } = self;
        let duration = place * self.duration;
        solver.stats = SolverStats::default();
        // Constraints that depend on time are evaluated at the time at which the motion is there.
        let t = if mechanism.is_driven() { self.t + duration } else { self.t };
        let mut position: Vec<f64> = q.iter().zip(*qd).map(|(q, v)| q + duration * v).collect();
        let mut rates = qd.to_vec();
        solver.factor_mass(*mechanism, &position);
        let projection = (Projection::Mass, ProjectionTolerance::default());
        solver.project(*mechanism, projection, t, &mut position, &mut rates).ok()?;
        solver.saddle.dynamics.evaluate(*mechanism, t, &position, &rates);
        let mut values = vec![0.0; self.count];
        let (qdd, multipliers) = values.split_at_mut(q.len());
        solver.saddle.solve(qdd, multipliers, &mut solver.stats).ok()?;
        (solver.stats.suspicious_constraints == 0).then_some(values)
    }
}
