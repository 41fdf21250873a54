//! Units of which the tool integrates.

use super::interface::{
    DISCARD, ERROR, OK, Unit, fmi3CompletedIntegratorStep, fmi3EnterContinuousTimeMode, fmi3EnterEventMode,
    fmi3ExitInitializationMode, fmi3GetContinuousStateDerivatives, fmi3Terminate, token,
};

#[test]
fn a_state_without_derivatives_is_discarded() {
    // The crank is as long as the frame: where it points down, the block comes to the pivot of the rocker.
    let mut token = token("quick-return-loaded");
    token.replaced = vec![("O2A".to_owned(), 0.3), ("BC".to_owned(), 1.2)];
    let unit = Unit::integrated(&token).begin_integration(0.0);
    let good = unit.states();
    let (status, expected) = unit.derivatives();
    assert_eq!(status, OK);
    let mut at_pivot = good.clone();
    at_pivot[0] = -std::f64::consts::FRAC_PI_2;
    let mut too_fast = good.clone();
    too_fast[3] = 1e200;
    for states in [at_pivot, too_fast] {
        assert_eq!(unit.place(0.1, &states), OK);
        let (status, slopes) = unit.derivatives();
        assert_eq!(status, DISCARD, "{slopes:?}");
        let said = unit.said();
        assert!(said.contains("not finite"), "{said}");
        // Values of variables are not there either, and the state is what was set.
        assert_eq!(unit.try_get("energy").0, DISCARD);
        assert_eq!((unit.states(), unit.get("time")), (states, 0.1));
        // No other state is tried at the end of a step.
        let (mut event, mut terminate) = (false, false);
        let end = unsafe { fmi3CompletedIntegratorStep(unit.handle, true, &mut event, &mut terminate) };
        assert_eq!(end, ERROR);
        // The tool goes back, and on.
        assert_eq!(unit.place(0.0, &good), OK);
        assert_eq!(unit.derivatives(), (OK, expected.clone()));
        unit.said();
    }
}

#[test]
fn what_no_shorter_step_mends_is_an_error() {
    let unit = Unit::integrated(&token("quick-return-loaded")).begin_integration(0.0);
    let good = unit.states();
    // What is not finite is refused where it is set.
    for i in 0..good.len() {
        for value in [f64::NAN, f64::INFINITY] {
            let mut states = good.clone();
            states[i] = value;
            assert_eq!(unit.place(0.0, &states), ERROR);
            assert!(unit.said().contains("time or a state is not finite"));
        }
    }
    assert_eq!(unit.place(f64::NAN, &good), ERROR);
    assert!(unit.said().contains("time or a state is not finite"));
    assert_eq!((unit.states(), unit.get("time")), (good.clone(), 0.0));
    // Wrong numbers of derivatives.
    let mut room = [0.0; 8];
    for count in [0, 5, 7] {
        assert_eq!(unsafe { fmi3GetContinuousStateDerivatives(unit.handle, room.as_mut_ptr(), count) }, ERROR);
        assert!(unit.said().contains(&format!("{count} values were given where there are 6")));
    }
    // Nothing has a mass: the accelerations are not determined at any state.
    let masses = ["m3", "m4", "m5", "m6", "J2", "J4", "J5"];
    assert_eq!(unit.set(&masses.map(|name| (name, 0.0))), OK);
    let (status, _) = unit.derivatives();
    let said = unit.said();
    assert_eq!(status, ERROR, "{said}");
    assert!(said.contains("no mass resists") && said.contains("help: give the bodies"), "{said}");
    assert_eq!(unit.set(&masses.map(|name| (name, 1.0))), OK);
    assert_eq!(unit.derivatives().0, OK, "{}", unit.said());
    // The same before the start.
    let unit = Unit::integrated(&token("quick-return-loaded"));
    assert_eq!(unit.set(&masses.map(|name| (name, 0.0))), OK);
    assert_eq!(unit.initialize(0.0, None), OK);
    assert_eq!(unsafe { fmi3ExitInitializationMode(unit.handle) }, ERROR);
    assert!(unit.said().contains("no mass resists"));
    assert_eq!(unit.derivatives().0, ERROR);
}

#[test]
fn loops_that_were_opened_are_an_event() {
    let unit = Unit::integrated(&token("quick-return")).begin_integration(5.0);
    let mut states = unit.states();
    states[1] += 1e-6;
    assert_eq!(unit.place(5.001, &states), OK);
    let (mut event, mut terminate) = (false, true);
    assert_eq!(unsafe { fmi3CompletedIntegratorStep(unit.handle, true, &mut event, &mut terminate) }, OK);
    assert_eq!((event, terminate), (true, false));
    assert_eq!(unsafe { fmi3EnterEventMode(unit.handle) }, OK);
    assert_eq!(unit.update(), (OK, true));
    assert!(unit.states() != states && unit.get("time") == 5.001);
    assert_eq!(unit.update(), (OK, false));
    assert_eq!(unsafe { fmi3EnterContinuousTimeMode(unit.handle) }, OK);
    assert_eq!(unsafe { fmi3Terminate(unit.handle) }, OK);
}
