//! Detection of changes of a file.

use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::{Duration, SystemTime};

use notify::{Event, RecommendedWatcher, RecursiveMode, Watcher};

/// The interval between two checks of the file's date, for systems and folders without events.
const DATE_INTERVAL: Duration = Duration::from_millis(250);

/// Watches a file.
pub(super) struct FileWatcher {
    path: PathBuf,
    events: Receiver<()>,
    seen: Option<(SystemTime, u64)>,
    /// Sends events while it exists; `None` if the system has none.
    _watcher: Option<RecommendedWatcher>,
}

impl FileWatcher {
    pub(super) fn new(path: &Path) -> Self {
        let (sender, events) = channel();
        // The folder is watched, since editors replace the file by a new one.
        let name = path.file_name().map(ToOwned::to_owned);
        let send = move |event: notify::Result<Event>| {
            // Reading the file is also an event, and must not trigger another reading.
            let is_change = |event: Event| {
                !event.kind.is_access() && event.paths.iter().any(|path| path.file_name() == name.as_deref())
            };
            if event.is_ok_and(is_change) {
                let _ = sender.send(());
            }
        };
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let watch =
            |mut watcher: RecommendedWatcher| watcher.watch(folder, RecursiveMode::NonRecursive).ok().map(|()| watcher);
        let watcher = notify::recommended_watcher(send).ok().and_then(watch);
        Self { path: path.to_owned(), events, seen: None, _watcher: watcher }
    }

    /// Waits for a change, at most `max_wait` plus a quarter of a second; returns whether the file may have changed.
    pub(super) fn wait(&mut self, max_wait: Duration) -> bool {
        let has_event = match self.events.recv_timeout(max_wait.min(DATE_INTERVAL)) {
            Ok(()) => true,
            Err(RecvTimeoutError::Timeout) => false,
            Err(RecvTimeoutError::Disconnected) => {
                std::thread::sleep(max_wait.min(DATE_INTERVAL));
                false
            }
        };
        let mut seen = self.look();
        if seen != self.seen && seen.is_some_and(|(_, length)| length == 0) {
            // Editors that write in place truncate the file first.
            let _ = self.events.recv_timeout(DATE_INTERVAL);
            seen = self.look();
        }
        let has_other_date = seen != self.seen;
        self.seen = seen;
        has_event || has_other_date
    }

    /// The date and length of the file; discards all earlier events.
    fn look(&self) -> Option<(SystemTime, u64)> {
        while self.events.try_recv().is_ok() {}
        let data = std::fs::metadata(&self.path).ok()?;
        Some((data.modified().ok()?, data.len()))
    }
}
