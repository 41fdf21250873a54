//! Accelerations at singular positions, where the constraints say too little: interpolated across them.

use qrm_core::Mechanism;

use super::accelerations::Solver;
use super::matrix::largest;
use super::projection::{Projection, ProjectionTolerance};
use super::stats::SolverStats;

/// Where the Schur complement has a smaller condition, the position may be next to a singular one: rounding errors of
/// positions are magnified by one over the condition.
pub(super) const SUSPICIOUS: f64 = 1e-4;

/// Distances of positions beside a singular one, in rad or m: rounding errors grow with the square of their inverse,
/// and errors of the interpolation with their eighth power.
const DISTANCES: [f64; 4] = [5e-2, 1e-2, 1e-3, 1e-4];
/// Rounding errors of closures, in m or rad, with what corrections make of them.
const ROUNDING: f64 = 2e-15;
/// The positions that the interpolation goes through.
const NODES: usize = 8;
/// The places that are tried on each side, in distances.
const PLACES: i32 = 6;
/// The place on each side of which the larger condition tells what it is away from the singular position.
const AWAY: i32 = 4;
/// Away from the singular position the condition is at least so many times that of the position itself.
const BETTER: f64 = 1.5;
/// Places with a smaller part of the condition away are too near the singular position.
const NEAR: f64 = 0.02;

/// Replaces accelerations and multipliers near a singular position, where the Schur complement has the given condition:
/// by those at the position projected onto the constraints, or by the polynomial through those at projected positions on
/// both sides, along the rates, whichever is more precise. They stay as they are where constraints say too little
/// everywhere, and at rest.
#[cold]
pub(super) fn interpolate(
    mechanism: &dyn Mechanism,
    (solver, condition): (&mut Solver, f64),
    t: f64,
    (q, qd): (&[f64], &[f64]),
    (qdd, multipliers): (&mut [f64], &mut [f64]),
) {
    let speed = largest(qd).1;
    if !(speed > 0.0 && speed.is_finite()) {
        return;
    }
    let mut motion = Motion { mechanism, solver, t, q, qd, duration: 0.0 };
    // Coordinates and rates that meet the constraints have the smallest errors.
    let projected = motion.node(0);
    let projected =
        projected.map(|node| Values { error: ROUNDING * speed * speed / node.condition, values: node.values });
    let interpolated = DISTANCES.into_iter().filter_map(|distance| {
        motion.duration = distance / speed;
        motion.interpolated(condition)
    });
    if let Some(best) = projected.into_iter().chain(interpolated).min_by(|a, b| a.error.total_cmp(&b.error)) {
        qdd.copy_from_slice(&best.values[..q.len()]);
        multipliers.copy_from_slice(&best.values[q.len()..]);
    }
}

/// The motion through a position, in durations in which its fastest coordinate moves by a distance.
struct Motion<'a> {
    mechanism: &'a dyn Mechanism,
    solver: &'a mut Solver,
    t: f64,
    q: &'a [f64],
    qd: &'a [f64],
    duration: f64,
}

/// A position of the motion.
struct Node {
    /// Its place.
    place: f64,
    /// The condition of its Schur complement.
    condition: f64,
    /// Its accelerations and multipliers.
    values: Vec<f64>,
}

/// Accelerations and multipliers.
struct Values {
    values: Vec<f64>,
    /// The estimated error of the accelerations.
    error: f64,
}

impl Motion<'_> {
    /// The accelerations and multipliers between positions on both sides; `None` if the constraints say no more there.
    fn interpolated(&mut self, condition: f64) -> Option<Values> {
        let mut ends = [self.node(-AWAY), self.node(AWAY)];
        let away = ends.iter().flatten().fold(0.0, |away: f64, node| away.max(node.condition));
        if !(away >= BETTER * condition) {
            return None;
        }
        let mut nodes = Vec::with_capacity(NODES);
        for place in 1..=PLACES {
            for (end, sign) in ends.iter_mut().zip([-1, 1]) {
                if nodes.len() < NODES {
                    let node = if place == AWAY { end.take() } else { self.node(sign * place) };
                    nodes.extend(node.filter(|node| node.condition >= NEAR * away));
                }
            }
        }
        (nodes.len() == NODES).then(|| self.between(&nodes))
    }

    /// The accelerations and multipliers at a place.
    fn node(&mut self, place: i32) -> Option<Node> {
        let Self { mechanism, solver, q, qd, duration, .. } = self;
        let duration = f64::from(place) * *duration;
        solver.stats = SolverStats::default();
        // Constraints that depend on time are met at the time when the motion is there.
        let t = if mechanism.is_driven() { self.t + duration } else { self.t };
        let mut position: Vec<f64> = q.iter().zip(*qd).map(|(q, v)| q + duration * v).collect();
        let mut rates = qd.to_vec();
        solver.factor_mass(*mechanism, &position);
        let projection = (Projection::Mass, ProjectionTolerance::default());
        solver.project(*mechanism, projection, t, &mut position, &mut rates).ok()?;
        let (mut values, mut multipliers) = (vec![0.0; q.len()], vec![0.0; solver.weights.len()]);
        solver.saddle.dynamics.evaluate(*mechanism, t, &position, &rates);
        solver.saddle.solve(&mut values, &mut multipliers, &mut solver.stats).ok()?;
        values.append(&mut multipliers);
        let condition = solver.saddle.schur_factors.condition();
        (solver.stats.suspicious_constraints == 0).then_some(Node { place: place.into(), condition, values })
    }

    /// The polynomial through nodes, at place zero. Its error is the difference to that without the last node.
    fn between(&self, nodes: &[Node]) -> Values {
        let value =
            |nodes: &[Node], i: usize| -> f64 { nodes.iter().map(|node| weight(nodes, node) * node.values[i]).sum() };
        let values: Vec<f64> = (0..nodes[0].values.len()).map(|i| value(nodes, i)).collect();
        let difference = |i: usize| (values[i] - value(&nodes[..NODES - 1], i)).abs();
        let error = (0..self.q.len()).map(difference).fold(0.0, f64::max);
        Values { values, error }
    }
}

/// The weight of a node in the polynomial through all of them, at place zero.
fn weight(nodes: &[Node], node: &Node) -> f64 {
    let others = nodes.iter().map(|other| other.place).filter(|place| *place != node.place);
    others.map(|place| place / (place - node.place)).product()
}
