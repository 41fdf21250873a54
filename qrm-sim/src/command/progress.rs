//! Shows that a long run goes on, and lets the user end it.

use std::io::{self, IsTerminal};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

use crate::observer::{Observer, Row};

/// How long a run goes on in silence before it shows its progress.
const SILENCE: Duration = Duration::from_millis(300);

/// Set when the user wants the run to end.
static INTERRUPTED: AtomicBool = AtomicBool::new(false);

/// Whether the user wants it to end.
pub(super) fn interrupted() -> bool {
    INTERRUPTED.load(Ordering::Relaxed)
}

/// An observer that keeps no rows.
pub(super) struct Progress {
    begun: Instant,
    bar: Option<ProgressBar>,
}

impl Progress {
    pub(super) fn new() -> Self {
        // A second handler in one process is refused; the first one does.
        let _ = ctrlc::set_handler(|| {
            // Who asks twice does not want to wait for the end of what is under way.
            if INTERRUPTED.swap(true, Ordering::Relaxed) {
                std::process::exit(130);
            }
        });
        Self { begun: Instant::now(), bar: None }
    }
}

impl Observer for Progress {
    fn row(&mut self, _row: &Row) -> io::Result<()> {
        Ok(())
    }

    fn goes_on(&mut self, t: f64, end_time: f64) -> io::Result<bool> {
        if self.bar.is_none() && self.begun.elapsed() > SILENCE && io::stderr().is_terminal() {
            let style = ProgressStyle::with_template("{bar:40} t = {msg} s, {eta} left").map_err(io::Error::other)?;
            self.bar = Some(ProgressBar::new(10_000).with_style(style));
        }
        if let Some(bar) = &self.bar {
            bar.set_position((1e4 * t / end_time) as u64);
            bar.set_message(format!("{t:.3} of {end_time:.3}"));
        }
        Ok(!interrupted())
    }

    fn finish(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}
