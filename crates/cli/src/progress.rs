//! Shows the progress of long commands, and lets the user interrupt them.

use std::cell::Cell;
use std::io::{self, IsTerminal};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressFinish, ProgressStyle};
use qrm_sim::run::{Observer, Row};

/// The time after which a run shows its progress.
const PROGRESS_DELAY: Duration = Duration::from_millis(300);

/// Set when the user interrupts the command.
static INTERRUPTED: AtomicBool = AtomicBool::new(false);

thread_local! {
    /// The check for interrupts of a program that embeds the command; unused by the command itself.
    static EMBEDDER: Cell<Option<fn() -> bool>> = const { Cell::new(None) };
}

/// Whether the user has interrupted the command.
pub(crate) fn interrupted() -> bool {
    INTERRUPTED.load(Ordering::Relaxed) || EMBEDDER.get().is_some_and(|check| check())
}

/// Does some work on this thread that ends when `check` returns true. Meanwhile no signal handler is installed, and no
/// progress is shown.
pub(crate) fn interruptible<T>(check: fn() -> bool, work: impl FnOnce() -> T) -> T {
    /// Restores the previous check, even if the work panics.
    struct Restored(Option<fn() -> bool>);
    impl Drop for Restored {
        fn drop(&mut self) {
            EMBEDDER.set(self.0);
        }
    }
    let _restored = Restored(EMBEDDER.replace(Some(check)));
    work()
}

/// Starts to watch for interrupts.
pub(crate) fn watch_interrupts() {
    if EMBEDDER.get().is_some() {
        return;
    }
    // A second handler in one process is refused; the first one suffices.
    let _ = ctrlc::set_handler(|| {
        // A second interrupt ends the program immediately.
        if INTERRUPTED.swap(true, Ordering::Relaxed) {
            std::process::exit(130);
        }
    });
}

/// The progress of a command; shown on terminals only.
pub(crate) struct Progress {
    bar: ProgressBar,
    begun: Instant,
    /// The number of consecutive motions.
    count: u32,
    /// The number of completed motions, and the time of the current one.
    done: Cell<(u32, f64)>,
}

impl Progress {
    /// Creates the progress of a motion.
    pub(crate) fn new() -> Self {
        Self::motions(1)
    }

    /// Creates the progress of consecutive motions. A short one is not shown.
    pub(crate) fn motions(count: usize) -> Self {
        watch_interrupts();
        let count = u32::try_from(count).unwrap_or(u32::MAX);
        Self { count, ..Self::hidden(10_000, "{bar:40} {msg}, {eta} left") }
    }

    /// Creates the progress of designs, some of which are done.
    pub(crate) fn designs(count: usize, done: usize) -> Self {
        let progress = Self::hidden(count as u64, "{bar:40} {pos} of {len} designs, {per_sec}, {eta} left");
        progress.bar.set_position(done as u64);
        progress.reveal();
        progress
    }

    /// Creates the progress of points whose number is not known before.
    pub(crate) fn points() -> Self {
        let progress = Self::hidden(0, "{spinner} {elapsed} {pos} points");
        progress.reveal();
        progress
    }

    /// Creates a spinner with a text.
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

    /// Shows the progress of the current motion; returns false once the user has interrupted the command.
    pub(crate) fn keep_running(&self, t: f64, end_time: f64) -> bool {
        let (done, last) = self.done.get();
        // Each motion starts at time zero again.
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

    /// Counts completed designs.
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
