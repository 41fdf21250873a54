//! Calls in the wrong order, and with pointers, lengths and references that are none.

use std::ptr::{null, null_mut};

use qrm_fmu::InstantiationToken;

use super::interface::*;

/// A call that needs no other argument than the instance.
type Call = (&'static str, fn(&Unit) -> i32);

fn completed(unit: &Unit) -> i32 {
    let (mut event, mut terminate) = (false, false);
    unsafe { fmi3CompletedIntegratorStep(unit.handle, true, &mut event, &mut terminate) }
}

fn states(unit: &Unit) -> i32 {
    unsafe { fmi3GetContinuousStates(unit.handle, [0.0; 6].as_mut_ptr(), 6) }
}

const CALLS: [Call; 15] = [
    ("set", |unit| unit.set(&[("F6", 900.0)])),
    ("enter initialization", |unit| unit.initialize(0.0, None)),
    ("exit initialization", |unit| unsafe { fmi3ExitInitializationMode(unit.handle) }),
    ("do step", |unit| unit.step(0.0, 0.01).status),
    ("enter event", |unit| unsafe { fmi3EnterEventMode(unit.handle) }),
    ("update", |unit| unit.update().0),
    ("enter continuous", |unit| unsafe { fmi3EnterContinuousTimeMode(unit.handle) }),
    ("set time", |unit| unsafe { fmi3SetTime(unit.handle, 0.0) }),
    ("set states", |unit| {
        let states = [0.0, 1.0, 2.6, 1.0, 0.0, 0.0];
        unsafe { fmi3SetContinuousStates(unit.handle, states.as_ptr(), 6) }
    }),
    ("get states", states),
    ("derivatives", |unit| unit.derivatives().0),
    ("completed step", completed),
    ("enter step mode", |unit| unsafe { fmi3EnterStepMode(unit.handle) }),
    ("terminate", |unit| unsafe { fmi3Terminate(unit.handle) }),
    ("reset", |unit| unsafe { fmi3Reset(unit.handle) }),
];

/// A state, an instance in it, and the calls that it allows.
type InState = (&'static str, fn() -> Unit, &'static [&'static str]);

/// Instances in each of their states.
fn instances() -> Vec<InState> {
    fn stepping() -> Unit {
        Unit::stepping(&token("quick-return"))
    }
    fn integrated() -> Unit {
        Unit::integrated(&token("quick-return"))
    }
    fn initializing(unit: Unit) -> Unit {
        assert_eq!(unit.initialize(0.0, None), OK);
        unit
    }
    fn terminated(unit: Unit) -> Unit {
        assert_eq!(unsafe { fmi3Terminate(unit.handle) }, OK);
        unit
    }
    let values = &["exit initialization", "set", "get states", "derivatives", "reset"];
    vec![
        ("instantiated", stepping, &["set", "enter initialization", "reset"]),
        ("instantiated", integrated, &["set", "enter initialization", "reset"]),
        ("in initialization mode", || initializing(stepping()), &["exit initialization", "set", "reset"]),
        ("in initialization mode", || initializing(integrated()), values),
        ("in step mode", || stepping().begin(0.0), &["set", "do step", "terminate", "reset"]),
        (
            "in event mode",
            || integrated().begin(0.0),
            &["set", "update", "enter continuous", "set time", "get states", "derivatives", "terminate", "reset"],
        ),
        (
            "in continuous-time mode",
            || integrated().begin_integration(0.0),
            &[
                "set",
                "enter event",
                "set time",
                "set states",
                "get states",
                "derivatives",
                "completed step",
                "terminate",
                "reset",
            ],
        ),
        ("terminated", || terminated(stepping().begin(0.0)), &["reset"]),
        ("terminated", || terminated(integrated().begin(0.0)), &["get states", "derivatives", "reset"]),
    ]
}

#[test]
fn calls_in_a_wrong_state_are_refused() {
    for (name, make, allowed) in instances() {
        for (call, work) in CALLS {
            let unit = make();
            let status = work(&unit);
            let said = unit.said();
            assert_eq!(status, if allowed.contains(&call) { OK } else { ERROR }, "{call} {name}: {said}");
            assert_eq!(said.is_empty(), status == OK, "{call} {name}: {said}");
            let is_absent = call == "enter step mode";
            let is_of_other = said.contains("the instance is one of");
            let is_in_words = said.contains(&format!("not possible while the instance is {name}"));
            assert!(status == OK || is_absent || is_of_other || is_in_words, "{call} {name}: {said}");
            // Whatever was refused, the instance can be used again.
            assert_eq!(unsafe { fmi3Reset(unit.handle) }, OK);
            let unit = unit.begin(0.0);
            assert_eq!(unit.get("phi2"), 0.0);
        }
    }
}

#[test]
fn without_an_instance_nothing_happens() {
    let (mut flag, mut value, mut count, mut state) = (false, 0.0, 0, null_mut());
    let flag: *mut bool = &mut flag;
    let statuses = unsafe {
        [
            fmi3ExitInitializationMode(NOTHING),
            fmi3EnterEventMode(NOTHING),
            fmi3EnterContinuousTimeMode(NOTHING),
            fmi3EnterStepMode(NOTHING),
            fmi3Terminate(NOTHING),
            fmi3Reset(NOTHING),
            fmi3GetFloat64(NOTHING, &0, 1, &mut value, 1),
            fmi3SetFloat64(NOTHING, &0, 1, &value, 1),
            fmi3GetFMUState(NOTHING, &mut state),
            fmi3SetFMUState(NOTHING, state),
            fmi3FreeFMUState(NOTHING, &mut state),
            fmi3UpdateDiscreteStates(NOTHING, flag, flag, flag, flag, flag, &mut value),
            fmi3CompletedIntegratorStep(NOTHING, true, flag, flag),
            fmi3SetTime(NOTHING, 0.0),
            fmi3SetContinuousStates(NOTHING, &value, 1),
            fmi3GetContinuousStates(NOTHING, &mut value, 1),
            fmi3GetContinuousStateDerivatives(NOTHING, &mut value, 1),
            fmi3GetNominalsOfContinuousStates(NOTHING, &mut value, 1),
            fmi3GetEventIndicators(NOTHING, &mut value, 1),
            fmi3GetNumberOfContinuousStates(NOTHING, &mut count),
            fmi3GetNumberOfEventIndicators(NOTHING, &mut count),
        ]
    };
    assert_eq!(statuses, [ERROR; 21]);
}

#[test]
fn wrong_lengths_pointers_and_references_are_refused() {
    let unit = Unit::integrated(&token("quick-return")).begin_integration(0.0);
    let (mut values, references) = ([0.0; 8], [unit.reference("F6"), 4_000_000_000]);
    let (room, handle) = (values.as_mut_ptr(), unit.handle);
    let of = references.as_ptr();
    let refused = |status: i32, why: &str| {
        let said = unit.said();
        assert_eq!(status, ERROR, "{why}");
        assert!(said.contains(why), "{said}");
    };
    unsafe {
        refused(fmi3GetFloat64(handle, of, 2, room, 2), "there is no variable with reference 4000000000");
        refused(fmi3SetFloat64(handle, of, 2, room, 2), "there is no variable with reference 4000000000");
        refused(fmi3GetFloat64(handle, of, 1, room, 2), "2 values were given where there are 1");
        refused(fmi3SetFloat64(handle, of, 2, room, 1), "1 values were given where there are 2");
        refused(fmi3GetFloat64(handle, null(), 1, room, 1), "1 values were given where there are 0");
        refused(fmi3SetFloat64(handle, of, 1, null(), 1), "0 values were given where there are 1");
        refused(fmi3GetFloat64(handle, of, 1, null_mut(), 1), "0 values were given where there are 1");
        refused(fmi3GetInt32(handle, of, 1, &mut 0, 1), "all variables are of the type Float64");
        for count in [0, 5, 7] {
            let why = &format!("{count} values were given where there are 6");
            refused(fmi3SetContinuousStates(handle, room, count), why);
            refused(fmi3GetContinuousStates(handle, room, count), why);
            refused(fmi3GetNominalsOfContinuousStates(handle, room, count), why);
        }
        let none = "0 values were given where there are 6";
        refused(fmi3SetContinuousStates(handle, null(), 6), none);
        refused(fmi3GetContinuousStates(handle, null_mut(), 6), none);
        refused(fmi3GetContinuousStateDerivatives(handle, null_mut(), 6), none);
        refused(fmi3GetNominalsOfContinuousStates(handle, null_mut(), 6), none);
        refused(fmi3GetEventIndicators(handle, room, 1), "1 values were given where there are 0");
        refused(fmi3GetNumberOfContinuousStates(handle, null_mut()), "there is no place for the result");
        refused(fmi3GetNumberOfEventIndicators(handle, null_mut()), "there is no place for the result");
        // Nothing is asked for: nothing is wrong.
        assert_eq!(fmi3GetFloat64(handle, null(), 0, null_mut(), 0), OK);
        assert_eq!(fmi3SetFloat64(handle, null(), 0, null(), 0), OK);
        assert_eq!(fmi3GetEventIndicators(handle, null_mut(), 0), OK);
        assert_eq!(fmi3GetNominalsOfContinuousStates(handle, room, 6), OK);
        // Flags that the tool does not want are not written.
        assert_eq!(fmi3CompletedIntegratorStep(handle, true, null_mut(), null_mut()), OK);
    }
    assert_eq!((values[..6].to_vec(), unit.get("F6")), (vec![1.0; 6], 1000.0));
    assert_eq!(unit.said(), "");
}

#[test]
fn steps_that_are_none_are_refused() {
    let unit = Unit::stepping(&token("quick-return")).begin(0.0);
    assert_eq!(unit.step(0.0, 0.1).status, OK);
    let before = unit.get("phi2");
    for (t, step, why) in [
        (0.0, 0.1, "was asked for, but the motion has come to 0.1 s"),
        (0.3, 0.1, "was asked for, but the motion has come to 0.1 s"),
        (f64::NAN, 0.1, "was asked for, but the motion has come to 0.1 s"),
        (0.1, -0.1, "a step cannot be -0.1 s long"),
        (0.1, f64::NAN, "a step cannot be NaN s long"),
        (0.1, f64::INFINITY, "cannot go on to inf s"),
        (0.1, 1e300, "cannot go on to"),
    ] {
        let stepped = unit.step(t, step);
        let said = unit.said();
        assert_eq!((stepped.status, stepped.flags, stepped.last), (ERROR, [false; 3], 0.1), "{said}");
        assert!(said.contains(why), "{said}");
    }
    assert_eq!(unit.get("phi2"), before);
    assert_eq!(unit.step(0.1, 0.0).status, OK);
    assert_eq!(unit.step(0.1, 0.1).status, OK, "{}", unit.said());
}

#[test]
fn a_description_of_another_scene_or_of_another_text_is_refused() {
    let own = token("quick-return");
    let renamed = InstantiationToken { scene: "quick-return-2".to_owned(), ..own.clone() };
    let edited = InstantiationToken { digest: own.digest ^ 1, ..own };
    for token in [renamed, edited] {
        let said = Unit::refused(&token).join("\n");
        assert!(said.contains(&format!("does not hold the scene `{}`", token.scene)), "{said}");
    }
}
