//! Shows that a long command goes on, and lets the user end it.

use std::cell::{Cell, OnceCell};
use std::io::{self, IsTerminal};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};
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

/// A progress bar on a terminal; nothing elsewhere.
fn bar(length: u64, template: &str) -> ProgressBar {
    let style = ProgressStyle::with_template(template);
    match style {
        Ok(style) if io::stderr().is_terminal() && EMBEDDER.get().is_none() => {
            ProgressBar::new(length).with_style(style)
        }
        _ => ProgressBar::hidden(),
    }
}

/// An observer that shows the progress of a run, and ends it when it is interrupted.
pub(crate) struct Progress {
    begun: Instant,
    bar: Option<ProgressBar>,
}

impl Progress {
    pub(crate) fn new() -> Self {
        watch_interrupts();
        Self { begun: Instant::now(), bar: None }
    }
}

impl Observer for Progress {
    fn row(&mut self, _row: &Row) -> io::Result<()> {
        Ok(())
    }

    fn keep_running(&mut self, t: f64, end_time: f64) -> io::Result<bool> {
        if self.bar.is_none() && self.begun.elapsed() > PROGRESS_DELAY {
            self.bar = Some(bar(10_000, "{bar:40} t = {msg} s, {eta} left"));
        }
        if let Some(bar) = &self.bar {
            bar.set_position((1e4 * t / end_time) as u64);
            bar.set_message(format!("{t:.3} of {end_time:.3}"));
        }
        Ok(!interrupted())
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}

/// The progress of several motions, one after the other.
pub(crate) struct MotionProgress {
    begun: Instant,
    count: u32,
    /// Motions that have ended, and the time of the one under way.
    done: Cell<(u32, f64)>,
    bar: OnceCell<ProgressBar>,
}

impl MotionProgress {
    pub(crate) fn new(count: usize) -> Self {
        watch_interrupts();
        let count = u32::try_from(count).unwrap_or(u32::MAX);
        Self { begun: Instant::now(), count, done: Cell::default(), bar: OnceCell::new() }
    }

    /// Shows the progress of the motion under way; false once the user wants the command to end.
    pub(crate) fn keep_running(&self, t: f64, end_time: f64) -> bool {
        let (done, last) = self.done.get();
        // Time begins anew with each motion.
        let done = if t < last { done + 1 } else { done };
        self.done.set((done, t));
        if self.begun.elapsed() > PROGRESS_DELAY {
            let bar = self.bar.get_or_init(|| bar(10_000, "{bar:40} {msg}, {eta} left"));
            let part = (f64::from(done) + t / end_time) / f64::from(self.count);
            bar.set_position((1e4 * part) as u64);
            bar.set_message(format!("motion {} of {}", done + 1, self.count));
        }
        !interrupted()
    }
}

impl Drop for MotionProgress {
    fn drop(&mut self) {
        if let Some(bar) = self.bar.get() {
            bar.finish_and_clear();
        }
    }
}

/// The progress of designs that are run one after the other.
pub(crate) struct DesignProgress(ProgressBar);

impl DesignProgress {
    pub(crate) fn new(count: usize, done: usize) -> Self {
        let bar = bar(count as u64, "{bar:40} {pos} of {len} designs, {per_sec}, {eta} left");
        Self(bar.with_position(done as u64))
    }

    pub(crate) fn add(&self, count: usize) {
        self.0.inc(count as u64);
    }
}

impl Drop for DesignProgress {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}

/// A sign of life with a text.
pub(crate) struct Spinner(ProgressBar);

impl Spinner {
    pub(crate) fn new() -> Self {
        Self(bar(0, "{spinner} {elapsed} {msg}"))
    }

    pub(crate) fn show(&self, text: String) {
        self.0.set_message(text);
        self.0.tick();
    }
}

impl Drop for Spinner {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}
