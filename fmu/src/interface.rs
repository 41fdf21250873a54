//! The functions of FMI 3.0, as its header `fmi3FunctionTypes.h` declares them.
//!
//! Each looks at its pointers, hands on to [`Instance`], and turns what comes back into a status; a panic, which would
//! be a mistake of this library, becomes `fmi3Fatal` instead of passing into the importer.

mod absent;
mod integration;
mod kept;

use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::slice;

use qrm_core::Model;

use crate::failure::Failure;
use crate::instance::{Instance, Interface};
use crate::phase::Phase;

/// `fmi3Status`.
type Status = c_int;
const OK: Status = 0;
const DISCARD: Status = 2;
const ERROR: Status = 3;
const FATAL: Status = 4;

/// `fmi3LogMessageCallback`.
type LogMessage = unsafe extern "C" fn(*mut c_void, Status, *const c_char, *const c_char);

unsafe extern "Rust" {
    /// Defined by [`export`](crate::export).
    fn qrm_fmu_models() -> &'static [Model];
}

/// The handle that an importer holds: an instance, and the callback that receives its messages.
struct Handle {
    instance: Instance,
    environment: *mut c_void,
    log_message: Option<LogMessage>,
}

impl Handle {
    fn log(&self, status: Status, message: &str) {
        report(self.log_message, self.environment, status, message);
    }
}

fn report(log_message: Option<LogMessage>, environment: *mut c_void, status: Status, message: &str) {
    let Some(log_message) = log_message else { return };
    let Ok(message) = CString::new(message.replace('\0', "")) else { return };
    let category = if status == FATAL { c"fatal" } else { c"error" };
    // SAFETY: the importer gave this function with this environment, and both strings end with zero and outlive the
    // call.
    unsafe { log_message(environment, status, category.as_ptr(), message.as_ptr()) }
}

/// Does something with an instance.
fn with(handle: *mut c_void, work: impl FnOnce(&mut Instance) -> Result<(), Failure>) -> Status {
    // SAFETY: the interface hands back what `instantiate` gave, from one thread at a time, until `fmi3FreeInstance`.
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

/// Does something with an instance that is in one of the given phases.
fn in_phase(handle: *mut c_void, phases: &[Phase], work: impl FnOnce(&mut Instance) -> Result<(), Failure>) -> Status {
    with(handle, |instance| {
        if !phases.contains(&instance.state.phase) {
            return Err(format!("not possible while the instance is {}", instance.state.phase.name()).into());
        }
        work(instance)
    })
}

/// An array of the importer's; empty where there is none.
///
/// # Safety
/// `values` points to `count` values, or to nothing.
unsafe fn read<'a, T>(values: *const T, count: usize) -> &'a [T] {
    // SAFETY: the caller's contract; an array of no elements may be a null pointer in C, not in Rust.
    if values.is_null() || count == 0 { &[] } else { unsafe { slice::from_raw_parts(values, count) } }
}

/// An array of the importer's to write into; empty where there is none.
///
/// # Safety
/// `values` points to `count` values that nobody else uses, or to nothing.
unsafe fn room<'a, T>(values: *mut T, count: usize) -> &'a mut [T] {
    // SAFETY: as above.
    if values.is_null() || count == 0 { &mut [] } else { unsafe { slice::from_raw_parts_mut(values, count) } }
}

/// Writes a result, where the importer wants it.
///
/// # Safety
/// `place` points to a value, or to nothing.
unsafe fn put<T>(place: *mut T, value: T) {
    if !place.is_null() {
        // SAFETY: the caller's contract.
        unsafe { place.write(value) }
    }
}

/// Refuses a null pointer to where the one result of a function belongs.
fn is_there<T>(place: *mut T) -> Result<(), Failure> {
    if place.is_null() { Err("there is no place for the result".into()) } else { Ok(()) }
}

fn same_count(given: usize, needed: usize) -> Result<(), Failure> {
    if given == needed { Ok(()) } else { Err(format!("{given} values were given where there are {needed}").into()) }
}

fn instantiate(
    interface: Interface,
    token: *const c_char,
    environment: *mut c_void,
    log_message: Option<LogMessage>,
) -> *mut c_void {
    let made = catch_unwind(|| {
        if token.is_null() {
            return Err("there is no instantiation token".to_owned());
        }
        // SAFETY: the importer gives a text that ends with zero.
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

/// Functions of the interface.
macro_rules! interface {
    ($($(#[$attribute:meta])* fn $name:ident($($argument:ident: $type:ty),* $(,)?) $(-> $result:ty)? $body:block)*) => {
        $(
            $(#[$attribute])*
            #[allow(non_snake_case, clippy::too_many_arguments, unused_variables)]
            #[unsafe(no_mangle)]
            unsafe extern "C" fn $name($($argument: $type),*) $(-> $result)? $body
        )*
    };
}

use Phase::{Event, Initializing, Instantiated, Integrating, Stepping, Terminated};
use interface;

interface! {
    fn fmi3GetVersion() -> *const c_char {
        c"3.0".as_ptr()
    }

    fn fmi3SetDebugLogging(handle: *mut c_void, on: bool, count: usize, categories: *const *const c_char) -> Status {
        // What is reported are errors, and they are never unwanted.
        with(handle, |_| Ok(()))
    }

    fn fmi3InstantiateCoSimulation(
        name: *const c_char,
        token: *const c_char,
        resources: *const c_char,
        visible: bool,
        logging: bool,
        event_mode: bool,
        early_return: bool,
        intermediate: *const u32,
        count: usize,
        environment: *mut c_void,
        log_message: Option<LogMessage>,
        intermediate_update: *const c_void,
    ) -> *mut c_void {
        instantiate(Interface::CoSimulation, token, environment, log_message)
    }

    fn fmi3InstantiateModelExchange(
        name: *const c_char,
        token: *const c_char,
        resources: *const c_char,
        visible: bool,
        logging: bool,
        environment: *mut c_void,
        log_message: Option<LogMessage>,
    ) -> *mut c_void {
        instantiate(Interface::ModelExchange, token, environment, log_message)
    }

    fn fmi3InstantiateScheduledExecution(
        name: *const c_char,
        token: *const c_char,
        resources: *const c_char,
        visible: bool,
        logging: bool,
        environment: *mut c_void,
        log_message: Option<LogMessage>,
        clock_update: *const c_void,
        lock: *const c_void,
        unlock: *const c_void,
    ) -> *mut c_void {
        report(log_message, environment, ERROR, "there is no scheduled execution");
        std::ptr::null_mut()
    }

    fn fmi3FreeInstance(handle: *mut c_void) {
        if !handle.is_null() {
            // SAFETY: it is what `instantiate` gave, and the importer does not use it again.
            drop(unsafe { Box::from_raw(handle.cast::<Handle>()) });
        }
    }

    fn fmi3EnterInitializationMode(
        handle: *mut c_void,
        has_tolerance: bool,
        tolerance: f64,
        start: f64,
        has_stop: bool,
        stop: f64,
    ) -> Status {
        in_phase(handle, &[Instantiated], |instance| {
            instance.begin(start, has_stop.then_some(stop))
        })
    }

    fn fmi3ExitInitializationMode(handle: *mut c_void) -> Status {
        in_phase(handle, &[Initializing], Instance::start)
    }

    fn fmi3Terminate(handle: *mut c_void) -> Status {
        in_phase(handle, &[Stepping, Event, Integrating], |instance| {
            instance.state.phase = Terminated;
            Ok(())
        })
    }

    fn fmi3Reset(handle: *mut c_void) -> Status {
        with(handle, |instance| {
            instance.reset();
            Ok(())
        })
    }

    fn fmi3GetFloat64(
        handle: *mut c_void,
        references: *const u32,
        count: usize,
        values: *mut f64,
        value_count: usize,
    ) -> Status {
        // SAFETY: the importer says how long its arrays are.
        let (references, values) = unsafe { (read(references, count), room(values, value_count)) };
        in_phase(handle, &[Instantiated, Initializing, Stepping, Event, Integrating, Terminated], |instance| {
            same_count(values.len(), references.len())?;
            for (value, reference) in values.iter_mut().zip(references) {
                *value = instance.get(*reference)?;
            }
            Ok(())
        })
    }

    fn fmi3SetFloat64(
        handle: *mut c_void,
        references: *const u32,
        count: usize,
        values: *const f64,
        value_count: usize,
    ) -> Status {
        // SAFETY: the importer says how long its arrays are.
        let (references, values) = unsafe { (read(references, count), read(values, value_count)) };
        in_phase(handle, &[Instantiated, Initializing, Stepping, Event, Integrating], |instance| {
            same_count(values.len(), references.len())?;
            instance.set(references, values)
        })
    }

    fn fmi3GetFMUState(handle: *mut c_void, state: *mut *mut c_void) -> Status {
        // SAFETY: the importer gives a place for a state, or nothing.
        with(handle, |instance| unsafe { kept::keep(instance, state) })
    }

    fn fmi3SetFMUState(handle: *mut c_void, state: *mut c_void) -> Status {
        with(handle, |instance| kept::put_back(instance, state))
    }

    fn fmi3FreeFMUState(handle: *mut c_void, state: *mut *mut c_void) -> Status {
        // SAFETY: the importer gives a place with a state, or nothing.
        with(handle, |_| unsafe { kept::free(state) })
    }

    fn fmi3DoStep(
        handle: *mut c_void,
        time: f64,
        step: f64,
        no_earlier_state: bool,
        event_needed: *mut bool,
        terminate: *mut bool,
        early: *mut bool,
        last: *mut f64,
    ) -> Status {
        in_phase(handle, &[Stepping], |instance| {
            let made = instance.advance(time, step);
            // SAFETY: they point to places of the importer, or to nothing.
            unsafe {
                put(event_needed, false);
                put(terminate, false);
                put(early, false);
                put(last, instance.time());
            }
            made
        })
    }
}
