//! The functions that a page calls.
//!
//! The page writes bytes to the memory from [`reserve`], calls a function, and reads the output at [`output`] with
//! length [`output_length`]. Functions return 1 on success, otherwise 0; the output is then a message.

use std::cell::RefCell;

use crate::named_values::NamedValues;
use crate::simulator::Simulator;

thread_local! {
    static STATE: RefCell<State> = RefCell::default();
}

/// The state between two calls.
#[derive(Default)]
struct State {
    input: Vec<u8>,
    output: Vec<u8>,
    simulator: Option<Simulator>,
}

/// Reserves memory for `length` bytes of input.
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

/// The number of bytes of the last output.
#[allow(unsafe_code, reason = "the page calls it by its name")]
#[unsafe(no_mangle)]
pub extern "C" fn output_length() -> usize {
    STATE.with_borrow(|state| state.output.len())
}

/// Loads the derived scene in the input; the output contains its parameters as JSON.
#[allow(unsafe_code, reason = "the page calls it by its name")]
#[unsafe(no_mangle)]
pub extern "C" fn load() -> u32 {
    answer(|state| {
        let simulator = Simulator::new(&state.input)?;
        let json = simulator.scene_json()?;
        state.simulator = Some(simulator);
        Ok(json)
    })
}

/// Runs the scene with the values in the input, a line `NAME=VALUE` each; the output is the motion as JSON.
#[allow(unsafe_code, reason = "the page calls it by its name")]
#[unsafe(no_mangle)]
pub extern "C" fn run() -> u32 {
    answer(|state| {
        let changed = NamedValues::new(&state.input)?;
        state.simulator.as_mut().ok_or(NO_SCENE)?.run(changed)
    })
}

/// Works like [`run`], but with fewer steps and no error estimate, for a motion that ends at about `end`.
#[allow(unsafe_code, reason = "the page calls it by its name")]
#[unsafe(no_mangle)]
pub extern "C" fn draft(end: f64) -> u32 {
    answer(|state| {
        let changed = NamedValues::new(&state.input)?;
        state.simulator.as_mut().ok_or(NO_SCENE)?.draft(changed, end)
    })
}

/// Evaluates the last motion at a time; the output, as JSON, contains both components of each node and of each arrow,
/// the angle of each block, and the value of each curve.
#[allow(unsafe_code, reason = "the page calls it by its name")]
#[unsafe(no_mangle)]
pub extern "C" fn at(t: f64) -> u32 {
    answer(|state| state.simulator.as_mut().ok_or(NO_SCENE)?.at(t))
}

/// Drags points, a line `NAME=WEIGHT` of the input each, towards a position. The drag begins at the pose at time `t` of
/// the last motion, or at the end of the last drag if `t` is not a number; the output is the new start as JSON.
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
