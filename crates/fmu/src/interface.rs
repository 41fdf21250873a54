//! The functions of FMI 3.0, as declared in its header `fmi3FunctionTypes.h`.
//!
//! Each function checks its pointers, calls [`Instance`], and turns the result into a status. A panic, which would be a
//! bug of this library, becomes `fmi3Fatal` instead of unwinding into the importer.

mod absent;
mod handle;
mod integration;
mod pointers;
mod saved_state;

use std::ffi::{c_char, c_void};

use crate::instance::{Instance, Interface};
use crate::phase::Phase;
use handle::{ERROR, Handle, LogMessage, Status, in_phase, instantiate, report, with};
use pointers::{put, read, room, same_count};

/// Defines functions of the interface.
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
        // Only errors are logged, and they cannot be turned off.
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
            // SAFETY: the handle comes from `instantiate`, and the importer does not use it again.
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
        // SAFETY: the importer passes the lengths of its arrays.
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
        // SAFETY: the importer passes the lengths of its arrays.
        let (references, values) = unsafe { (read(references, count), read(values, value_count)) };
        in_phase(handle, &[Instantiated, Initializing, Stepping, Event, Integrating], |instance| {
            same_count(values.len(), references.len())?;
            instance.set(references, values)
        })
    }

    fn fmi3GetFMUState(handle: *mut c_void, state: *mut *mut c_void) -> Status {
        // SAFETY: the importer passes a place for a state, or null.
        with(handle, |instance| unsafe { saved_state::save(instance, state) })
    }

    fn fmi3SetFMUState(handle: *mut c_void, state: *mut c_void) -> Status {
        with(handle, |instance| saved_state::restore(instance, state))
    }

    fn fmi3FreeFMUState(handle: *mut c_void, state: *mut *mut c_void) -> Status {
        // SAFETY: the importer passes a place with a state, or null.
        with(handle, |_| unsafe { saved_state::free(state) })
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
            // SAFETY: the pointers refer to places of the importer, or are null.
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
