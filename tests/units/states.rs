//! States that are kept and put back.

use std::ffi::c_void;
use std::ptr::{null, null_mut};

use super::interface::{
    ERROR, OK, Unit, fmi3DeserializeFMUState, fmi3FreeFMUState, fmi3GetFMUState, fmi3SerializedFMUStateSize,
    fmi3SetFMUState, token,
};

fn kept(unit: &Unit) -> *mut c_void {
    let mut state = null_mut();
    assert_eq!(unsafe { fmi3GetFMUState(unit.handle, &mut state) }, OK, "{}", unit.said());
    assert!(!state.is_null());
    state
}

#[test]
fn a_state_is_gone_back_to() {
    let token = token("quick-return-loaded");
    let unit = Unit::stepping(&token).begin(5.0);
    assert_eq!(unit.step(5.0, 0.1).status, OK);
    let mut state = kept(&unit);
    let later = || {
        assert_eq!(unit.step(5.1, 0.2).status, OK, "{}", unit.said());
        (unit.get("phi2"), unit.get("energy"))
    };
    let first = later();
    assert_eq!(unit.set(&[("F6", 2000.0)]), OK);
    assert_eq!(unsafe { fmi3SetFMUState(unit.handle, state) }, OK);
    assert_eq!(unit.get("F6"), 1000.0);
    assert_eq!(later(), first);
    // Another instance of the same unit takes it too: its life was the same.
    let other = Unit::stepping(&token);
    assert_eq!(unsafe { fmi3SetFMUState(other.handle, state) }, OK, "{}", other.said());
    assert_eq!(other.step(5.1, 0.2).status, OK, "{}", other.said());
    assert_eq!(other.get("phi2"), first.0);
    // A state is overwritten in its place.
    let place = state;
    assert_eq!(unsafe { fmi3GetFMUState(unit.handle, &mut state) }, OK);
    assert_eq!(state, place);
    assert_eq!(unsafe { fmi3SetFMUState(other.handle, state) }, OK);
    assert_eq!(other.get("time"), unit.get("time"));
    assert_eq!(unsafe { fmi3FreeFMUState(unit.handle, &mut state) }, OK);
    assert!(state.is_null());
    // There is nothing to free any more.
    assert_eq!(unsafe { fmi3FreeFMUState(unit.handle, &mut state) }, OK);
    assert_eq!(unsafe { fmi3FreeFMUState(unit.handle, null_mut()) }, OK);
}

#[test]
fn a_state_of_another_unit_is_refused() {
    let own = token("quick-return-loaded");
    let unit = Unit::stepping(&own).begin(0.0);
    let mut shorter = own.clone();
    shorter.step = 5e-4;
    let mut lighter = own.clone();
    lighter.replaced = vec![("m4".to_owned(), 1.0)];
    let others = [
        Unit::stepping(&token("quick-return")),
        Unit::stepping(&shorter),
        Unit::stepping(&lighter),
        Unit::integrated(&own),
    ];
    assert_eq!(unit.step(0.0, 0.1).status, OK);
    for other in others {
        let other = other.begin(0.0);
        let mut state = kept(&other);
        assert_eq!(unsafe { fmi3SetFMUState(unit.handle, state) }, ERROR);
        let said = unit.said();
        assert!(said.contains("the state is one of another unit"), "{said}");
        // It is not overwritten either.
        assert_eq!(unsafe { fmi3GetFMUState(unit.handle, &mut state) }, ERROR);
        assert!(unit.said().contains("the state is one of another unit"));
        assert_eq!(unit.get("time"), 0.1);
        assert_eq!(unsafe { fmi3SetFMUState(other.handle, state) }, OK, "{}", other.said());
        assert_eq!(unsafe { fmi3FreeFMUState(other.handle, &mut state) }, OK);
    }
}

#[test]
fn what_is_no_state_is_refused() {
    let unit = Unit::stepping(&token("quick-return")).begin(0.0);
    let state = kept(&unit);
    let mut bytes = [7_u8; 64];
    let mut freed = kept(&unit);
    let dangling = freed;
    assert_eq!(unsafe { fmi3FreeFMUState(unit.handle, &mut freed) }, OK);
    for wrong in [bytes.as_mut_ptr().cast(), unit.handle, dangling, state.wrapping_byte_add(8)] {
        let mut place: *mut c_void = wrong;
        assert_eq!(unsafe { fmi3SetFMUState(unit.handle, wrong) }, ERROR);
        assert_eq!(unsafe { fmi3GetFMUState(unit.handle, &mut place) }, ERROR);
        assert_eq!(unsafe { fmi3FreeFMUState(unit.handle, &mut place) }, ERROR);
        let said = unit.said();
        assert_eq!(said.matches("the state is none that this library gave, or it was freed").count(), 3, "{said}");
    }
    assert_eq!(unsafe { fmi3SetFMUState(unit.handle, null_mut()) }, ERROR);
    assert!(unit.said().contains("there is no state"));
    assert_eq!(unsafe { fmi3GetFMUState(unit.handle, null_mut()) }, ERROR);
    assert!(unit.said().contains("there is no place for the state"));
    // States are not written into bytes, so no bytes are a state.
    let (mut size, mut place) = (0, null_mut());
    assert_eq!(unsafe { fmi3SerializedFMUStateSize(unit.handle, state, &mut size) }, ERROR);
    for bytes in [null(), bytes.as_ptr()] {
        assert_eq!(unsafe { fmi3DeserializeFMUState(unit.handle, bytes, 64, &mut place) }, ERROR);
    }
    assert!(place.is_null() && unit.said().contains("states cannot be serialized"));
}
