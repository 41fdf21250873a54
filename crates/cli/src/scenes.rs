//! Finds scenes by name, and scene files.

pub(crate) mod cache;
pub(crate) mod engine;
mod output_file;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

use qrm_core::{Description, Model};
use qrm_scene::names::suggestion;
use qrm_scene::resolve;
use qrm_scene::scene::Scene;
use qrm_scene::source::read_text;

use crate::error::Error;
use crate::options::SceneName;
use crate::output::protect;

/// A scene named on the command line.
#[derive(Clone, Debug)]
pub(crate) struct FoundScene {
    /// The derived functions of the scene.
    pub(crate) model: &'static Model,
    /// The path of the scene file, as the user typed it.
    pub(crate) path: String,
    /// The scene with its own parameter values; `None` if it has not been read yet.
    pub(crate) scene: Option<Arc<Scene>>,
}

/// The source of a named scene.
pub(crate) enum SceneSource {
    /// A scene of the program.
    Model(&'static Model),
    /// A scene file.
    File(PathBuf),
}

impl FoundScene {
    /// A scene of the program, which has not been read yet.
    pub(crate) fn from_model(model: &'static Model) -> Self {
        Self { model, path: path_of(model.description), scene: None }
    }

    /// The scene with its own parameter values, which is read unless it was.
    pub(crate) fn read(&self) -> Result<Arc<Scene>, Error> {
        match &self.scene {
            Some(scene) => Ok(scene.clone()),
            None => Ok(Arc::new(resolve::read(&self.path, self.model.description.source)?.0)),
        }
    }
}

impl SceneName {
    /// Finds the source with this name.
    pub(crate) fn source(&self, models: &'static [Model]) -> Result<SceneSource, Error> {
        let Self { scene } = self;
        if is_path(models, scene) {
            return Ok(SceneSource::File(scene.into()));
        }
        model_named(models, scene, &[]).map(SceneSource::Model)
    }

    /// Finds the scene with this name, or in a file. A file is read once.
    pub(crate) fn find(&self, models: &'static [Model]) -> Result<FoundScene, Error> {
        match self.source(models)? {
            SceneSource::Model(model) => Ok(FoundScene::from_model(model)),
            SceneSource::File(path) => scene_of_file(models, &path),
        }
    }
}

/// Whether the name of a scene is a path.
pub(crate) fn is_path(models: &[Model], name: &str) -> bool {
    let is_scene = models.iter().any(|model| model.description.name == name);
    !is_scene && (name.ends_with(".toml") || name.contains(['/', '\\']) || Path::new(name).exists())
}

/// The file of a scene of the program.
pub(crate) fn path_of(description: &Description) -> String {
    format!("scenes/{}.toml", description.name)
}

/// Finds a scene of the program by name; `others` are further valid names for the error message.
pub(crate) fn model_named(models: &'static [Model], name: &str, others: &[&str]) -> Result<&'static Model, Error> {
    models.iter().find(|model| model.description.name == name).ok_or_else(|| {
        let own = models.iter().map(|model| model.description.name);
        let names: Vec<&str> = own.chain(others.iter().copied()).collect();
        let help = suggestion(name, names.iter().copied(), || {
            format!("scenes: {}; or the path of a scene file", names.join(", "))
        });
        Error::usage(format!("there is no scene `{name}`")).help(help)
    })
}

/// The files read so far, each read once.
static READ: Mutex<BTreeMap<PathBuf, FoundScene>> = Mutex::new(BTreeMap::new());

/// The scene of a file.
fn scene_of_file(models: &'static [Model], path: &Path) -> Result<FoundScene, Error> {
    let mut read = READ.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
    if let Some(found) = read.get(path) {
        return Ok(found.clone());
    }
    let found = scene_of_file_now(models, path)?;
    read.insert(path.to_owned(), found.clone());
    Ok(found)
}

/// The interpreted scenes by their texts. A model lives as long as the program.
static INTERPRETED: Mutex<BTreeMap<String, FoundScene>> = Mutex::new(BTreeMap::new());

/// The scene of a file's present content.
pub(crate) fn scene_of_file_now(models: &'static [Model], path: &Path) -> Result<FoundScene, Error> {
    let source = read_text(path)?;
    protect(path);
    scene_of_source(models, path, source)
}

/// The scene of a text, with a compiled model of the same text, or an interpreted one. Paths in the text are relative
/// to its file.
pub(crate) fn scene_of_source(models: &'static [Model], path: &Path, source: String) -> Result<FoundScene, Error> {
    let file = path.display().to_string();
    if let Some(model) = model_of_text(models, &source) {
        return Ok(FoundScene { model, path: file, scene: None });
    }
    let known = || INTERPRETED.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
    if let Some(found) = known().get(&source) {
        return Ok(FoundScene { path: file, ..found.clone() });
    }
    // Errors are reported without starting the engine.
    let (scene, _) = resolve::read(&file, &source)?;
    let derived = match cache::Entry::new(&source).read(&source) {
        Some(derived) => derived,
        None => engine::derive(path, &source)?,
    };
    let model = Box::leak(Box::new(derived.into_model()));
    let found = FoundScene { model, path: file.clone(), scene: Some(Arc::new(scene)) };
    Ok(FoundScene { path: file, ..known().entry(source).or_insert(found).clone() })
}

/// The scene of the program with this text.
pub(crate) fn model_of_text(models: &'static [Model], source: &str) -> Option<&'static Model> {
    models.iter().find(|model| model.description.source == source)
}
