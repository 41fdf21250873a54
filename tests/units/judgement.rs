//! A motion under way is judged as a run is.

use qrm_sim::integrate::{GAUSS, METHODS, MethodSettings};
use qrm_sim::run::{End, RejectionReason, Request, Simulation, simulate};

use super::interface::{ERROR, OK, Unit, model, token};

const SCENE: &str = "quick-return-loaded";
const STEP: f64 = 1e-3;
const ROWS: u32 = 900;

fn time(row: u32) -> f64 {
    f64::from(row) * STEP
}

#[test]
fn a_motion_has_the_doubts_of_a_run() {
    let model = model(SCENE);
    for j2 in [100.0, 0.0] {
        let replace = |name: &str| (name == "J2").then_some(j2);
        let settings = MethodSettings::default();
        let end = Some(End::Time(time(ROWS)));
        let request = Request { settings, end, estimate_error: true, ..Request::default() };
        let outcome = simulate(&*model.mechanism(&replace), &request, &mut ()).expect("a run");
        let of_run = outcome.rejection_reasons(model.description);
        let mut simulation =
            Simulation::new(model, &replace, settings, None).and_then(Simulation::watched).expect("a start");
        for row in 1..=ROWS {
            simulation.advance(time(row)).expect("a row");
            assert!(
                j2 == 0.0 || simulation.rejection_reasons().is_empty(),
                "row {row}: {:?}",
                simulation.rejection_reasons()
            );
        }
        let rejection_reasons = simulation.rejection_reasons();
        assert_eq!(of_run.is_empty(), j2 != 0.0, "{of_run:?}");
        assert_eq!(of_run.len(), rejection_reasons.len(), "{of_run:?} {rejection_reasons:?}");
        for pair in of_run.iter().zip(&rejection_reasons) {
            // The last rows of a run close its balance.
            let is_near = |a: f64, b: f64| (a - b).abs() <= 1e-2 * a;
            assert!(
                match pair {
                    (RejectionReason::Energy { imbalance: a, .. }, RejectionReason::Energy { imbalance: b, .. }) =>
                        is_near(*a, *b),
                    (of_run, reason) => of_run == reason,
                },
                "{pair:?}"
            );
        }
        // Without a watch there is nothing to judge by.
        let mut bare = Simulation::new(model, &replace, settings, None).expect("a start");
        bare.advance(time(ROWS)).expect("the end");
        assert!(bare.rejection_reasons().is_empty() && bare.now() == simulation.now());
    }
}

/// Steps until the unit refuses one: the time it came to, and what it said.
fn refused(unit: &Unit, step: f64, mut before: impl FnMut(f64)) -> (f64, String) {
    let mut t = 0.0;
    for i in 1..10_000 {
        before(t);
        let stepped = unit.step(t, step);
        if stepped.status != OK {
            assert_eq!((stepped.status, stepped.flags, stepped.last), (ERROR, [false; 3], unit.get("time")));
            return (stepped.last, unit.said());
        }
        t = f64::from(i) * step;
        if t > time(ROWS) {
            break;
        }
    }
    (t, unit.said())
}

#[test]
fn a_unit_off_by_too_much_says_so() {
    let token = token(SCENE);
    let mut ends = Vec::new();
    for step in [STEP, 0.01, 0.0131] {
        let unit = Unit::stepping(&token);
        assert_eq!(unit.set(&[("J2", 0.0)]), OK);
        let unit = unit.begin(0.0);
        let (t, said) = refused(&unit, step, |_| ());
        assert!(t < time(ROWS), "no step was refused");
        assert!(said.contains("do not trust the numbers: ") && said.contains("`qrm export-fmu`"), "{said}");
        assert!(said.contains("use a shorter step, or a method"), "{said}");
        // The step was not made, and trying again does not make it better.
        let at = unit.get("phi2");
        assert_eq!(unit.step(t, step).status, ERROR);
        assert_eq!((unit.get("phi2"), unit.get("time")), (at, t));
        ends.push((t, step));
    }
    let first = ends[0].0;
    assert!(ends.iter().all(|(t, step)| *t <= first && first < t + step + STEP), "{ends:?}");
    // The same in units with a step that suffices, and in the scene as it is.
    let unit = Unit::stepping(&token).begin(0.0);
    assert!(refused(&unit, 0.01, |_| ()).0 > time(ROWS));
}

#[test]
fn a_method_with_a_tolerance_is_judged_too() {
    for method in METHODS.iter().filter(|method| method.is_adaptive()) {
        // With and without a torque that changes at every row or between them.
        for (tolerance, torque, step) in [(1e-9, 0.0, 0.01), (1e-9, 5.0, 1e-3), (1e-9, 5.0, 0.0131), (1.0, 0.0, 0.01)] {
            let mut token = token(SCENE);
            token.settings = MethodSettings::new(method, tolerance);
            let unit = Unit::stepping(&token);
            assert_eq!(unit.set(&[("J2", 0.0)]), OK);
            let unit = unit.begin(0.0);
            let (t, said) = refused(&unit, step, |t| {
                if torque != 0.0 {
                    assert_eq!(unit.set(&[("T2", torque * (3.0 * t).sin())]), OK);
                }
            });
            // The Gauss method takes such a tolerance for 1e-6.
            let is_good = tolerance < 1e-3 || *method == GAUSS;
            assert_eq!(t > time(ROWS), is_good, "{} {tolerance} {torque} {step}: {t} {said}", method.name);
            assert!(is_good || said.contains("use a smaller tolerance"), "{said}");
        }
    }
}

#[test]
fn inputs_that_change_do_not_hide_errors() {
    let token = token(SCENE);
    // Where an input changes at every step, no part of the motion is longer than a step.
    for step in [STEP, 0.01] {
        let torque = |t: f64| [("T2", 5.0 * (3.0 * t).sin())];
        let unit = Unit::stepping(&token).begin(0.0);
        let (t, said) = refused(&unit, step, |t| assert_eq!(unit.set(&torque(t)), OK));
        assert!(t > time(ROWS), "{t} {said}");
        let unit = Unit::stepping(&token);
        assert_eq!(unit.set(&[("J2", 0.0)]), OK);
        let unit = unit.begin(0.0);
        let (t, said) = refused(&unit, step, |t| assert_eq!(unit.set(&torque(t)), OK));
        assert!(t < time(ROWS) && said.contains("do not trust"), "{t} {said}");
    }
}

#[test]
fn a_mechanism_at_rest_is_trusted() {
    // Rounding errors move it, and there is no energy beside theirs.
    let values = [("F6", 0.0), ("w0", 0.0), ("k", 2e6)];
    let model = model(SCENE);
    let replace = |name: &str| values.iter().find(|(own, _)| *own == name).map(|(_, value)| *value);
    let request = Request { end: Some(End::Time(time(ROWS))), estimate_error: true, ..Request::default() };
    let outcome = simulate(&*model.mechanism(&replace), &request, &mut ()).expect("a run");
    assert_eq!(outcome.rejection_reasons(model.description), []);
    assert!(outcome.largest_kinetic_energy < 1e-20, "{outcome:?}");
    let unit = Unit::stepping(&token(SCENE));
    assert_eq!(unit.set(&values), OK);
    let (t, said) = refused(&unit.begin(0.0), STEP, |_| ());
    assert!(t > time(ROWS), "{t} {said}");
}

#[test]
fn a_controlled_motion_is_trusted_however_unstable_it_is_by_itself() {
    // A spring pushes outward.
    for step in [STEP, 5e-3] {
        let unit = Unit::stepping(&token(SCENE));
        assert_eq!(unit.set(&[("k", -2e6), ("F6", 0.0), ("w0", 0.0)]), OK);
        let unit = unit.begin(0.0);
        let mut farthest = 0.0_f64;
        for i in 0..(2.0 / step).round() as u32 {
            let t = f64::from(i) * step;
            let angle = unit.get("phi2") - 0.05 * (3.0 * t).sin();
            let rate = unit.get("phi2_dot") - 0.15 * (3.0 * t).cos();
            farthest = farthest.max(angle.abs());
            assert_eq!(unit.set(&[("T2", -6e5 * angle - 1.6e4 * rate)]), OK);
            assert_eq!(unit.step(t, step).status, OK, "{}", unit.said());
        }
        assert!(farthest < 0.05, "{farthest}");
        // Without the controller it runs away.
        assert_eq!(unit.set(&[("T2", 0.0)]), OK);
        assert_eq!(unit.step(2.0, 0.2).status, OK, "{}", unit.said());
        assert!((unit.get("phi2") - 0.05 * 6.0_f64.sin()).abs() > 0.2, "{}", unit.get("phi2"));
    }
}
