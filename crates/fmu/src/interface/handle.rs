//! The handle of an importer, and the statuses and messages that it receives.

use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::panic::{AssertUnwindSafe, catch_unwind};

use qrm_core::Model;

use crate::failure::Failure;
use crate::instance::{Instance, Interface};
use crate::phase::Phase;

/// `fmi3Status`.
pub(super) type Status = c_int;
const OK: Status = 0;
const DISCARD: Status = 2;
pub(super) const ERROR: Status = 3;
const FATAL: Status = 4;

/// `fmi3LogMessageCallback`.
pub(super) type LogMessage = unsafe extern "C" fn(*mut c_void, Status, *const c_char, *const c_char);

unsafe extern "Rust" {
    /// Defined by [`export`](crate::export).
    fn qrm_fmu_models() -> &'static [Model];
}

/// The handle of an importer: an instance, and the callback for its messages.
pub(super) struct Handle {
    instance: Instance,
    environment: *mut c_void,
    log_message: Option<LogMessage>,
}

impl Handle {
    fn log(&self, status: Status, message: &str) {
        report(self.log_message, self.environment, status, message);
    }
}

pub(super) fn report(log_message: Option<LogMessage>, environment: *mut c_void, status: Status, message: &str) {
    let Some(log_message) = log_message else { return };
    let Ok(message) = CString::new(message.replace('\0', "")) else { return };
    let category = if status == FATAL { c"fatal" } else { c"error" };
    // SAFETY: the importer passed this function with this environment, and both strings end with zero and outlive the
    // call.
    unsafe { log_message(environment, status, category.as_ptr(), message.as_ptr()) }
}

/// Calls `work` with an instance.
pub(super) fn with(handle: *mut c_void, work: impl FnOnce(&mut Instance) -> Result<(), Failure>) -> Status {
    // SAFETY: the importer passes the handle from `instantiate`, from one thread at a time, until `fmi3FreeInstance`.
    let Some(handle) = (unsafe { handle.cast::<Handle>().as_mut() }) else { return ERROR };
    match catch_unwind(AssertUnwindSafe(|| work(&mut handle.instance))) {
        Ok(Ok(())) => OK,
        Ok(Err(Failure::Error(message))) => {
            handle.log(ERROR, &message);
            ERROR
        }
        Ok(Err(Failure::Discard(message))) => {
            handle.log(DISCARD, &message);
            DISCARD
        }
        Err(_) => {
            handle.log(FATAL, "a mistake of this library: please report it with the scene");
            FATAL
        }
    }
}

/// Calls `work` with an instance that is in one of the given phases.
pub(super) fn in_phase(
    handle: *mut c_void,
    phases: &[Phase],
    work: impl FnOnce(&mut Instance) -> Result<(), Failure>,
) -> Status {
    with(handle, |instance| {
        if !phases.contains(&instance.state.phase) {
            return Err(format!("not possible while the instance is {}", instance.state.phase.name()).into());
        }
        work(instance)
    })
}

pub(super) fn instantiate(
    interface: Interface,
    token: *const c_char,
    environment: *mut c_void,
    log_message: Option<LogMessage>,
) -> *mut c_void {
    let made = catch_unwind(|| {
        if token.is_null() {
            return Err("there is no instantiation token".to_owned());
        }
        // SAFETY: the importer passes a text that ends with zero.
        let token = unsafe { CStr::from_ptr(token) }.to_string_lossy();
        // SAFETY: `export` defines it with this signature.
        let models = unsafe { qrm_fmu_models() };
        Instance::new(&token, interface, models)
    });
    match made.unwrap_or_else(|_| Err("a mistake of this library".to_owned())) {
        Ok(instance) => Box::into_raw(Box::new(Handle { instance, environment, log_message })).cast(),
        Err(message) => {
            report(log_message, environment, ERROR, &message);
            std::ptr::null_mut()
        }
    }
}
