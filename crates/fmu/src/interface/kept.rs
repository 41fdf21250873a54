//! States that an importer keeps and puts back.
//!
//! The importer holds a pointer, but it is never followed: it is the address under which the state is found here. So a
//! pointer to anything else, to a state that was freed, or to one of another library in the same process is refused
//! like a state of another mechanism.

use std::collections::BTreeMap;
use std::ffi::c_void;
use std::ptr;
use std::sync::{Mutex, MutexGuard, PoisonError};

use crate::failure::Failure;
use crate::instance::{Instance, State};

/// A state, and what it is of.
struct Kept {
    identity: String,
    state: State,
}

/// All states that are kept, by their addresses, which nothing else in the process has.
type Register = BTreeMap<usize, Box<Kept>>;

static REGISTER: Mutex<Register> = Mutex::new(Register::new());

fn register() -> MutexGuard<'static, Register> {
    // Nothing in here can be half done.
    REGISTER.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Keeps the state of an instance in a place that is null, or that holds a state to be overwritten.
///
/// # Safety
/// `place` is null or points to a pointer.
pub(super) unsafe fn keep(instance: &Instance, place: *mut *mut c_void) -> Result<(), Failure> {
    // SAFETY: the caller's contract.
    let place = unsafe { place.as_mut() }.ok_or("there is no place for the state")?;
    let mut register = register();
    let state = instance.state.clone();
    if !place.is_null() {
        find(&register, instance, *place)?;
        register.get_mut(&place.addr()).ok_or(UNKNOWN)?.state = state;
        return Ok(());
    }
    let mut kept = Box::new(Kept { identity: instance.identity(), state });
    let address: *mut Kept = &mut *kept;
    *place = address.cast();
    register.insert(address.addr(), kept);
    Ok(())
}

/// Puts a kept state back into an instance.
pub(super) fn put_back(instance: &mut Instance, state: *mut c_void) -> Result<(), Failure> {
    instance.state = find(&register(), instance, state)?;
    Ok(())
}

/// Frees a kept state, if there is one.
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

/// A copy of the state with this address, if it is one of the same mechanism, settings and interface.
fn find(register: &Register, instance: &Instance, state: *mut c_void) -> Result<State, Failure> {
    if state.is_null() {
        return Err("there is no state".into());
    }
    let kept = register.get(&state.addr()).ok_or(UNKNOWN)?;
    if kept.identity != instance.identity() {
        let (theirs, own) = (&kept.identity, instance.identity());
        return Err(format!("the state is one of another unit: {theirs}, where this is {own}").into());
    }
    Ok(kept.state.clone())
}
