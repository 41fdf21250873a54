//! The functions of the interface, called as a simulation tool calls them.
#![allow(unsafe_code, non_snake_case, reason = "they are functions of C, with the names of the standard")]

use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::ptr::{null, null_mut};

use qrm_core::Model;
use qrm_fmu::{InstantiationToken, variables};
use qrm_sim::integrate::MethodSettings;

pub(crate) const OK: c_int = 0;
pub(crate) const DISCARD: c_int = 2;
pub(crate) const ERROR: c_int = 3;

pub(crate) type Handle = *mut c_void;
pub(crate) type Log = Option<unsafe extern "C" fn(*mut c_void, c_int, *const c_char, *const c_char)>;

// The library of the units is linked for its functions alone.
use qrm as _;

#[rustfmt::skip]
unsafe extern "C" {
    fn fmi3InstantiateCoSimulation(
        name: *const c_char, token: *const c_char, resources: *const c_char, visible: bool, logging: bool,
        event_mode: bool, early_return: bool, intermediate: *const u32, count: usize, environment: *mut c_void,
        log: Log, update: *const c_void,
    ) -> Handle;
    fn fmi3InstantiateModelExchange(
        name: *const c_char, token: *const c_char, resources: *const c_char, visible: bool, logging: bool,
        environment: *mut c_void, log: Log,
    ) -> Handle;
    fn fmi3FreeInstance(handle: Handle);
    fn fmi3EnterInitializationMode(
        handle: Handle, has_tolerance: bool, tolerance: f64, start: f64, has_stop: bool, stop: f64,
    ) -> c_int;
    pub(crate) fn fmi3ExitInitializationMode(handle: Handle) -> c_int;
    pub(crate) fn fmi3EnterEventMode(handle: Handle) -> c_int;
    pub(crate) fn fmi3EnterContinuousTimeMode(handle: Handle) -> c_int;
    pub(crate) fn fmi3EnterStepMode(handle: Handle) -> c_int;
    pub(crate) fn fmi3Terminate(handle: Handle) -> c_int;
    pub(crate) fn fmi3Reset(handle: Handle) -> c_int;
    pub(crate) fn fmi3GetFloat64(handle: Handle, of: *const u32, count: usize, values: *mut f64, room: usize) -> c_int;
    pub(crate) fn fmi3SetFloat64(handle: Handle, of: *const u32, count: usize, values: *const f64, given: usize) -> c_int;
    pub(crate) fn fmi3GetInt32(handle: Handle, of: *const u32, count: usize, values: *mut i32, room: usize) -> c_int;
    pub(crate) fn fmi3GetFMUState(handle: Handle, state: *mut *mut c_void) -> c_int;
    pub(crate) fn fmi3SetFMUState(handle: Handle, state: *mut c_void) -> c_int;
    pub(crate) fn fmi3FreeFMUState(handle: Handle, state: *mut *mut c_void) -> c_int;
    pub(crate) fn fmi3DeserializeFMUState(handle: Handle, bytes: *const u8, size: usize, state: *mut *mut c_void) -> c_int;
    pub(crate) fn fmi3SerializedFMUStateSize(handle: Handle, state: *mut c_void, size: *mut usize) -> c_int;
    pub(crate) fn fmi3UpdateDiscreteStates(
        handle: Handle, needs: *mut bool, terminate: *mut bool, nominals: *mut bool, values: *mut bool,
        has_next: *mut bool, next: *mut f64,
    ) -> c_int;
    pub(crate) fn fmi3CompletedIntegratorStep(handle: Handle, last: bool, event: *mut bool, terminate: *mut bool) -> c_int;
    pub(crate) fn fmi3SetTime(handle: Handle, t: f64) -> c_int;
    pub(crate) fn fmi3SetContinuousStates(handle: Handle, states: *const f64, count: usize) -> c_int;
    pub(crate) fn fmi3GetContinuousStates(handle: Handle, states: *mut f64, count: usize) -> c_int;
    pub(crate) fn fmi3GetContinuousStateDerivatives(handle: Handle, derivatives: *mut f64, count: usize) -> c_int;
    pub(crate) fn fmi3GetNominalsOfContinuousStates(handle: Handle, nominals: *mut f64, count: usize) -> c_int;
    pub(crate) fn fmi3GetEventIndicators(handle: Handle, indicators: *mut f64, count: usize) -> c_int;
    pub(crate) fn fmi3GetNumberOfContinuousStates(handle: Handle, count: *mut usize) -> c_int;
    pub(crate) fn fmi3GetNumberOfEventIndicators(handle: Handle, count: *mut usize) -> c_int;
    fn fmi3DoStep(
        handle: Handle, t: f64, step: f64, no_earlier: bool, event: *mut bool, terminate: *mut bool,
        early: *mut bool, last: *mut f64,
    ) -> c_int;
}

/// The callback by which a tool takes messages.
unsafe extern "C" fn log(environment: *mut c_void, _status: c_int, _category: *const c_char, message: *const c_char) {
    // SAFETY: the environment is the list of an instance, which is alive.
    let (messages, text) = unsafe { (environment.cast::<Vec<String>>().as_mut(), CStr::from_ptr(message)) };
    messages.expect("a list").push(text.to_string_lossy().into_owned());
}

/// The results of `fmi3DoStep`: status, the flags event, terminate and early return, and the time that was reached.
#[derive(Debug, PartialEq)]
pub(crate) struct Stepped {
    pub(crate) status: c_int,
    pub(crate) flags: [bool; 3],
    pub(crate) last: f64,
}

/// An instance, and what it said.
pub(crate) struct Unit {
    pub(crate) handle: Handle,
    names: Vec<String>,
    messages: *mut Vec<String>,
}

/// The mechanism of a scene.
pub(crate) fn model(scene: &str) -> &'static Model {
    qrm_model::MODELS.iter().find(|model| model.description.name == scene).expect("a scene")
}

/// The token of a scene as it stands, with masses as `qrm export-fmu` finds them.
pub(crate) fn token(scene: &str) -> InstantiationToken {
    let model = model(scene);
    let step = model.mechanism(&|_| None).schedule().step;
    let is_mass = |name: &&str| name.starts_with(['m', 'J']);
    let masses = model.description.parameters.iter().map(|p| p.name).filter(is_mass);
    let own = InstantiationToken::new(model.description, MethodSettings::default(), step);
    InstantiationToken { masses: masses.map(str::to_owned).collect(), ..own }
}

impl Unit {
    fn make(token: &InstantiationToken, make: impl FnOnce(*const c_char, *mut c_void) -> Handle) -> Self {
        let text = CString::new(token.to_string()).expect("a text");
        let messages: *mut Vec<String> = Box::into_raw(Box::default());
        let handle = make(text.as_ptr(), messages.cast());
        assert!(!handle.is_null(), "{token}");
        let names = variables(model(&token.scene).description).into_iter().map(|variable| variable.name).collect();
        Self { handle, names, messages }
    }

    /// The messages of a library that refuses a token.
    pub(crate) fn refused(token: &InstantiationToken) -> Vec<String> {
        let text = CString::new(token.to_string()).expect("a text");
        let messages: *mut Vec<String> = Box::into_raw(Box::default());
        // SAFETY: text and list live until the end of the call.
        unsafe {
            let handle = fmi3InstantiateModelExchange(
                c"unit".as_ptr(),
                text.as_ptr(),
                null(),
                false,
                true,
                messages.cast(),
                Some(log),
            );
            assert!(handle.is_null(), "{token}");
            *Box::from_raw(messages)
        }
    }

    /// For co-simulation.
    pub(crate) fn stepping(token: &InstantiationToken) -> Self {
        Self::make(token, |text, environment| unsafe {
            fmi3InstantiateCoSimulation(
                c"unit".as_ptr(),
                text,
                null(),
                false,
                true,
                false,
                false,
                null(),
                0,
                environment,
                Some(log),
                null(),
            )
        })
    }

    /// For model exchange.
    pub(crate) fn integrated(token: &InstantiationToken) -> Self {
        Self::make(token, |text, environment| unsafe {
            fmi3InstantiateModelExchange(c"unit".as_ptr(), text, null(), false, true, environment, Some(log))
        })
    }

    pub(crate) fn initialize(&self, start: f64, stop: Option<f64>) -> c_int {
        let (has_stop, stop) = (stop.is_some(), stop.unwrap_or(0.0));
        unsafe { fmi3EnterInitializationMode(self.handle, false, 0.0, start, has_stop, stop) }
    }

    /// Begins the motion at a time.
    pub(crate) fn begin(self, start: f64) -> Self {
        assert_eq!(self.initialize(start, None), OK, "{}", self.said());
        assert_eq!(unsafe { fmi3ExitInitializationMode(self.handle) }, OK, "{}", self.said());
        self
    }

    /// Begins the motion for an importer that integrates, up to where it does.
    pub(crate) fn begin_integration(self, start: f64) -> Self {
        let unit = self.begin(start);
        assert_eq!(unit.update(), (OK, false), "{}", unit.said());
        assert_eq!(unsafe { fmi3EnterContinuousTimeMode(unit.handle) }, OK);
        unit
    }

    pub(crate) fn reference(&self, name: &str) -> u32 {
        let place = self.names.iter().position(|own| own == name);
        u32::try_from(place.unwrap_or_else(|| panic!("no variable {name}"))).expect("few variables")
    }

    pub(crate) fn set(&self, values: &[(&str, f64)]) -> c_int {
        let references: Vec<u32> = values.iter().map(|(name, _)| self.reference(name)).collect();
        let values: Vec<f64> = values.iter().map(|(_, value)| *value).collect();
        unsafe { fmi3SetFloat64(self.handle, references.as_ptr(), references.len(), values.as_ptr(), values.len()) }
    }

    pub(crate) fn try_get(&self, name: &str) -> (c_int, f64) {
        let mut value = f64::NAN;
        let status = unsafe { fmi3GetFloat64(self.handle, &self.reference(name), 1, &mut value, 1) };
        (status, value)
    }

    pub(crate) fn get(&self, name: &str) -> f64 {
        let (status, value) = self.try_get(name);
        assert_eq!(status, OK, "{}", self.said());
        value
    }

    pub(crate) fn step(&self, t: f64, step: f64) -> Stepped {
        let (mut flags, mut last) = ([true; 3], f64::NAN);
        let [event, terminate, early] = &mut flags;
        let status = unsafe { fmi3DoStep(self.handle, t, step, true, event, terminate, early, &mut last) };
        Stepped { status, flags, last }
    }

    /// Deals with an event; whether the states changed.
    pub(crate) fn update(&self) -> (c_int, bool) {
        let mut flags = [true; 5];
        let [needs, terminate, nominals, values, has_next] = &mut flags;
        let mut next = 0.0;
        let status =
            unsafe { fmi3UpdateDiscreteStates(self.handle, needs, terminate, nominals, values, has_next, &mut next) };
        assert!(status != OK || !(flags[0] || flags[1] || flags[2] || flags[4]), "{flags:?}");
        (status, flags[3])
    }

    fn count(&self) -> usize {
        let mut count = 0;
        assert_eq!(unsafe { fmi3GetNumberOfContinuousStates(self.handle, &mut count) }, OK);
        count
    }

    pub(crate) fn states(&self) -> Vec<f64> {
        let mut states = vec![0.0; self.count()];
        let status = unsafe { fmi3GetContinuousStates(self.handle, states.as_mut_ptr(), states.len()) };
        assert_eq!(status, OK, "{}", self.said());
        states
    }

    pub(crate) fn place(&self, t: f64, states: &[f64]) -> c_int {
        let of_time = unsafe { fmi3SetTime(self.handle, t) };
        let of_states = unsafe { fmi3SetContinuousStates(self.handle, states.as_ptr(), states.len()) };
        of_time.max(of_states)
    }

    pub(crate) fn derivatives(&self) -> (c_int, Vec<f64>) {
        let mut slopes = vec![f64::NAN; self.count()];
        let status = unsafe { fmi3GetContinuousStateDerivatives(self.handle, slopes.as_mut_ptr(), slopes.len()) };
        (status, slopes)
    }

    /// The messages of the unit since the last call.
    pub(crate) fn said(&self) -> String {
        // SAFETY: the list lives as long as the unit, and no call is under way.
        unsafe { std::mem::take(&mut *self.messages) }.join("\n")
    }
}

impl Drop for Unit {
    fn drop(&mut self) {
        unsafe {
            fmi3FreeInstance(self.handle);
            drop(Box::from_raw(self.messages));
        }
    }
}

/// No instance.
pub(crate) const NOTHING: Handle = null_mut();
