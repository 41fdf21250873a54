//! A scene that runs again and again.

use qrm_core::{DerivedScene, Model, OwnedDescription};
use qrm_pictures::{Recording, motion};
use qrm_scene::evaluate::parameter_values;
use qrm_scene::scene::Scene;
use qrm_sim::integrate::MethodSettings;
use qrm_sim::run::{Outcome, Reason, Request, SimError, simulate};
use qrm_view::motion::Motion;
use serde::{Deserialize, Serialize};

use crate::requested::Requested;

/// Most frames of a motion: a screen shows no more of them. A draft is looked at for a moment.
const MOST_FRAMES: [usize; 2] = [400, 160];

/// A derived scene.
pub(crate) struct Simulator {
    model: Model,
    scene: Scene,
}

/// A scene as a page holds it.
#[derive(Serialize, Deserialize)]
struct Packed {
    derived: DerivedScene,
    scene: Scene,
}

/// The bytes of a scene for a page.
///
/// # Panics
/// Never: memory is all that it needs.
pub fn packed(derived: DerivedScene, scene: Scene) -> Vec<u8> {
    // The page shows no texts of that length.
    let texts = (String::new(), String::new(), String::new());
    let (source, code, derivation) = texts;
    let description = OwnedDescription { source, code, derivation, ..derived.description };
    let packed = Packed { derived: DerivedScene { description, ..derived }, scene };
    postcard::to_stdvec(&packed).unwrap_or_else(|e| unreachable!("memory takes all bytes: {e}"))
}

/// A scene, for the page.
#[derive(Serialize)]
struct About {
    name: &'static str,
    doc: &'static str,
    parameters: Vec<Parameter>,
}

#[derive(Serialize)]
struct Parameter {
    name: &'static str,
    unit: &'static str,
    doc: &'static str,
    value: f64,
}

/// A run with its motion.
#[derive(Serialize)]
struct Answer {
    run: Run,
    motion: Motion,
}

/// A run, for the page.
#[derive(Serialize)]
struct Run {
    end_time: f64,
    /// Whether it came to its end.
    is_done: bool,
    steps: u64,
    estimated_error: Option<f64>,
    /// The reasons not to trust its numbers.
    distrust: Vec<String>,
    q: Vec<f64>,
    qd: Vec<f64>,
}

impl Simulator {
    /// Of the bytes of a derived scene.
    pub(crate) fn new(bytes: &[u8]) -> Result<Self, String> {
        let packed: Packed = postcard::from_bytes(bytes).map_err(|_| "these bytes are not a derived scene")?;
        Ok(Self { model: packed.derived.into_model(), scene: packed.scene })
    }

    /// The scene as JSON.
    pub(crate) fn about(&self) -> Result<String, String> {
        let description = self.model.description;
        let values = self.model.parameter_values(&|_| None);
        let parameter = |(p, value): (&qrm_core::ParameterDescription, f64)| Parameter {
            name: p.name,
            unit: p.unit,
            doc: p.doc,
            value,
        };
        let parameters = description.parameters.iter().zip(values).map(parameter).collect();
        json(&About { name: description.name, doc: description.doc, parameters })
    }

    /// Runs the scene by its steps; the run and its motion as JSON.
    pub(crate) fn run(&self, requested: &Requested, is_draft: bool) -> Result<String, String> {
        let description = self.model.description;
        let replace = |name: &str| requested.value(name);
        let mut recording = Recording::with_frames(description, MOST_FRAMES[usize::from(is_draft)]);
        let request = Request { settings: MethodSettings::default(), step: None, end: None, estimate_error: !is_draft };
        let outcome = simulate(&*self.model.mechanism(&replace), &request, &mut recording);
        let outcome = outcome.map_err(|reason| SimError { reason: Reason::Start(reason), description }.to_string())?;
        if recording.frames.len() < 2 {
            return Err(format!("`{}` stays where it is", description.name));
        }
        let parameters = parameter_values(&self.scene, replace);
        let motion = motion(&self.scene, &parameters, &recording).map_err(|reason| reason.to_string())?;
        json(&Answer { run: self.report(&outcome), motion })
    }

    fn report(&self, outcome: &Outcome) -> Run {
        let description = self.model.description;
        let doubts = outcome.doubts(description);
        Run {
            end_time: outcome.end_time,
            is_done: outcome.status.is_done(),
            steps: outcome.counts.accepted,
            estimated_error: outcome.estimated_error(),
            distrust: doubts.iter().map(|doubt| doubt.text(outcome.tolerance, description)).collect(),
            q: outcome.q.clone(),
            qd: outcome.qd.clone(),
        }
    }
}

fn json(value: &impl Serialize) -> Result<String, String> {
    serde_json::to_string(value).map_err(|e| e.to_string())
}
