//! The functions that a page calls.
//!
//! The page writes bytes to the memory that [`reserve`] gives, calls a function, and reads what [`output`] and
//! [`output_length`] say. Functions give 1 if they did what was asked, else 0; the output is then a message.

use std::cell::RefCell;

use crate::named_values::NamedValues;
use crate::simulator::Simulator;

thread_local! {
    static STATE: RefCell<State> = RefCell::default();
}

/// The state that is kept between two calls.
#[derive(Default)]
struct State {
    input: Vec<u8>,
    output: Vec<u8>,
    simulator: Option<Simulator>,
}

/// Room for so many bytes of input.
#[allow(unsafe_code, reason = "the page calls it by its name")]
#[unsafe(no_mangle)]
pub extern "C" fn reserve(length: usize) -> *mut u8 {
    STATE.with_borrow_mut(|state| {
        state.input = vec![0; length];
        state.input.as_mut_ptr()
    })
}

/// The output of the last call.
#[allow(unsafe_code, reason = "the page calls it by its name")]
#[unsafe(no_mangle)]
pub extern "C" fn output() -> *const u8 {
    STATE.with_borrow(|state| state.output.as_ptr())
}

/// The number of bytes of that output.
#[allow(unsafe_code, reason = "the page calls it by its name")]
#[unsafe(no_mangle)]
pub extern "C" fn output_length() -> usize {
    STATE.with_borrow(|state| state.output.len())
}

/// Takes the derived scene of the input; the output tells its parameters as JSON.
#[allow(unsafe_code, reason = "the page calls it by its name")]
#[unsafe(no_mangle)]
pub extern "C" fn load() -> u32 {
    answer(|state| {
        let simulator = Simulator::new(&state.input)?;
        let about = simulator.about()?;
        state.simulator = Some(simulator);
        Ok(about)
    })
}

/// Runs the scene with the values of the input, a line `NAME=VALUE` each; the output is the motion as JSON.
#[allow(unsafe_code, reason = "the page calls it by its name")]
#[unsafe(no_mangle)]
pub extern "C" fn run() -> u32 {
    answer(|state| {
        let changed = NamedValues::new(&state.input)?;
        state.simulator.as_mut().ok_or(NO_SCENE)?.run(changed)
    })
}

/// As [`run`], by fewer steps and without an estimate of the error, for a motion that ends at about that time.
#[allow(unsafe_code, reason = "the page calls it by its name")]
#[unsafe(no_mangle)]
pub extern "C" fn draft(end: f64) -> u32 {
    answer(|state| {
        let changed = NamedValues::new(&state.input)?;
        state.simulator.as_mut().ok_or(NO_SCENE)?.draft(changed, end)
    })
}

/// The numbers of the last motion at a time, as JSON: both components of each node and of each arrow, the angle of each
/// block, the value of each curve.
#[allow(unsafe_code, reason = "the page calls it by its name")]
#[unsafe(no_mangle)]
pub extern "C" fn at(t: f64) -> u32 {
    answer(|state| state.simulator.as_mut().ok_or(NO_SCENE)?.at(t))
}

/// Drags points, a line `NAME=WEIGHT` of the input each, towards a place, from the pose at a time of the last motion,
/// or from where they were dragged last if the time is not a number; the output is the start there as JSON.
#[allow(unsafe_code, reason = "the page calls it by its name")]
#[unsafe(no_mangle)]
pub extern "C" fn drag(t: f64, x: f64, y: f64) -> u32 {
    answer(|state| {
        let points = NamedValues::new(&state.input)?;
        state.simulator.as_mut().ok_or(NO_SCENE)?.drag(t, [x, y], &points)
    })
}

/// The message for a page that has loaded no scene.
const NO_SCENE: &str = "no scene has been loaded";

fn answer(work: impl FnOnce(&mut State) -> Result<String, String>) -> u32 {
    STATE.with_borrow_mut(|state| {
        let result = work(state);
        let is_done = result.is_ok();
        state.output = result.unwrap_or_else(|message| message).into_bytes();
        u32::from(is_done)
    })
}
