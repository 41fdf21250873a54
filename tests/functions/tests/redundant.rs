//! Constraints that repeat others: the motion is that of the mechanism without them, forces are those of least norm.

use std::io;

use qrm_core::Model;
use qrm_sim::analysis::{spectrum, static_equilibrium};
use qrm_sim::batch::{LaneCount, SweepRequest, sweep};
use qrm_sim::integrate::{METHODS, MethodSettings};
use qrm_sim::position::Start;
use qrm_sim::run::{Observer, Outcome, Request, Row, Simulation, Status, simulate};
use qrm_sim::solve::constraint_rank;

fn model() -> &'static Model {
    qrm_functions::MODELS.iter().find(|model| model.description.name == "redundant").expect("a generated scene")
}

/// Parameters of the scene.
const R: f64 = 0.5;
const M: f64 = 3.0;
const MB: f64 = 10.0;
const G: f64 = 9.81;
const A0: f64 = -0.5;

/// The acceleration of the crank: that of a pendulum with the mass of the crank and the beam.
fn pendulum(a: f64) -> f64 {
    -(M / 2.0 + MB) * G * a.cos() / ((M / 3.0 + MB) * R)
}

/// The speed of the crank at an angle, from its energy.
fn speed(a: f64, w0: f64) -> f64 {
    let fall = (M / 2.0 + MB) * G * R * (A0.sin() - a.sin());
    (w0 * w0 + 2.0 * fall / ((M / 3.0 + MB) * R * R)).max(0.0).sqrt()
}

/// Compares rows with the pendulum.
struct Compared {
    w0: f64,
    largest: f64,
}

impl Observer for Compared {
    fn row(&mut self, row: &Row) -> io::Result<()> {
        let Self { w0, largest } = *self;
        let (a, a_dot) = (row.q[0], row.qd[0]);
        assert!((row.qdd[0] - pendulum(a)).abs() < largest, "{} at {}", row.qdd[0], row.t);
        assert!((a_dot.abs() - speed(a, w0)).abs() < largest.sqrt(), "{a_dot} at {}", row.t);
        // Residuals of 1e-12 leave this open where the cranks lie in the line of the beam.
        assert!(row.q[1].abs() < 1e-6, "{} at {}", row.q[1], row.t);
        // The multipliers of least norm share the moment about the first crank as the distances of the rods from it.
        let [first, second, third] = [0, 1, 2].map(|k| row.multipliers[k]);
        let open = (second - 2.0 * first).abs() + (third - 3.0 * first).abs();
        assert!(open < 1e-6 * (1.0 + first.abs()), "{first} {second} {third} at {}", row.t);
        Ok(())
    }
}

fn run(settings: MethodSettings, w0: f64, largest: f64) -> Outcome {
    let request = Request { settings, estimate_error: true, ..Request::default() };
    let mechanism = model().mechanism(&|name| (name == "w0").then_some(w0));
    simulate(&*mechanism, &request, &mut Compared { w0, largest }).expect("it begins")
}

#[test]
fn the_motion_is_that_without_the_constraints_that_repeat() {
    for method in METHODS {
        let outcome = run(MethodSettings::new(method, 1e-9), 1e-3, 1e-6);
        assert!(matches!(outcome.status, Status::Completed), "{}: {:?}", method.name, outcome.status);
        assert_eq!(outcome.rejection_reasons(model().description), [], "{}", method.name);
        let redundancy = outcome.redundancy.expect("two constraints too many");
        assert_eq!((redundancy.rank, redundancy.multipliers, redundancy.outputs), (1, vec![0, 1, 2], vec![0]));
        assert!(outcome.nearest_singular.expect("constraints").fraction() > 0.3);
        assert_eq!(outcome.stats.dependent_constraints, 0);
    }
}

#[test]
fn positions_at_which_branches_cross_are_passed() {
    let outcome = run(MethodSettings::default(), 9.0, 1e-3);
    assert!(matches!(outcome.status, Status::Completed), "{:?}", outcome.status);
    assert!(outcome.nearest_singular.expect("constraints").fraction() < 1e-2);
}

#[test]
fn loose_tolerances_give_no_forces_from_nowhere() {
    let dop853 = METHODS.iter().find(|method| method.name == "dop853").expect("a method");
    let outcome = run(MethodSettings::new(dop853, 1e-4), 1e-3, 1e-2);
    assert!(matches!(outcome.status, Status::Completed), "{:?}", outcome.status);
}

#[test]
fn the_rank_counts_and_not_the_number_of_constraints() {
    let mechanism = model().mechanism(&|_| None);
    assert_eq!(constraint_rank(&*mechanism, 0.0, &[-0.5, 0.0]), 1);
    // The constraints vanish together where the cranks lie in the line of the beam.
    assert_eq!(constraint_rank(&*mechanism, 0.0, &[0.0, 0.0]), 1);
    // All pivots in one place: the constraints say nothing.
    let other = model().mechanism(&|name| (name == "d").then_some(0.0));
    assert_eq!(constraint_rank(&*other, 0.0, &[-0.5, 0.0]), 0);
}

#[test]
fn analyses_know_the_rank() {
    let mechanism = model().mechanism(&|_| None);
    let q = [-0.5, 0.0];
    let held = static_equilibrium(&*mechanism, &[(0, -1.0)], &|_, _| 0.0).expect("a position");
    assert!((held.forces[0] - (M / 2.0 + MB) * G * R * 1.0_f64.cos()).abs() < 1e-9, "{:?}", held.forces);
    assert!((held.multipliers[1] - 2.0 * held.multipliers[0]).abs() < 1e-9, "{:?}", held.multipliers);
    let at_rest = spectrum(&*mechanism, 0.0, &[-std::f64::consts::FRAC_PI_2, 0.0], &[0.0, 0.0]).expect("a spectrum");
    let frequency = ((M / 2.0 + MB) * G / ((M / 3.0 + MB) * R)).sqrt();
    assert!((at_rest.frequency - frequency).abs() < 1e-6, "{at_rest:?} instead of {frequency}");
    assert!(spectrum(&*mechanism, 0.0, &q, &[0.0, 0.0]).expect("a spectrum").smallest_singular_value > 0.1);
}

#[test]
fn designs_and_units_run_as_runs_do() {
    let expected = run(MethodSettings::default(), 1e-3, 1e-6);
    let replace = |_: &str| None;
    let request = SweepRequest { extremes: false, ..SweepRequest::default() };
    let results = sweep(model(), &[&replace as &_, &replace as &_], &request, LaneCount::Most);
    // Lanes do not know of constraints that repeat others.
    assert!(results.iter().all(|result| result.is_alone && result.rejection_reasons.is_empty()), "{results:?}");
    assert!(results.iter().all(|result| (result.q[0] - expected.q[0]).abs() < 1e-8), "{results:?}");
    let mut unit = Simulation::new(model(), &replace, MethodSettings::default(), None).expect("it begins");
    let now = unit.advance(expected.end_time).expect("it goes on");
    assert!((now.q[0] - expected.q[0]).abs() < 1e-12);
}

#[test]
fn a_drive_repeats_no_constraint() {
    let driven = qrm_functions::MODELS.iter().find(|model| model.description.name == "driven").expect("a scene");
    let mechanism = driven.mechanism(&|_| None);
    let (q, _) = qrm_sim::position::assemble(&*mechanism, Start::new(&*mechanism)).expect("a start");
    assert_eq!(constraint_rank(&*mechanism, 0.0, &q), mechanism.description().constraints.len());
}
