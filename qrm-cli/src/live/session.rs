//! From the text of a scene file to what pages show, again and again.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};

use qrm_core::{DerivedScene, Model};
use qrm_scene::resolve;
use qrm_scene::scene::Scene;
use qrm_scene::source::read_text;

use super::derivation_key::DerivationKey;
use super::feed::Feed;
use super::watch::Watch;
use crate::page_data::packed;
use crate::progress::interrupted;
use crate::scenes::cache::Entry;
use crate::scenes::engine::{Derivation, Engine, PATIENCE};
use crate::scenes::model_of_text;

/// Editors save in pieces: what is wrong for a shorter time is not shown.
const PIECES: Duration = Duration::from_millis(100);
/// A derivation that takes longer is told of.
const SILENCE: Duration = Duration::from_millis(500);
/// How often it is looked whether the user wants to end.
const PERIOD: Duration = Duration::from_millis(250);

/// Follows a scene file.
pub(crate) struct Session {
    models: &'static [Model],
    path: PathBuf,
    feed: Arc<Feed>,
    /// What the file held when it was last read.
    text: Result<String, String>,
    /// The last scene that was derived.
    derived: Option<(DerivationKey, DerivedScene)>,
    /// A process that is there before it is needed.
    engine: Option<Engine>,
    under_way: Option<UnderWay>,
    /// What is wrong with the text, and when it was read.
    mistake: Option<(Instant, String)>,
    /// What became of the derivation before.
    note: Option<String>,
}

/// A derivation of a text.
struct UnderWay {
    derivation: Derivation,
    text: String,
    scene: Scene,
    begun: Instant,
    is_shown: bool,
    is_told: bool,
}

impl Session {
    /// Of a scene file.
    pub(crate) fn new(models: &'static [Model], path: PathBuf, feed: Arc<Feed>) -> Self {
        let text = Err(String::new());
        Self { models, path, feed, text, derived: None, engine: None, under_way: None, mistake: None, note: None }
    }

    /// Shows a text that is in no file.
    pub(crate) fn show_text(&mut self, text: &str) {
        self.show_or_derive(text.to_owned());
    }

    /// Follows the file until the user wants to end.
    pub(crate) fn follow(&mut self) {
        let mut watch = Watch::new(&self.path);
        while !interrupted() {
            if watch.wait(self.patience()) {
                self.read();
            }
            self.show_mistake();
            self.poll_derivation();
        }
    }

    /// How long nothing can happen but a change of the file.
    fn patience(&self) -> Duration {
        match (&self.under_way, &self.mistake) {
            (Some(_), _) => PATIENCE,
            (None, Some((read, _))) => PIECES.saturating_sub(read.elapsed()),
            _ => PERIOD,
        }
    }

    fn read(&mut self) {
        let text = read_text(&self.path).map_err(|report| report.render(false));
        if text == self.text {
            return;
        }
        self.text.clone_from(&text);
        match text {
            Ok(text) => self.show_or_derive(text),
            Err(mistake) => {
                self.cancel();
                self.mistake = Some((Instant::now(), mistake));
            }
        }
    }

    /// Shows the scene of a text, or begins to derive it.
    fn show_or_derive(&mut self, text: String) {
        self.mistake = None;
        self.cancel();
        let scene = match resolve::read(&self.path.display().to_string(), &text) {
            Ok((scene, _)) => scene,
            Err(report) => {
                self.mistake = Some((Instant::now(), report.render(false)));
                return;
            }
        };
        if let Some(model) = model_of_text(self.models, &text) {
            return self.show(DerivedScene::of(model), scene);
        }
        let key = DerivationKey::of(&text, &scene);
        if let Some((_, derived)) = self.derived.as_ref().filter(|(own, _)| *own == key) {
            return self.show(derived.clone(), scene);
        }
        if let Some(derived) = Entry::of(&text).read(&text) {
            self.derived = Some((key, derived.clone()));
            return self.show(derived, scene);
        }
        let engine = self.engine.take().map_or_else(|| Engine::start(&self.path), Ok);
        match engine {
            Ok(engine) => {
                let (derivation, begun) = (engine.derive(&text), Instant::now());
                self.under_way = Some(UnderWay { derivation, text, scene, begun, is_shown: false, is_told: false });
                if self.note.is_some() {
                    self.show_beside(None);
                }
            }
            Err(error) => self.show_beside(Some(error.to_string())),
        }
    }

    /// Ends the derivation that is under way. Whoever was told that it goes on is told that it does not.
    fn cancel(&mut self) {
        if let Some(under_way) = self.under_way.take().filter(|under_way| under_way.is_told) {
            let seconds = under_way.begun.elapsed().as_secs_f64();
            self.note = Some(format!("the derivation of the text before this one was cancelled after {seconds:.1} s"));
        }
    }

    /// Shows what is wrong with the file, if it stays as it is.
    fn show_mistake(&mut self) {
        if let Some((_, mistake)) = self.mistake.take_if(|(read, _)| read.elapsed() >= PIECES) {
            self.show_beside(Some(mistake));
        }
    }

    /// Looks how far the derivation has come.
    fn poll_derivation(&mut self) {
        let Some(mut under_way) = self.under_way.take() else { return };
        if !under_way.is_shown
            && let Some(derived) = under_way.derivation.unverified()
        {
            under_way.is_shown = true;
            self.show(derived, under_way.scene.clone());
        }
        let Some(result) = under_way.derivation.result(&Entry::of(&under_way.text)) else {
            if !under_way.is_shown && !under_way.is_told && under_way.begun.elapsed() > SILENCE {
                under_way.is_told = true;
                self.note = Some("the scene is being derived; saving it again begins anew".to_owned());
                self.show_beside(None);
            }
            self.under_way = Some(under_way);
            return;
        };
        match result {
            Ok(derived) => {
                let UnderWay { text, scene, is_shown, .. } = under_way;
                self.derived = Some((DerivationKey::of(&text, &scene), derived.clone()));
                if !is_shown {
                    self.show(derived, scene);
                }
            }
            Err(error) => self.show_beside(Some(error.to_string())),
        }
        self.engine = Engine::start(&self.path).ok();
    }

    fn show(&mut self, derived: DerivedScene, scene: Scene) {
        match packed(derived, scene) {
            Ok(scene) => self.feed.show_scene(scene, self.note.take()),
            Err(error) => self.show_beside(Some(error.to_string())),
        }
    }

    fn show_beside(&mut self, problem: Option<String>) {
        self.feed.show_beside(problem, self.note.take());
    }
}
