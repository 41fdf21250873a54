//! Friction by the forces in joints, and a spline, in compiled steps of every kind.
use qrm_core::{Mechanism, Model, ParameterOverrides};
use qrm_functions::MODELS;
use qrm_sim::batch::{LaneCount, SweepRequest, sweep};
use qrm_sim::integrate::{MethodSettings, method_named};
use qrm_sim::run::{End, Request, simulate};
use qrm_sim::solve::Solver;

fn model() -> &'static Model {
    MODELS.iter().find(|model| model.description.name == "rubbing").expect("a generated scene")
}

fn end(mechanism: &dyn Mechanism, method: &str, tolerance: f64) -> Vec<f64> {
    let settings = MethodSettings::new(method_named(method).expect("a method"), tolerance);
    let outcome = simulate(mechanism, &Request { settings, ..Request::default() }, &mut ()).expect("a start");
    [outcome.q, outcome.qd].concat()
}

#[track_caller]
fn near(what: &str, found: &[f64], expected: &[f64], allowed: f64) {
    for (found, expected) in found.iter().zip(expected) {
        assert!((found - expected).abs() <= allowed, "{what}: {found:?} instead of {expected:?}");
    }
}

#[test]
fn every_method_comes_to_the_same_end() {
    let mechanism = model().mechanism(&|_| None);
    let exact = end(&*mechanism, "dop853", 1e-13);
    // Each reversal of the slider is a steep stretch. `gauss` steps over it with large steps; its own estimate of
    // the error is as large as the difference.
    for (method, tolerance, allowed) in [("rk4", 1e-9, 1e-3), ("dopri5", 1e-10, 1e-6), ("gauss", 1e-10, 1e-4)] {
        near(method, &end(&*mechanism, method, tolerance), &exact, allowed);
    }
}

#[test]
fn kernel_and_plain_functions_agree_on_accelerations() {
    let mechanism = model().mechanism(&|_| None);
    let mut solver = Solver::new(&*mechanism);
    for turn in 0..60 {
        let phi = 0.1 * f64::from(turn) - 2.0;
        // The rod follows the crank.
        let rod = -(0.1 * phi.sin() / 0.35).asin();
        let (speed, of_rod) = (12.0, -0.1 * phi.cos() * 12.0 / (0.35 * rod.cos()));
        let (q, qd) = ([phi, rod], [speed, of_rod]);
        let (mut kernel, mut plain) = (([0.0; 2], [0.0; 1]), ([0.0; 2], [0.0; 1]));
        assert!(mechanism.accelerations(0.0, &q, &qd, &mut kernel.0, &mut kernel.1), "the kernel suits {phi}");
        let made = solver.robust_accelerations(&*mechanism, 0.0, (&q, &qd), (&mut plain.0, &mut plain.1));
        assert!(made.is_ok(), "{made:?} at {phi}");
        near("accelerations", &kernel.0, &plain.0, 1e-10);
        near("multipliers", &kernel.1, &plain.1, 1e-10);
    }
}

#[test]
fn designs_in_lanes_are_runs() {
    let set = [0.0, 0.02, 0.05, 0.08, 0.1, 0.12, 0.15, 0.2, 0.25];
    let replaces = set.map(|mu| move |name: &str| (name == "mu").then_some(mu));
    let designs: Vec<ParameterOverrides> = replaces.iter().map(|replace| replace as ParameterOverrides).collect();
    let settings = MethodSettings::new(method_named("dop853").expect("a method"), 1e-11);
    let request = SweepRequest { settings, end: Some(End::Time(0.5)), ..SweepRequest::default() };
    let found = sweep(model(), &designs, &request, LaneCount::Most);
    for (mu, result) in set.iter().zip(found) {
        assert!(result.status.is_ok(), "{:?}", result.status);
        assert!(!result.is_alone || !crate::processor::has_lanes_of_eight(), "mu = {mu}");
        let mechanism = model().mechanism(&|name| (name == "mu").then_some(*mu));
        near(&format!("mu = {mu}"), &[result.q, result.qd].concat(), &end(&*mechanism, "dop853", 1e-12), 1e-7);
    }
}
