//! A loaded scene.

use std::path::Path;

use qrm_core::{Description, Model};

use super::options::RunOptions;
use crate::error::Error;
use crate::options::SceneName;
use crate::scenes::{FoundScene, SceneSource, scene_of_file_now, scene_of_source};
use crate::setup::Setup;

/// A scene of the program, or one read from a file.
#[derive(Clone, Debug)]
pub struct LoadedScene {
    found: FoundScene,
}

impl LoadedScene {
    /// Loads the scene with this name, or the present content of the file with this path.
    ///
    /// # Errors
    /// There is no such scene or file, or the scene has errors or cannot be derived.
    pub fn load(models: &'static [Model], name: &str) -> Result<Self, Error> {
        Self::new(match (SceneName { scene: name.to_owned() }).source(models)? {
            SceneSource::Model(model) => FoundScene::from_model(model),
            SceneSource::File(path) => scene_of_file_now(models, &path)?,
        })
    }

    /// Loads a scene from its text. The text belongs to the file with this path, whose present content does not matter.
    ///
    /// # Errors
    /// The scene has errors or cannot be derived.
    pub fn from_source(models: &'static [Model], path: &str, source: &str) -> Result<Self, Error> {
        Self::new(scene_of_source(models, Path::new(path), source.to_owned())?)
    }

    fn new(found: FoundScene) -> Result<Self, Error> {
        Ok(Self { found: FoundScene { scene: Some(found.read()?), ..found } })
    }

    /// Names, units and descriptions.
    pub fn description(&self) -> &'static Description {
        self.found.model.description
    }

    /// The derived functions of the scene.
    pub fn model(&self) -> &'static Model {
        self.found.model
    }

    /// The path of the scene file, as the user typed it.
    pub fn path(&self) -> &Path {
        Path::new(&self.found.path)
    }

    /// The values of its parameters, in the order of the description.
    ///
    /// # Errors
    /// An option is invalid.
    pub fn parameters(&self, options: &RunOptions) -> Result<Vec<f64>, Error> {
        let setup = self.setup(options)?;
        let mut values = self.found.model.parameter_values(&setup.replace());
        values.truncate(self.description().parameters.len());
        Ok(values)
    }

    /// The scene in the form that commands use.
    pub(super) fn found(&self) -> FoundScene {
        self.found.clone()
    }

    /// The setup of a run.
    pub(crate) fn setup(&self, options: &RunOptions) -> Result<Setup, Error> {
        let (scene, start, method) = options.parsed()?;
        Setup::from_found(self.found(), &scene, &method)?.starting_from(&start)
    }
}
