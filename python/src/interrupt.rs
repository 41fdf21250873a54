//! Work without the interpreter's lock, that Ctrl-C ends.

use std::cell::RefCell;
use std::time::{Duration, Instant};

use pyo3::{PyErr, PyResult, Python};

/// The time between two looks at the signals: a look takes the interpreter's lock.
const INTERVAL: Duration = Duration::from_millis(10);

/// Does some work while other threads use the interpreter.
///
/// # Errors
/// A signal was raised, such as `KeyboardInterrupt`. What the work returned is dropped then.
pub(crate) fn detached<T: Send>(py: Python, work: impl FnOnce() -> T + Send) -> PyResult<T> {
    py.check_signals()?;
    let (value, raised) = py.detach(|| {
        WATCH.set(Watch { looked: Instant::now(), raised: None });
        let value = qrm_cli::api::interruptible(is_raised, work);
        (value, WATCH.with_borrow_mut(|watch| watch.raised.take()))
    });
    raised.map_or(Ok(value), Err)
}

/// The state of a thread that does such work.
struct Watch {
    looked: Instant,
    raised: Option<PyErr>,
}

thread_local! {
    static WATCH: RefCell<Watch> = RefCell::new(Watch { looked: Instant::now(), raised: None });
}

/// Whether a signal has been raised since the work began.
fn is_raised() -> bool {
    let is_due = WATCH.with_borrow(|watch| watch.raised.is_none() && watch.looked.elapsed() >= INTERVAL);
    if is_due {
        // A handler of signals may do such work too.
        let raised = Python::attach(|py| py.check_signals().err());
        WATCH.set(Watch { looked: Instant::now(), raised });
    }
    WATCH.with_borrow(|watch| watch.raised.is_some())
}
