//! Times, values of variables and their bounds.

use qrm_core::StateRef;
use qrm_sim::integrate::MethodSettings;
use qrm_sim::run::Simulation;

use super::interface::{
    ERROR, OK, Stepped, Unit, fmi3CompletedIntegratorStep, fmi3ExitInitializationMode, model, token,
};

#[test]
fn values_out_of_bounds_are_refused() {
    let unit = Unit::stepping(&token("quick-return-loaded"));
    for is_running in [false, true] {
        if is_running {
            assert_eq!(unit.initialize(0.0, None), OK);
            assert_eq!(unsafe { fmi3ExitInitializationMode(unit.handle) }, OK, "{}", unit.said());
        }
        for (name, value, why) in [
            ("m4", -5.0, "parameter `m4` cannot be -5: its smallest value is 0"),
            ("J2", -1e-300, "parameter `J2` cannot be -0.000"),
            ("F6", f64::NAN, "parameter `F6` cannot be NaN: it must be finite"),
            ("m4", f64::INFINITY, "parameter `m4` cannot be inf: it must be finite"),
            ("F6", f64::NEG_INFINITY, "parameter `F6` cannot be -inf: it must be finite"),
            ("phi2", 1.0, "`phi2` is a result and cannot be set"),
        ] {
            // The whole call has no effect, in either order.
            for order in [[(name, value), ("g", 9.81)], [("g", 9.81), (name, value)]] {
                assert_eq!(unit.set(&order), ERROR, "{name} = {value}");
                let said = unit.said();
                assert!(said.contains(why), "{said}");
                assert_eq!((unit.get("g"), unit.get("m4"), unit.get("F6")), (0.0, 6.0, 1000.0));
            }
        }
        // The bound itself is allowed, and so are forces below zero.
        assert_eq!(unit.set(&[("m4", 0.0), ("F6", -1000.0)]), OK, "{}", unit.said());
        assert_eq!((unit.get("m4"), unit.get("F6")), (0.0, -1000.0));
        assert_eq!(unit.set(&[("m4", 6.0), ("F6", 1000.0)]), OK);
    }
    assert_eq!(unit.step(0.0, 0.1).status, OK, "{}", unit.said());
}

/// The motion of a scene by itself.
fn alone(scene: &str) -> Simulation {
    Simulation::new(model(scene), &|_| None, MethodSettings::default(), None).expect("a start")
}

#[test]
fn the_scenes_time_begins_at_the_tools_start() {
    // One of these is driven by time, the other knows no time.
    for scene in ["quick-return-driven", "quick-return"] {
        let mut alone = alone(scene);
        let unit = Unit::stepping(&token(scene)).begin(5.0);
        assert!(unit.get("time") == 5.0 && unit.get("phi2").abs() < 1e-100);
        // Steps of the scene, and some between them.
        for i in 0..60 {
            let (t, step) = (5.0 + 0.0125 * f64::from(i), 0.0125);
            let stepped = unit.step(t, step);
            assert_eq!((stepped.status, stepped.flags), (OK, [false; 3]), "{}", unit.said());
            assert!((stepped.last - (t + step)).abs() < 1e-12 && unit.get("time") == stepped.last);
            let expected = alone.advance(t + step - 5.0).expect("a state").clone();
            for (i, name) in ["phi2", "phi4", "phi5"].into_iter().enumerate() {
                assert_eq!(unit.get(name), expected.q[i], "{scene}: {name} at {t}");
                assert_eq!(unit.get(&format!("{name}_ddot")), expected.qdd[i], "{scene}: {name}_ddot at {t}");
            }
        }
        // A time from before the start is none of this motion.
        assert_eq!(unit.step(0.75, 0.1).status, ERROR);
        assert!(unit.said().contains("a step from t = 0.75 s was asked for"));
    }
}

#[test]
fn an_integrator_starts_at_another_time_too() {
    let mut alone = alone("quick-return-driven");
    let unit = Unit::integrated(&token("quick-return-driven")).begin_integration(5.0);
    for i in 0..40 {
        let at = alone.advance(0.0125 * f64::from(i)).expect("a state").clone();
        assert_eq!(unit.place(5.0 + at.t, &[&*at.q, &at.qd].concat()), OK);
        let (status, slopes) = unit.derivatives();
        assert_eq!((status, unit.get("time")), (OK, 5.0 + at.t));
        let expected = [&*at.qd, &at.qdd].concat();
        assert!(slopes.iter().zip(&expected).all(|(a, b)| (a - b).abs() < 1e-9), "{slopes:?} {expected:?}");
        let is_event = |t: f64| {
            assert_eq!(unit.place(t, &[&*at.q, &at.qd].concat()), OK);
            let (mut event, mut terminate) = (false, true);
            assert_eq!(unsafe { fmi3CompletedIntegratorStep(unit.handle, true, &mut event, &mut terminate) }, OK);
            assert!(!terminate);
            event
        };
        // The crank is where it is driven to at this time, and at no other.
        assert!(!is_event(5.0 + at.t) && is_event(5.01 + at.t) && is_event(at.t), "{}", at.t);
    }
}

#[test]
fn a_motion_goes_on_beyond_the_stop_condition() {
    let scene = "quick-return";
    let mut alone = alone(scene);
    let mechanism = model(scene).mechanism(&|_| None);
    let is_over = |unit: &Unit| {
        let get = |names: [&str; 3]| names.map(|name| unit.get(name));
        let (q, qd) = (get(["phi2", "phi4", "phi5"]), get(["phi2_dot", "phi4_dot", "phi5_dot"]));
        let at = StateRef { t: unit.get("time"), q: &q, qd: &qd, qdd: &[0.0; 3], multipliers: &[0.0; 2] };
        mechanism.event(&at).expect("a condition") >= 0.0
    };
    let unit = Unit::stepping(&token(scene)).begin(0.0);
    let (mut before, mut after) = (0, 0);
    for i in 1..=48 {
        let t = 0.05 * f64::from(i);
        let stepped = unit.step(0.05 * f64::from(i - 1), 0.05);
        // The condition is the end of the experiment that the description proposes. It is no event.
        assert_eq!((stepped.status, stepped.flags), (OK, [false; 3]), "{}", unit.said());
        let count = if is_over(&unit) { &mut after } else { &mut before };
        *count += 1;
        assert!((unit.get("phi2") - alone.advance(t).expect("a state").q[0]).abs() < 1e-12);
    }
    assert_eq!((before, after), (35, 13));
}

#[test]
fn the_tools_stop_time_holds() {
    let unit = Unit::stepping(&token("quick-return"));
    for (stop, why) in [(4.9, "cannot stop at 4.9 s"), (f64::NAN, "cannot stop at NaN s")] {
        assert_eq!(unit.initialize(5.0, Some(stop)), ERROR);
        assert!(unit.said().contains(why));
    }
    assert_eq!(unit.initialize(f64::NAN, None), ERROR);
    assert!(unit.said().contains("NaN is no time to start at"));
    assert_eq!(unit.initialize(5.0, Some(5.2)), OK);
    assert_eq!(unsafe { fmi3ExitInitializationMode(unit.handle) }, OK);
    assert_eq!(unit.step(5.0, 0.15).status, OK);
    let stepped = unit.step(5.15, 0.15);
    assert_eq!(stepped, Stepped { status: ERROR, flags: [false; 3], last: unit.get("time") });
    let said = unit.said();
    assert!(said.contains("leads beyond the stop time, 5.2 s"), "{said}");
    assert_eq!(unit.step(5.15, 5.2 - 5.15).status, OK, "{}", unit.said());
}
