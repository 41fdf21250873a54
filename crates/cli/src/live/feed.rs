//! The feed of content for pages.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use serde::Serialize;

/// The feed of content for pages. It keeps only the latest state: a slow page skips intermediate ones.
#[derive(Default)]
pub(crate) struct Feed {
    latest: Mutex<Latest>,
    is_new: Condvar,
    /// Whether a page edits the scene.
    is_edited: AtomicBool,
}

#[derive(Default)]
struct Latest {
    version: u64,
    scene_version: u64,
    shown: Shown,
}

/// The content of a page.
#[derive(Default, Serialize)]
struct Shown {
    /// The scene in the simulator's format, in base 91.
    #[serde(skip)]
    scene: String,
    /// The error in the text of the scene, if there is one.
    problem: Option<String>,
    /// A message about the progress of a derivation, if there is one.
    note: Option<String>,
}

/// The answer to a page with older versions.
#[derive(Serialize)]
struct News<'a> {
    version: u64,
    scene_version: u64,
    #[serde(skip_serializing_if = "Option::is_none")]
    scene: Option<&'a str>,
    #[serde(flatten)]
    shown: &'a Shown,
}

impl Feed {
    /// Notes that a page edits the scene.
    pub(super) fn begin_editing(&self) {
        self.is_edited.store(true, Ordering::Relaxed);
    }

    /// Whether a page edits the scene.
    pub(super) fn is_edited(&self) -> bool {
        self.is_edited.load(Ordering::Relaxed)
    }

    /// Replaces the scene.
    pub(super) fn show_scene(&self, scene: String, note: Option<String>) {
        let mut latest = self.lock();
        latest.scene_version += 1;
        latest.shown = Shown { scene, problem: None, note };
        self.announce(latest);
    }

    /// Shows a problem or a note together with the unchanged scene.
    pub(super) fn show_status(&self, problem: Option<String>, note: Option<String>) {
        let mut latest = self.lock();
        (latest.shown.problem, latest.shown.note) = (problem, note);
        self.announce(latest);
    }

    fn announce(&self, mut latest: MutexGuard<Latest>) {
        latest.version += 1;
        self.is_new.notify_all();
    }

    /// Waits for content that is newer than these versions; returns it as JSON, or `None` after the timeout.
    pub(super) fn after(&self, version: u64, scene_version: u64, timeout: Duration) -> Option<String> {
        let is_known = |latest: &mut Latest| latest.version == version;
        let waited = self.is_new.wait_timeout_while(self.lock(), timeout, is_known);
        let (latest, _) = waited.unwrap_or_else(PoisonError::into_inner);
        if latest.version == version {
            return None;
        }
        let is_other = latest.scene_version != scene_version;
        let news = News {
            version: latest.version,
            scene_version: latest.scene_version,
            scene: is_other.then_some(&latest.shown.scene),
            shown: &latest.shown,
        };
        serde_json::to_string(&news).ok()
    }

    fn lock(&self) -> MutexGuard<'_, Latest> {
        self.latest.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
