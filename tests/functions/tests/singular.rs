//! Positions where a constraint has no gradient, or nearly none.

use std::f64::consts::{PI, TAU};

use qrm_core::Mechanism;
use qrm_sim::run::{End, Request, Status, simulate};
use qrm_sim::solve::Solver;

/// The rocker turns fully; where it points along x, the root in the slot's constraint leaves no gradient.
const PARAMETERS: [(&str, f64); 3] = [("O2A", 0.4), ("BC", 2.0), ("BG5", 1.0)];
/// The rate of the crank, in rad/s.
const RATE: f64 = 4.0;
/// From `scenes/quick-return-loaded.toml`, in m.
const O4O2: f64 = 0.3;
const O4B: f64 = 0.7;
const Y_C: f64 = 0.9;

/// Coordinates and rates when the crank has turned by `past` beyond that position.
fn state(past: f64) -> ([f64; 3], [f64; 3]) {
    let [o2a, bc] = [0, 1].map(|i| PARAMETERS[i].1);
    let phi2 = PI + (O4O2 / o2a).asin() + past;
    let (x, y) = (o2a * phi2.cos(), O4O2 + o2a * phi2.sin());
    let (x_dot, y_dot) = (-o2a * phi2.sin() * RATE, o2a * phi2.cos() * RATE);
    let phi4 = y.atan2(x).rem_euclid(TAU);
    let rate4 = (x * y_dot - y * x_dot) / (x * x + y * y);
    let phi5 = PI - ((Y_C - O4B * phi4.sin()) / bc).asin();
    let rate5 = -O4B * phi4.cos() * rate4 / (bc * phi5.cos());
    ([phi2, phi4, phi5], [RATE, rate4, rate5])
}

fn mechanism(parameters: &[(&str, f64)]) -> Box<dyn Mechanism> {
    let model = qrm_model::MODELS.iter().find(|model| model.description.name == "quick-return-loaded");
    let replace = |name: &str| parameters.iter().find(|(other, _)| *other == name).map(|(_, value)| *value);
    model.expect("a scene").mechanism(&replace)
}

#[test]
fn what_rounding_leaves_of_a_residual_is_accepted() {
    // The block passes the pivot of the rocker at a distance of 3 um.
    let mechanism = mechanism(&[("O2A", 0.299997), ("BC", 1.2)]);
    let request = Request { step: Some(1e-5), end: Some(End::Time(0.7)), ..Request::default() };
    let outcome = simulate(&*mechanism, &request, &mut ()).expect("it begins");
    assert!(matches!(outcome.status, Status::Completed), "{:?}", outcome.status);
    assert!(outcome.stats.stalled_projections > 0 && outcome.stats.largest_stalled_residual.1 < 1e-10);
    assert!(outcome.energy_imbalance < 1e-3, "{} J", outcome.energy_imbalance);
}

#[test]
fn accelerations_at_a_singular_position_are_those_beside_it() {
    let mechanism = mechanism(&PARAMETERS);
    let solve = |past: f64| {
        let (q, qd) = state(past);
        let (mut qdd, mut multipliers) = ([0.0; 3], [0.0; 2]);
        let mut solver = Solver::with_rank(&*mechanism, 2);
        let unknowns = (&mut qdd[..], &mut multipliers[..]);
        solver.robust_accelerations(&*mechanism, 0.0, (&q, &qd), unknowns).unwrap_or_else(|e| panic!("{past}: {e:?}"));
        (qdd, multipliers, solver.stats)
    };
    let (at, forces, stats) = solve(1e-9);
    assert_eq!(stats.suspicious_constraints, 1);
    // The mean of both sides is off by the second order of the distance.
    let ((before, forces_before, stats), (after, forces_after, _)) = (solve(-0.01), solve(0.01));
    assert_eq!(stats.suspicious_constraints, 0);
    for i in 0..3 {
        let mean = (before[i] + after[i]) / 2.0;
        assert!((at[i] - mean).abs() < 1e-3 * (1.0 + mean.abs()), "{i}: {} and {mean}", at[i]);
    }
    // The gradient of the slot changes its sign, and its multiplier grows beyond bounds; the guide's does not.
    let guide = (forces_before[1] + forces_after[1]) / 2.0;
    assert!((forces[1] - guide).abs() < 1e-3 * (1.0 + guide.abs()), "{} and {guide}", forces[1]);
    assert!(forces.iter().all(|force| force.is_finite()));
}
