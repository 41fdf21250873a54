//! Derives interpretable data from the text of a scene, without compilation.

use std::path::Path;

use qrm_core::{DerivedScene, OwnedDescription, OwnedParameter, OwnedQuantity};
use qrm_scene::scene::Scene;
use qrm_scene::scene_file::SceneFile;

use crate::Waiting;
use crate::generate::{self, Error};
use qrm_codegen::{derivation, verify};

/// Derives the equations of motion of a scene. Call it at most once per process.
///
/// `announce` is called when waiting for another process begins and ends. `show` receives the derived scene without its
/// texts, before its functions are verified.
///
/// # Errors
/// The scene has an error, the engine failed, or a function could not be verified.
pub fn derive(
    path: &Path,
    source: String,
    announce: &dyn Fn(Waiting),
    show: impl FnOnce(&DerivedScene),
) -> Result<DerivedScene, Error> {
    let file = generate::read(path, source)?;
    let equations = generate::equations(&[&file], announce)?.remove(0);
    let SceneFile { scene, source, .. } = &file;
    let tape = generate::tape(&file, &equations)?;
    show(&DerivedScene { description: description(scene, source, String::new()), tape: tape.clone() });
    verify::verify(scene, &equations, &tape, &tape.placed()).map_err(Error::Unverified)?;
    let derivation = derivation::markdown(scene, &equations, source);
    Ok(DerivedScene { description: description(scene, source, derivation), tape })
}

/// The description of a scene in its generated module.
fn description(scene: &Scene, source: &str, derivation: String) -> OwnedDescription {
    let quantity = |name: &str, unit: &str, doc: &str| {
        let [name, unit, doc] = [name, unit, doc].map(str::to_owned);
        OwnedQuantity { name, unit, doc }
    };
    let parameter = |p: &qrm_scene::scene::Parameter| {
        let [name, unit, doc, formula] = [&p.name, &p.unit, &p.doc, &p.text].map(|text| text.to_string());
        OwnedParameter { name, unit, doc, formula }
    };
    OwnedDescription {
        name: scene.name.clone(),
        doc: scene.doc.clone(),
        source: source.to_owned(),
        derivation,
        coordinates: scene.coordinates.iter().map(|c| quantity(&c.name, &c.unit, &c.doc)).collect(),
        constraints: scene.constraints.iter().map(|c| quantity(&c.name, &c.unit, &c.doc)).collect(),
        outputs: scene.outputs.iter().map(|o| quantity(&o.name, &o.unit, &o.doc)).collect(),
        parameters: scene.parameters.iter().filter(|p| !p.left_out).map(parameter).collect(),
        left_out: scene.left_out().map(|p| p.name.clone()).collect(),
        has_corners: scene.has_corners(),
        friction: scene.friction_by_forces().map(str::to_owned).collect(),
        until: qrm_language::rust::until(scene, source).to_owned(),
    }
}
