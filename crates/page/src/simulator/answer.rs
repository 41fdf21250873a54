//! The JSON sent to the page: a scene, or a run with its motion.

use qrm_core::{Description, Mechanism};
use qrm_sim::position::Start;
use qrm_sim::run::{Outcome, Reason, SimError, Status};
use qrm_view::motion::Motion;
use serde::Serialize;

use crate::named_values::Named;

/// A scene, for the page.
#[derive(Serialize)]
pub(super) struct About {
    pub(super) name: &'static str,
    pub(super) doc: String,
    pub(super) parameters: Vec<Settable>,
    /// The given coordinates at the start.
    pub(super) start: Vec<Settable>,
    /// The parameters that are zero in the scene and omitted from its functions.
    pub(super) left_out: &'static [&'static str],
    /// The latest end of the motion.
    pub(super) end_time: f64,
}

/// A number that the page can change.
#[derive(Serialize)]
pub(super) struct Settable {
    pub(super) name: &'static str,
    pub(super) unit: &'static str,
    pub(super) doc: &'static str,
    pub(super) value: f64,
    /// Whether the value follows from other parameters.
    pub(super) follows: bool,
}

/// A run with its motion.
#[derive(Serialize)]
pub(super) struct Answer {
    pub(super) run: Run,
    pub(super) motion: Motion,
}

/// A run, for the page.
#[derive(Serialize)]
pub(super) struct Run {
    pub(super) end_time: f64,
    /// The reason why it did not reach its end.
    pub(super) failure: Option<String>,
    pub(super) steps: u64,
    pub(super) estimated_error: Option<f64>,
    /// The reasons not to trust its results.
    pub(super) distrust: Vec<String>,
    pub(super) q: Vec<f64>,
    pub(super) qd: Vec<f64>,
    /// The current values of the quantities that the page can change; some follow from others.
    pub(super) values: Named,
}

/// The parameters, and the given coordinates at the start.
pub(super) fn settable(mechanism: &dyn Mechanism, start: &Start) -> [Vec<Settable>; 2] {
    let description = mechanism.description();
    let parameters = description.parameters.iter().zip(mechanism.parameters());
    let given = description.coordinates.iter().zip(&start.q).zip(&start.given).filter(|(_, given)| **given);
    let row = |(name, unit, doc, value)| Settable { name, unit, doc, value, follows: false };
    [
        parameters.map(|(p, value)| row((p.name, p.unit, p.doc, *value))).collect(),
        given.map(|((c, value), _)| row((c.name, c.unit, c.doc, *value))).collect(),
    ]
}

/// The reason why a run did not reach its end.
pub(super) fn failure(outcome: &Outcome, description: &'static Description) -> Option<String> {
    let t = outcome.end_time;
    Some(match &outcome.status {
        Status::Completed | Status::Stopped => return None,
        Status::StopNotReached { .. } => {
            format!("`{}` did not become true until the latest end, t = {t} s", description.until)
        }
        Status::StopUndecided { between: [t, _] } => {
            format!("whether `{}` becomes true at t = {t} s is not known", description.until)
        }
        Status::Interrupted => {
            format!("the page follows this motion up to t = {t} s, and `qrm run` to its end")
        }
        Status::Failed(error) => {
            let reason = Reason::Failed { t, error: *error };
            SimError { reason, description }.to_string()
        }
        Status::NotFinite { t, .. } => format!("the motion breaks off: a value is not finite at t = {t} s"),
        Status::Unwritable(_) => "the page is out of memory".to_owned(),
    })
}

pub(super) fn json(value: &impl Serialize) -> Result<String, String> {
    // The text of the error would make pages larger by half a percent.
    serde_json::to_string(value).map_err(|_| "the page is out of memory".to_owned())
}
