//! `qrm certify`

mod report;

use std::time::Instant;

use clap::Args;
use qrm_core::{Model, Obstacle, Tape};
use qrm_scene::evaluate::constant;
use qrm_sim::analysis::{Enclosure, EnclosureEnd, NoSeries, NotEnclosed, Reason, enclose};

use crate::error::Error;
use crate::format::number;
use crate::options::{MethodOptions, OutFolder, SceneName, SceneOptions};
use crate::output::{print, save_json, written};
use crate::progress::interrupted;
use crate::setup::Setup;
use report::Report;

#[derive(Args)]
pub(crate) struct Options {
    #[command(flatten)]
    name: SceneName,
    /// Give a parameter another value, such as `O2A=0.25` or `w0=3*pi`
    #[arg(long = "set", value_name = "NAME=VALUE", allow_hyphen_values = true)]
    set: Vec<String>,
    /// End at this time in seconds [default: after one turn of the angle that the scene gives, at the scene's end at
    /// the latest]
    #[arg(long, value_name = "T", allow_hyphen_values = true)]
    end_time: Option<String>,
    /// End when a condition on time, coordinates, points and their rates becomes true, such as `phi2 >= 3`
    #[arg(long, value_name = "CONDITION", allow_hyphen_values = true)]
    until: Option<String>,
    #[command(flatten)]
    out: OutFolder,
}

/// Encloses the motion of a scene, prints its state at the end, and writes it.
pub(crate) fn run(models: &'static [Model], options: &Options) -> Result<(), Error> {
    let scene = SceneOptions {
        name: options.name.clone(),
        set: options.set.clone(),
        step: None,
        end_time: options.end_time.clone(),
        until: None,
    };
    let setup = Setup::new(models, &scene, &MethodOptions::default())?;
    setup.refuse_redundant(&setup.assembled()?)?;
    let event = options.until.as_deref().map(|until| setup.event(until)).transpose()?;
    let begun = Instant::now();
    let (reached, problem) = match enclose(setup.model, &setup.replace(), end(&setup, event.as_ref()), &interrupted) {
        Ok(reached) => (Some(reached), None),
        Err(NotEnclosed { reached, reason }) => (reached.map(|reached| *reached), Some(reason)),
    };
    let t = reached.as_ref().map(|reached| reached.t.lo());
    if let Some(reached) = &reached {
        let report = Report::new(&setup, reached, options.until.as_deref());
        let file = options.out.folder(&setup.path).join("certify.json");
        print(&report.text(begun.elapsed()));
        save_json(&file, &report)?;
        print(&written(&[file.display().to_string()]));
    }
    if let Some(reason) = problem {
        return Err(not_enclosed(&setup, &reason, t));
    }
    match (&options.until, reached) {
        (Some(until), Some(Enclosure { is_at_event: false, t, .. })) => {
            Err(Error::run(format!("`{until}` does not become true up to t = {} s: that is proved", t.lo())))
        }
        _ => Ok(()),
    }
}

/// The end of the motion.
fn end<'a>(setup: &Setup, event: Option<&'a Tape>) -> EnclosureEnd<'a> {
    let before = setup.end_time.unwrap_or_else(|| constant(&setup.scene.run.end_time, &setup.parameters()));
    if let Some(tape) = event {
        return EnclosureEnd::Event { tape, before };
    }
    let start = setup.start();
    let mut given = (0..start.given.len()).filter(|&i| start.given[i]);
    match (setup.end_time, given.next(), given.next()) {
        (None, Some(coordinate), None) if setup.description.is_angle(coordinate) => {
            EnclosureEnd::Turn { coordinate, before }
        }
        _ => EnclosureEnd::Time(before),
    }
}

/// Creates an error with the time up to which a motion was enclosed, and the reason.
fn not_enclosed(setup: &Setup, reason: &Reason, t: Option<f64>) -> Error {
    let (text, help) = match reason {
        Reason::NotAssembled(reason) => return setup.not_assembled(reason),
        Reason::NotGiven => (
            "as many coordinates and rates must be given at the start as there are degrees of freedom".to_owned(),
            "change `given` under [initial]; `qrm check` counts the degrees of freedom",
        ),
        Reason::NotIsolated => (
            "it was not proved that there is one start only near the one that was found".to_owned(),
            "start farther from singular positions",
        ),
        Reason::Friction => (
            "friction by the forces in joints is found by iteration, which is not enclosed".to_owned(),
            "take `friction` out of the joints, or estimate errors by `qrm run`",
        ),
        Reason::TooLarge => (
            "the equations of motion are too large: their series would take more than 500 MB".to_owned(),
            "choose a smaller mechanism, or estimate errors by `qrm run`",
        ),
        Reason::NoSeries(NoSeries::Operation(Obstacle { operation, operand })) => (
            format!(
                "the equations contain {operation} of numbers between {} and {}, where it may have a corner or no \
                 value",
                number(operand.lo()),
                number(operand.hi())
            ),
            "start and end (`--end-time`) between two corners of `abs`, `sign`, `min`, `max`, tables and splines",
        ),
        Reason::NoSeries(NoSeries::Singular) => (
            "it was not proved that the accelerations are determined".to_owned(),
            "end before by `--end-time`, or keep away from singular positions",
        ),
        Reason::StepTooShort => (
            "the intervals are so wide that steps become too short".to_owned(),
            "end before by `--end-time`; near singular positions, and in chaos, small errors grow fast",
        ),
        Reason::EventOnForces => (
            "the condition depends on accelerations or forces".to_owned(),
            "name time, coordinates, points and their rates",
        ),
        Reason::EventAtStart => (
            "it was not proved that the condition is false at the start".to_owned(),
            "choose a condition that becomes true later",
        ),
        Reason::NotCrossed => (
            "it was not proved when the motion ends: the condition may jump, or only touch its bound".to_owned(),
            "end by `--end-time`, or by a condition on a number that keeps rising or falling",
        ),
        Reason::Interrupted => ("interrupted".to_owned(), "the intervals of the last step are written"),
    };
    match t {
        Some(t) => Error::run(format!("proved up to t = {t} s, and no further: {text}")).help(help),
        None => Error::usage(format!("nothing is proved: {text}")).help(help),
    }
}
