//! The simulator of a page: a derived scene that runs in a browser, by the crates of the command.
//!
//! The page writes bytes to the memory that [`reserve`] gives, calls a function, and reads what [`output`] and
//! [`output_length`] say. Functions give 1 if they did what was asked, else 0; the output is then a message.
//!
//! They have their names in WebAssembly alone: other libraries that contain this crate must not show them.

mod requested;
mod simulator;

use std::cell::RefCell;

use requested::Requested;
use simulator::Simulator;
pub use simulator::packed;

/// This crate as a module of WebAssembly, compressed by gzip: `page/build` makes it.
#[cfg(not(target_family = "wasm"))]
pub const MODULE: &[u8] = include_bytes!("../simulator.wasm.gz");

thread_local! {
    static STATE: RefCell<State> = RefCell::default();
}

/// What lives between two calls.
#[derive(Default)]
struct State {
    input: Vec<u8>,
    output: Vec<u8>,
    simulator: Option<Simulator>,
}

/// Room for so many bytes of input.
#[allow(unsafe_code, reason = "the page calls it by its name")]
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
pub extern "C" fn reserve(length: usize) -> *mut u8 {
    STATE.with_borrow_mut(|state| {
        state.input = vec![0; length];
        state.input.as_mut_ptr()
    })
}

/// The output of the last call.
#[allow(unsafe_code, reason = "the page calls it by its name")]
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
pub extern "C" fn output() -> *const u8 {
    STATE.with_borrow(|state| state.output.as_ptr())
}

/// The number of bytes of that output.
#[allow(unsafe_code, reason = "the page calls it by its name")]
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
pub extern "C" fn output_length() -> usize {
    STATE.with_borrow(|state| state.output.len())
}

/// Takes the derived scene of the input; the output tells its parameters as JSON.
#[allow(unsafe_code, reason = "the page calls it by its name")]
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
pub extern "C" fn load() -> u32 {
    answer(|state| {
        let simulator = Simulator::new(&state.input)?;
        let about = simulator.about()?;
        state.simulator = Some(simulator);
        Ok(about)
    })
}

/// Runs the scene with the values of the input, a line `NAME=VALUE` each; the output is the motion as JSON. A draft has
/// no estimate of its error.
#[allow(unsafe_code, reason = "the page calls it by its name")]
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
pub extern "C" fn run(is_draft: u32) -> u32 {
    answer(|state| {
        let requested = Requested::new(&state.input)?;
        let simulator = state.simulator.as_ref().ok_or("no scene has been loaded")?;
        simulator.run(&requested, is_draft != 0)
    })
}

fn answer(work: impl FnOnce(&mut State) -> Result<String, String>) -> u32 {
    STATE.with_borrow_mut(|state| {
        let result = work(state);
        let is_done = result.is_ok();
        state.output = result.unwrap_or_else(|message| message).into_bytes();
        u32::from(is_done)
    })
}
