//! A scene that is loaded.

use std::path::Path;
use std::sync::Arc;

use qrm_core::{Description, Model};
use qrm_scene::resolve;

use super::options::RunOptions;
use crate::error::Error;
use crate::options::SceneName;
use crate::scenes::{FoundScene, SceneSource, model_of_file_now, model_of_source, path_of};
use crate::setup::Setup;

/// A scene of the program, or one that was read from a file.
#[derive(Clone, Debug)]
pub struct LoadedScene {
    found: FoundScene,
}

impl LoadedScene {
    /// The scene of this name, or that of the file with this path as it is now.
    ///
    /// # Errors
    /// There is no such scene or file, or its scene is wrong or cannot be derived.
    pub fn load(models: &'static [Model], name: &str) -> Result<Self, Error> {
        let (model, path) = match (SceneName { scene: name.to_owned() }).source(models)? {
            SceneSource::Model(model) => (model, path_of(model.description)),
            SceneSource::File(path) => (model_of_file_now(models, &path)?, name.to_owned()),
        };
        Self::new(model, path)
    }

    /// The scene with this text, which was read from the file with this path, whatever is there now.
    ///
    /// # Errors
    /// The scene is wrong or cannot be derived.
    pub fn from_source(models: &'static [Model], path: &str, source: &str) -> Result<Self, Error> {
        Self::new(model_of_source(models, Path::new(path), source.to_owned())?, path.to_owned())
    }

    fn new(model: &'static Model, path: String) -> Result<Self, Error> {
        let (scene, _) = resolve::read(&path, model.description.source)?;
        Ok(Self { found: FoundScene { model, path, scene: Some(Arc::new(scene)) } })
    }

    /// Names, units and meanings.
    pub fn description(&self) -> &'static Description {
        self.found.model.description
    }

    /// The derived functions of the scene.
    pub fn model(&self) -> &'static Model {
        self.found.model
    }

    /// The path of the scene file, as the user knows it.
    pub fn path(&self) -> &Path {
        Path::new(&self.found.path)
    }

    /// The values of its parameters, in the order of the description.
    ///
    /// # Errors
    /// An option is wrong.
    pub fn parameters(&self, options: &RunOptions) -> Result<Vec<f64>, Error> {
        let setup = self.setup(options)?;
        let mut values = self.found.model.parameter_values(&setup.replace());
        values.truncate(self.description().parameters.len());
        Ok(values)
    }

    /// The scene as commands find it.
    pub(super) fn found(&self) -> FoundScene {
        self.found.clone()
    }

    /// The setup of a run.
    pub(crate) fn setup(&self, options: &RunOptions) -> Result<Setup, Error> {
        let (scene, start, method) = options.parsed()?;
        Setup::from_found(self.found(), &scene, &method)?.starting_from(&start)
    }
}
