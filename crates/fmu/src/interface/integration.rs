//! The functions of FMI 3.0 for importers that integrate.

use std::ffi::c_void;

use super::handle::{Status, in_phase, with};
use super::interface;
use super::pointers::{is_there, put, read, room, same_count};
use crate::instance::Interface;
use crate::phase::Phase::{Event, Initializing, Integrating, Terminated};

interface! {
    fn fmi3EnterEventMode(handle: *mut c_void) -> Status {
        in_phase(handle, &[Integrating], |instance| {
            instance.state.phase = Event;
            Ok(())
        })
    }

    fn fmi3EvaluateDiscreteStates(handle: *mut c_void) -> Status {
        with(handle, |_| Ok(()))
    }

    fn fmi3UpdateDiscreteStates(
        handle: *mut c_void,
        needs_update: *mut bool,
        terminate: *mut bool,
        nominals_changed: *mut bool,
        values_changed: *mut bool,
        has_next_event: *mut bool,
        next_event: *mut f64,
    ) -> Status {
        in_phase(handle, &[Event], |instance| {
            let is_open = instance.is_open()?;
            if is_open {
                instance.close()?;
            }
            // SAFETY: the pointers refer to places of the importer, or are null.
            unsafe {
                put(needs_update, false);
                put(terminate, false);
                put(nominals_changed, false);
                put(values_changed, is_open);
                put(has_next_event, false);
                put(next_event, 0.0);
            }
            Ok(())
        })
    }

    fn fmi3EnterContinuousTimeMode(handle: *mut c_void) -> Status {
        in_phase(handle, &[Event], |instance| {
            instance.state.phase = Integrating;
            Ok(())
        })
    }

    fn fmi3CompletedIntegratorStep(
        handle: *mut c_void,
        no_earlier_state: bool,
        enter_event_mode: *mut bool,
        terminate: *mut bool,
    ) -> Status {
        in_phase(handle, &[Integrating], |instance| {
            let is_open = instance.is_open()?;
            // SAFETY: the pointers refer to places of the importer, or are null.
            unsafe {
                put(enter_event_mode, is_open);
                put(terminate, false);
            }
            Ok(())
        })
    }

    fn fmi3SetTime(handle: *mut c_void, time: f64) -> Status {
        in_phase(handle, &[Event, Integrating], |instance| instance.place(Some(time), None))
    }

    fn fmi3SetContinuousStates(handle: *mut c_void, states: *const f64, count: usize) -> Status {
        // SAFETY: the importer passes the length of its array.
        let states = unsafe { read(states, count) };
        in_phase(handle, &[Integrating], |instance| {
            same_count(states.len(), instance.states())?;
            instance.place(None, Some(states))
        })
    }

    fn fmi3GetContinuousStates(handle: *mut c_void, states: *mut f64, count: usize) -> Status {
        // SAFETY: the importer passes the length of its array.
        let states = unsafe { room(states, count) };
        in_phase(handle, &[Initializing, Event, Integrating, Terminated], |instance| {
            instance.is_for(Interface::ModelExchange)?;
            same_count(states.len(), instance.states())?;
            states.copy_from_slice(&instance.continuous_states()?);
            Ok(())
        })
    }

    fn fmi3GetContinuousStateDerivatives(handle: *mut c_void, derivatives: *mut f64, count: usize) -> Status {
        // SAFETY: the importer passes the length of its array.
        let derivatives = unsafe { room(derivatives, count) };
        in_phase(handle, &[Initializing, Event, Integrating, Terminated], |instance| {
            instance.is_for(Interface::ModelExchange)?;
            same_count(derivatives.len(), instance.states())?;
            derivatives.copy_from_slice(&instance.derivatives()?);
            Ok(())
        })
    }

    fn fmi3GetNominalsOfContinuousStates(handle: *mut c_void, nominals: *mut f64, count: usize) -> Status {
        // SAFETY: the importer passes the length of its array.
        let nominals = unsafe { room(nominals, count) };
        with(handle, |instance| {
            instance.is_for(Interface::ModelExchange)?;
            same_count(nominals.len(), instance.states())?;
            nominals.fill(1.0);
            Ok(())
        })
    }

    fn fmi3GetEventIndicators(handle: *mut c_void, indicators: *mut f64, count: usize) -> Status {
        with(handle, |_| same_count(count, 0))
    }

    fn fmi3GetNumberOfEventIndicators(handle: *mut c_void, count: *mut usize) -> Status {
        with(handle, |_| {
            is_there(count)?;
            // SAFETY: the pointer refers to a place of the importer.
            unsafe { put(count, 0) };
            Ok(())
        })
    }

    fn fmi3GetNumberOfContinuousStates(handle: *mut c_void, count: *mut usize) -> Status {
        with(handle, |instance| {
            is_there(count)?;
            // SAFETY: the pointer refers to a place of the importer.
            unsafe { put(count, instance.states()) };
            Ok(())
        })
    }
}
