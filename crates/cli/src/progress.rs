//! Shows that a long command goes on, and lets the user end it.

use std::cell::Cell;
use std::io::{self, IsTerminal};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressFinish, ProgressStyle};
use qrm_sim::run::{Observer, Row};

/// The time that a run goes on in silence before it shows its progress.
const PROGRESS_DELAY: Duration = Duration::from_millis(300);

/// Set when the user wants the command to end.
static INTERRUPTED: AtomicBool = AtomicBool::new(false);

thread_local! {
    /// How a program that embeds the command learns of interrupts; unused by the command itself.
    static EMBEDDER: Cell<Option<fn() -> bool>> = const { Cell::new(None) };
}

/// Whether the user wants the command to end.
pub(crate) fn interrupted() -> bool {
    INTERRUPTED.load(Ordering::Relaxed) || EMBEDDER.get().is_some_and(|check| check())
}

/// Does some work that ends when `check` returns true, on this thread. No handler of signals is installed meanwhile,
/// and no progress is shown.
pub(crate) fn interruptible<T>(check: fn() -> bool, work: impl FnOnce() -> T) -> T {
    /// Restores what was there before, also when the work panics.
    struct Restored(Option<fn() -> bool>);
    impl Drop for Restored {
        fn drop(&mut self) {
            EMBEDDER.set(self.0);
        }
    }
    let _restored = Restored(EMBEDDER.replace(Some(check)));
    work()
}

/// Takes note of interrupts from now on.
pub(crate) fn watch_interrupts() {
    if EMBEDDER.get().is_some() {
        return;
    }
    // A second handler in one process is refused; the first one is enough.
    let _ = ctrlc::set_handler(|| {
        // Who asks twice does not want to wait for the end of what is under way.
        if INTERRUPTED.swap(true, Ordering::Relaxed) {
            std::process::exit(130);
        }
    });
}

/// The progress of a command, shown on a terminal alone.
pub(crate) struct Progress {
    bar: ProgressBar,
    begun: Instant,
    /// The number of motions, one after the other.
    count: u32,
    /// Motions that have ended, and the time of the one under way.
    done: Cell<(u32, f64)>,
}

impl Progress {
    /// The progress of a motion.
    pub(crate) fn new() -> Self {
        Self::motions(1)
    }

    /// The progress of motions, one after the other. A short one is not shown.
    pub(crate) fn motions(count: usize) -> Self {
        watch_interrupts();
        let count = u32::try_from(count).unwrap_or(u32::MAX);
        Self { count, ..Self::hidden(10_000, "{bar:40} {msg}, {eta} left") }
    }

    /// The progress of designs, some of which are done.
    pub(crate) fn designs(count: usize, done: usize) -> Self {
        let progress = Self::hidden(count as u64, "{bar:40} {pos} of {len} designs, {per_sec}, {eta} left");
        progress.bar.set_position(done as u64);
        progress.reveal();
        progress
    }

    /// A sign of life with a text.
    pub(crate) fn spinner() -> Self {
        let progress = Self::hidden(0, "{spinner} {elapsed} {msg}");
        progress.reveal();
        progress
    }

    fn hidden(length: u64, template: &str) -> Self {
        let style = ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar());
        let bar = ProgressBar::with_draw_target(Some(length), ProgressDrawTarget::hidden());
        let bar = bar.with_style(style).with_finish(ProgressFinish::AndClear);
        Self { bar, begun: Instant::now(), count: 1, done: Cell::default() }
    }

    fn reveal(&self) {
        if self.bar.is_hidden() && io::stderr().is_terminal() && EMBEDDER.get().is_none() {
            self.bar.set_draw_target(ProgressDrawTarget::stderr());
        }
    }

    /// Shows the progress of the motion under way; false once the user wants the command to end.
    pub(crate) fn keep_running(&self, t: f64, end_time: f64) -> bool {
        let (done, last) = self.done.get();
        // Time begins anew with each motion.
        let done = if t < last { done + 1 } else { done };
        self.done.set((done, t));
        if self.begun.elapsed() > PROGRESS_DELAY {
            self.reveal();
            let part = (f64::from(done) + t / end_time) / f64::from(self.count);
            self.bar.set_position((1e4 * part) as u64);
            self.bar.set_message(match self.count {
                1 => format!("t = {t:.3} of {end_time:.3} s"),
                count => format!("motion {} of {count}", done + 1),
            });
        }
        !interrupted()
    }

    /// Counts designs that are done.
    pub(crate) fn add(&self, count: usize) {
        self.bar.inc(count as u64);
    }

    /// Shows a text.
    pub(crate) fn show(&self, text: String) {
        self.bar.set_message(text);
        self.bar.tick();
    }
}

impl Observer for Progress {
    fn row(&mut self, _row: &Row) -> io::Result<()> {
        Ok(())
    }

    fn keep_running(&mut self, t: f64, end_time: f64) -> io::Result<bool> {
        Ok(Self::keep_running(self, t, end_time))
    }
}
