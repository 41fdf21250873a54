//! Turns the text of a scene file into the content of pages.

use std::collections::VecDeque;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};

use qrm_core::{DerivedScene, Model};
use qrm_scene::resolve;
use qrm_scene::scene::Scene;
use qrm_scene::source::read_text;

use super::derivation_key::DerivationKey;
use super::edit::length_parameters::with_length_parameters;
use super::feed::Feed;
use super::file_watcher::FileWatcher;
use crate::packing::packed;
use crate::progress::interrupted;
use crate::scenes::cache::Entry;
use crate::scenes::engine::{Derivation, Engine, POLL_INTERVAL, build_if_missing};
use crate::scenes::model_of_text;

/// The time for which an error must persist before it is shown: editors write a file in pieces.
const DEBOUNCE: Duration = Duration::from_millis(100);
/// The time after which a derivation is announced.
const NOTICE_DELAY: Duration = Duration::from_millis(500);
/// The largest number of scenes that one session keeps in the cache.
const MAX_STORED: usize = 16;

/// Follows a scene file.
pub(crate) struct Session {
    models: &'static [Model],
    path: PathBuf,
    feed: Arc<Feed>,
    /// The text of the file at the last reading, or the error of that.
    text: Result<String, String>,
    /// Whether lengths and angles of links are parameters.
    has_length_parameters: bool,
    /// The last derived scene.
    derived: Option<(DerivationKey, DerivedScene)>,
    /// An engine started in advance.
    engine: Option<Engine>,
    pending: Option<PendingDerivation>,
    /// An error that is not shown yet, and the time at which it was read.
    mistake: Option<(Instant, String)>,
    /// The next message to the pages about a derivation.
    note: Option<String>,
    /// The scenes that this session stored in the cache, oldest first.
    stored: VecDeque<Entry>,
}

/// A derivation in progress.
struct PendingDerivation {
    derivation: Derivation,
    key: DerivationKey,
    entry: Entry,
    /// The scene of the latest text with this key.
    scene: Scene,
    begun: Instant,
    is_shown: bool,
    is_announced: bool,
}

impl Session {
    /// Creates a session for a scene file.
    pub(crate) fn new(models: &'static [Model], path: PathBuf, feed: Arc<Feed>) -> Self {
        let text = Err(String::new());
        let (derived, engine, pending, mistake, note) = (None, None, None, None, None);
        let (has_length_parameters, stored) = (false, VecDeque::new());
        Self { models, path, feed, text, has_length_parameters, derived, engine, pending, mistake, note, stored }
    }

    /// Shows a text that is not in a file.
    pub(crate) fn show_text(&mut self, text: &str) {
        self.show_or_derive(text);
    }

    /// Follows the file until the user ends the program, or `is_over` returns true.
    pub(crate) fn follow(&mut self, is_over: impl Fn() -> bool) {
        let mut watch = FileWatcher::new(&self.path);
        self.engine = Engine::start(&self.path).ok();
        self.read();
        while !interrupted() && !is_over() {
            if watch.wait(self.max_wait()) {
                self.read();
            }
            self.begin_editing();
            self.show_mistake();
            self.poll_derivation();
        }
    }

    /// The time until the next action other than a change of the file.
    fn max_wait(&self) -> Duration {
        match (&self.pending, &self.mistake) {
            (Some(_), _) => POLL_INTERVAL,
            (None, Some((read, _))) => DEBOUNCE.saturating_sub(read.elapsed()),
            (None, None) => Duration::MAX,
        }
    }

    fn read(&mut self) {
        let text = read_text(&self.path).map_err(|report| report.render(false));
        if text == self.text {
            return;
        }
        match &text {
            Ok(text) => self.show_or_derive(text),
            Err(mistake) => {
                self.cancel();
                self.mistake = Some((Instant::now(), mistake.clone()));
            }
        }
        self.text = text;
    }

    /// Derives the scene with its lengths as parameters when a page begins to edit it.
    fn begin_editing(&mut self) {
        if !self.has_length_parameters && self.feed.is_edited() {
            self.has_length_parameters = true;
            if let Ok(text) = self.text.clone() {
                self.show_or_derive(&text);
            }
        }
    }

    /// Shows the scene of a text, or starts its derivation.
    fn show_or_derive(&mut self, text: &str) {
        self.mistake = None;
        let scene = match resolve::read(&self.path.display().to_string(), text) {
            Ok((scene, _)) => scene,
            Err(report) => {
                self.cancel();
                self.mistake = Some((Instant::now(), report.render(false)));
                return;
            }
        };
        let (text, scene) = self.parametrized(text, scene);
        let text = text.as_str();
        let key = DerivationKey::new(text, &scene);
        if let Some(pending) = self.pending.as_mut().filter(|pending| pending.key == key) {
            pending.scene = scene;
            pending.is_shown = false;
            return;
        }
        self.cancel();
        if let Some(derived) = self.known_scene(text, &key) {
            self.derived = Some((key, derived.clone()));
            return self.show(derived, scene);
        }
        let waiting = self.engine.take().and_then(Engine::usable);
        let started = match waiting {
            Some(engine) => Ok(engine),
            None => {
                let built = build_if_missing(|text| {
                    self.note = Some(text.to_owned());
                    self.show_status(None);
                });
                built.and_then(|()| Engine::start(&self.path))
            }
        };
        match started {
            Ok(engine) => {
                self.pending = Some(PendingDerivation {
                    derivation: engine.derive(text),
                    key,
                    entry: Entry::new(text),
                    scene,
                    begun: Instant::now(),
                    is_shown: false,
                    is_announced: false,
                });
                if self.note.is_some() {
                    self.show_status(None);
                }
            }
            Err(error) => self.show_status(Some(error.to_string())),
        }
    }

    /// The text and the scene with lengths and angles of links as parameters, if a page edits it.
    fn parametrized(&self, text: &str, scene: Scene) -> (String, Scene) {
        let text_with_parameters = if self.has_length_parameters { with_length_parameters(text) } else { None };
        let resolved = text_with_parameters.and_then(|text| {
            let (scene, _) = resolve::read(&self.path.display().to_string(), &text).ok()?;
            Some((text, scene))
        });
        resolved.unwrap_or_else(|| (text.to_owned(), scene))
    }

    /// The derived scene of a text, if it is known: the last scene with other parameter values, a scene of the program,
    /// or one of the cache.
    fn known_scene(&self, text: &str, key: &DerivationKey) -> Option<DerivedScene> {
        let last = self.derived.as_ref().filter(|(own, _)| own == key).map(|(_, derived)| derived.clone());
        let built_in = || model_of_text(self.models, text).map(DerivedScene::from_model);
        last.or_else(built_in).or_else(|| Entry::new(text).read(text))
    }

    /// Cancels the derivation in progress, and updates pages that show it.
    fn cancel(&mut self) {
        let Some(pending) = self.pending.take() else { return };
        if pending.is_announced {
            let seconds = pending.begun.elapsed().as_secs_f64();
            self.note = Some(format!("the derivation of the text before this one was cancelled after {seconds:.1} s"));
        }
        self.engine = Engine::start(&self.path).ok();
    }

    /// Shows the error in the file, if it has persisted.
    fn show_mistake(&mut self) {
        if let Some((_, mistake)) = self.mistake.take_if(|(read, _)| read.elapsed() >= DEBOUNCE) {
            self.show_status(Some(mistake));
        }
    }

    /// Shows the result of the derivation in progress, or announces that it takes long.
    fn poll_derivation(&mut self) {
        let Some(mut pending) = self.pending.take() else { return };
        if !pending.is_shown
            && let Some(derived) = pending.derivation.unverified()
        {
            pending.is_shown = true;
            self.show(derived, pending.scene.clone());
        }
        let Some(result) = pending.derivation.result() else {
            if !pending.is_shown && !pending.is_announced && pending.begun.elapsed() > NOTICE_DELAY {
                pending.is_announced = true;
                let text = match pending.derivation.is_waiting() {
                    true => "another derivation on this machine goes first; this scene follows when it is over",
                    false => "the scene is being derived; saving it again restarts that",
                };
                self.note = Some(text.to_owned());
                self.show_status(None);
            }
            self.pending = Some(pending);
            return;
        };
        match result {
            Ok(derived) => {
                self.derived = Some((pending.key, derived.clone()));
                self.keep(pending.entry);
                if !pending.is_shown {
                    self.show(derived, pending.scene);
                }
            }
            Err(error) => self.show_status(Some(error.to_string())),
        }
        self.engine = Engine::start(&self.path).ok();
    }

    /// Keeps a scene in the cache; removes the oldest one of this session if there are too many.
    fn keep(&mut self, entry: Entry) {
        self.stored.push_back(entry);
        if self.stored.len() > MAX_STORED
            && let Some(oldest) = self.stored.pop_front()
        {
            oldest.remove();
        }
    }

    fn show(&mut self, derived: DerivedScene, scene: Scene) {
        match packed(derived, scene) {
            Ok(scene) => self.feed.show_scene(scene, self.note.take()),
            Err(error) => self.show_status(Some(error.to_string())),
        }
    }

    fn show_status(&mut self, problem: Option<String>) {
        self.feed.show_status(problem, self.note.take());
    }
}
