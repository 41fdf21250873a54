//! States that an importer saves and restores.
//!
//! The importer holds a pointer that is never dereferenced: it is only the key of the state in a register. Pointers to
//! anything else, to freed states, and to states of another library in the same process are therefore refused, like
//! states of another mechanism.

use std::collections::BTreeMap;
use std::ffi::c_void;
use std::ptr;
use std::sync::{Mutex, MutexGuard, PoisonError};

use crate::failure::Failure;
use crate::instance::{Instance, State};

/// A saved state, and the identity of its instance.
struct SavedState {
    identity: String,
    state: State,
}

/// All saved states by their addresses, which are unique in the process.
type Register = BTreeMap<usize, Box<SavedState>>;

static REGISTER: Mutex<Register> = Mutex::new(Register::new());

fn register() -> MutexGuard<'static, Register> {
    // No operation leaves the register half-changed.
    REGISTER.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Saves the state of an instance in `place`, which is null or contains a state to be overwritten.
///
/// # Safety
/// `place` is null or points to a pointer.
pub(super) unsafe fn save(instance: &Instance, place: *mut *mut c_void) -> Result<(), Failure> {
    // SAFETY: the caller's contract.
    let place = unsafe { place.as_mut() }.ok_or("there is no place for the state")?;
    let mut register = register();
    let state = instance.state.clone();
    if !place.is_null() {
        find(&register, instance, *place)?;
        register.get_mut(&place.addr()).ok_or(UNKNOWN)?.state = state;
        return Ok(());
    }
    let mut saved = Box::new(SavedState { identity: instance.identity(), state });
    let address: *mut SavedState = &mut *saved;
    *place = address.cast();
    register.insert(address.addr(), saved);
    Ok(())
}

/// Restores a saved state in an instance.
pub(super) fn restore(instance: &mut Instance, state: *mut c_void) -> Result<(), Failure> {
    instance.state = find(&register(), instance, state)?;
    Ok(())
}

/// Frees a saved state, if there is one.
///
/// # Safety
/// `place` is null or points to a pointer.
pub(super) unsafe fn free(place: *mut *mut c_void) -> Result<(), Failure> {
    // SAFETY: the caller's contract.
    let Some(place) = (unsafe { place.as_mut() }) else { return Ok(()) };
    if !place.is_null() {
        register().remove(&place.addr()).ok_or(UNKNOWN)?;
        *place = ptr::null_mut();
    }
    Ok(())
}

const UNKNOWN: &str = "the state is none that this library gave, or it was freed";

/// Copies the state with this address, if it belongs to the same mechanism, settings and interface.
fn find(register: &Register, instance: &Instance, state: *mut c_void) -> Result<State, Failure> {
    if state.is_null() {
        return Err("there is no state".into());
    }
    let saved = register.get(&state.addr()).ok_or(UNKNOWN)?;
    if saved.identity != instance.identity() {
        let (theirs, own) = (&saved.identity, instance.identity());
        return Err(format!("the state is one of another unit: {theirs}, where this is {own}").into());
    }
    Ok(saved.state.clone())
}
