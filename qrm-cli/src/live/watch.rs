//! Changes of a file.

use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::{Duration, SystemTime};

use notify::{Event, RecommendedWatcher, RecursiveMode, Watcher};

/// How often a file is looked at, where the system does not tell of changes.
const PERIOD: Duration = Duration::from_millis(250);

/// Watches a file.
pub(super) struct Watch {
    path: PathBuf,
    events: Receiver<()>,
    seen: Option<(SystemTime, u64)>,
    /// Tells of changes while it lives; `None` where the system cannot.
    _watcher: Option<RecommendedWatcher>,
}

impl Watch {
    pub(super) fn new(path: &Path) -> Self {
        let (sender, events) = channel();
        // Other files of the folder are cheap to look at, and editors put a new file in the place of the old one.
        let tell = move |event: notify::Result<Event>| {
            // Reading the file is an event too: it must not lead to the next reading. What is lost is looked for.
            if event.is_ok_and(|event| !event.kind.is_access()) {
                let _ = sender.send(());
            }
        };
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let watch =
            |mut watcher: RecommendedWatcher| watcher.watch(folder, RecursiveMode::NonRecursive).ok().map(|()| watcher);
        let watcher = notify::recommended_watcher(tell).ok().and_then(watch);
        Self { path: path.to_owned(), events, seen: None, _watcher: watcher }
    }

    /// Waits for a change, but not for longer than that; whether the file may have changed.
    pub(super) fn wait(&mut self, patience: Duration) -> bool {
        let is_told = match self.events.recv_timeout(patience.min(PERIOD)) {
            Ok(()) => true,
            Err(RecvTimeoutError::Timeout) => false,
            Err(RecvTimeoutError::Disconnected) => {
                std::thread::sleep(patience.min(PERIOD));
                false
            }
        };
        while self.events.try_recv().is_ok() {}
        let data = std::fs::metadata(&self.path).ok();
        let seen = data.and_then(|data| Some((data.modified().ok()?, data.len())));
        let is_other = seen != self.seen;
        self.seen = seen;
        is_told || is_other
    }
}
