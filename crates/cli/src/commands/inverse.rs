//! `qrm inverse`

mod actuators;
mod profile;
mod report;

use std::f64::consts::TAU;
use std::path::Path;

use clap::Args;
use qrm_core::Model;
use qrm_scene::evaluate::constant;
use qrm_scene::names::suggestion;
use qrm_sim::analysis::{MotionStatistics, NotPossible, PrescribedMotion, PrescribedState, Statistics};
use qrm_sim::position::Start;

use crate::error::Error;
use crate::format::{number as number_of, position, quantity};
use crate::options::{MethodOptions, OutFolder, SceneName, SceneOptions, StartOptions, number, optional_positive};
use crate::output::{print, save, save_json, written};
use crate::progress::interrupted;
use crate::setup::Setup;
use actuators::Actuators;
use profile::Profile;
use report::Report;

#[derive(Args)]
pub(crate) struct Options {
    #[command(flatten)]
    name: SceneName,
    /// Give a parameter another value, such as `O2A=0.25` or `w0=3*pi`
    #[arg(long = "set", value_name = "NAME=VALUE", allow_hyphen_values = true)]
    set: Vec<String>,
    #[command(flatten)]
    start: StartOptions,
    /// Motion of a coordinate that the scene gives at its start: `constant`, `trapezoid`, `polynomial`,
    /// `table:FILE.csv` or a formula of `t`, with `NAME=` before it where the scene gives several; those without a
    /// motion stay where they are [default: constant]
    #[arg(long, value_name = "[NAME=]MOTION", allow_hyphen_values = true)]
    motion: Vec<String>,
    /// Rate of a constant motion, mean rate of the others [default: the scene's]
    #[arg(long, value_name = "RATE", allow_hyphen_values = true)]
    rate: Option<String>,
    /// How far `constant`, `trapezoid` and `polynomial` go [default: a turn]
    #[arg(long, value_name = "DISTANCE", allow_hyphen_values = true)]
    distance: Option<String>,
    /// How long the motion takes in seconds [default: by distance and rate]
    #[arg(long, value_name = "T", allow_hyphen_values = true)]
    time: Option<String>,
    /// Number of rows
    #[arg(long, value_name = "N", default_value_t = 721, value_parser = clap::value_parser!(u32).range(3..=1_000_000))]
    rows: u32,
    #[command(flatten)]
    out: OutFolder,
}

/// Computes the forces and torques for a prescribed motion, prints a summary, and writes them.
pub(crate) fn run(models: &'static [Model], options: &Options) -> Result<(), Error> {
    let scene =
        SceneOptions { name: options.name.clone(), set: options.set.clone(), step: None, end_time: None, until: None };
    let setup = Setup::new(models, &scene, &MethodOptions::default())?.starting_from(&options.start)?;
    let start = setup.start();
    let motions = motions(&setup, options, &start)?;
    let actuators = Actuators::new(&setup, &start.given);
    let (states, statistics) = states(&setup, &start, &motions, &actuators, options.rows)?;
    let report = Report::new(&setup, &actuators, &states, statistics);
    let folder = options.out.folder(&setup.path);
    let [table, summary, picture] = ["inverse.csv", "inverse.json", "inverse.svg"].map(|file| folder.join(file));
    save(&table, &report.csv()?)?;
    save_json(&summary, &report)?;
    let figure = report.figure().svg().map_err(|reason| Error::run(reason.to_string()))?;
    save(&picture, figure.as_bytes())?;
    let shown = |path: &Path| path.display().to_string();
    let files = [format!("{} ({} rows)", shown(&table), states.len()), shown(&summary), shown(&picture)];
    print(&format!("{}\n{}", report.text(&said(&motions, &setup)), written(&files)));
    Ok(())
}

/// A coordinate, its motion, and the motion in words.
struct Motion {
    coordinate: usize,
    profile: Profile,
    words: String,
    time: f64,
}

/// The motions requested on the command line.
fn motions(setup: &Setup, options: &Options, start: &Start) -> Result<Vec<Motion>, Error> {
    let coordinates = setup.description.coordinates;
    let given: Vec<usize> = (0..coordinates.len()).filter(|&i| start.given[i]).collect();
    if given.is_empty() {
        return match options.motion.is_empty() {
            true => Ok(Vec::new()),
            false => Err(Error::usage("the drives of the scene prescribe its motion already")
                .help("leave `--motion` out, or take the drive out of the scene")),
        };
    }
    let names: Vec<&str> = given.iter().map(|&i| coordinates[i].name).collect();
    let mut motions: Vec<Motion> = Vec::new();
    let default = ["constant".to_owned()];
    let asked = if options.motion.is_empty() && given.len() == 1 { &default[..] } else { &options.motion };
    for text in asked {
        let is_name = |text: &str| text.chars().all(|c| c.is_alphanumeric() || c == '_');
        let (name, motion) = match text.split_once('=').filter(|(name, _)| is_name(name.trim())) {
            Some((name, motion)) => (Some(name.trim()), motion.trim()),
            None => (None, text.trim()),
        };
        let coordinate = match name {
            None if given.len() == 1 => given[0],
            None => {
                return Err(Error::usage(format!("`--motion {text}`: which coordinate?")).help(format!(
                    "write `--motion {}={motion}`; the scene gives: {}",
                    names[0],
                    names.join(", ")
                )));
            }
            Some(name) => *given.iter().find(|&&i| coordinates[i].name == name).ok_or_else(|| {
                let help = suggestion(name, names.iter().copied(), || format!("the scene gives: {}", names.join(", ")));
                Error::usage(format!("`--motion {text}`: the scene does not give `{name}` at its start")).help(help)
            })?,
        };
        if motions.iter().any(|other| other.coordinate == coordinate) {
            let name = coordinates[coordinate].name;
            return Err(Error::usage(format!("`{name}` has two motions")).help("keep one of the two"));
        }
        motions.push(self::motion(setup, options, start, coordinate, motion)?);
    }
    if motions.is_empty() {
        return Err(Error::usage("which coordinate is to move?").help(format!(
            "write `--motion {}=constant`; the scene gives: {}",
            names[0],
            names.join(", ")
        )));
    }
    if let [first, others @ ..] = &motions[..]
        && let Some(other) = others.iter().find(|other| (other.time - first.time).abs() > 1e-12 * first.time)
    {
        let [one, two] = [first, other].map(|motion| (coordinates[motion.coordinate].name, motion.time));
        return Err(Error::usage(format!("`{}` moves for {} s and `{}` for {} s", one.0, one.1, two.0, two.1))
            .help("give both the same `--time`"));
    }
    Ok(motions)
}

/// The motion of a coordinate.
fn motion(setup: &Setup, options: &Options, start: &Start, coordinate: usize, text: &str) -> Result<Motion, Error> {
    let own = &setup.description.coordinates[coordinate];
    let (from, is_angle) = (start.q[coordinate], setup.description.is_angle(coordinate));
    let rate = options.rate.as_ref().map(|text| number("--rate", text, &format!("{}/s", own.unit))).transpose()?;
    let time = optional_positive("--time", options.time.as_ref(), "s")?;
    let rate = rate.unwrap_or_else(|| if start.given_rates[coordinate] { start.qd[coordinate] } else { 0.0 });
    let distance = || match &options.distance {
        Some(text) => number("--distance", text, own.unit),
        None if is_angle => Ok(TAU.copysign(rate)),
        None => time
            .filter(|_| rate != 0.0)
            .map(|time| rate * time)
            .ok_or_else(|| Error::usage(format!("how far is `{}` to go?", own.name)).help("add `--distance LENGTH`")),
    };
    let duration = |distance: f64| {
        let time = time.or((rate != 0.0).then_some(distance / rate)).filter(|time| *time > 0.0);
        time.ok_or_else(|| {
            Error::usage(format!("how long is the motion of `{}` to take?", own.name))
                .help("add `--time SECONDS`, or `--rate RATE` in the direction of the distance")
        })
    };
    let unused = |names: &[&str]| {
        let given = [("--rate", &options.rate), ("--distance", &options.distance), ("--time", &options.time)];
        let wrong = given.into_iter().find(|(name, value)| names.contains(name) && value.is_some());
        wrong.map_or(Ok(()), |(name, _)| {
            Err(Error::usage(format!("`{name}` has no meaning for the motion `{text}`")).help("leave it out"))
        })
    };
    let (profile, words, time) = match text {
        "constant" => {
            let (rate, time) = match (&options.distance, time) {
                (None, Some(time)) if rate != 0.0 => (rate, time),
                _ => {
                    if options.rate.is_some() && options.distance.is_some() {
                        unused(&["--time"])?;
                    }
                    let distance = distance()?;
                    let time = duration(distance)?;
                    (distance / time, time)
                }
            };
            let words = format!("{} at a constant rate, {} {}/s", own.name, number_of(rate), own.unit);
            (Profile::constant(from, rate, time), words, time)
        }
        "trapezoid" | "polynomial" => {
            if options.time.is_some() && options.distance.is_some() {
                unused(&["--rate"])?;
            }
            let distance = distance()?;
            let time = duration(distance)?;
            let (profile, how) = match text {
                "trapezoid" => (Profile::trapezoid(from, distance, time), "by a trapezoidal velocity profile"),
                _ => (Profile::polynomial(from, distance, time), "by a polynomial of degree 5"),
            };
            (profile, format!("{} {how}, {} in {time} s", own.name, quantity(distance, own.unit)), time)
        }
        text => match text.strip_prefix("table:") {
            Some(file) => {
                unused(&["--rate", "--distance", "--time"])?;
                let profile = Profile::table(Path::new(file))?;
                let time = profile.times().last().copied().unwrap_or(0.0);
                (profile, format!("{} by a spline through {file}", own.name), time)
            }
            None => {
                unused(&["--rate", "--distance"])?;
                let profile = Profile::formula(text, own.unit)?;
                let time = time.unwrap_or_else(|| constant(&setup.scene.run.end_time, &setup.parameters()));
                (profile, format!("{} = {text}", own.name), time)
            }
        },
    };
    Ok(Motion { coordinate, profile, words, time })
}

/// Describes the motions in words.
fn said(motions: &[Motion], setup: &Setup) -> String {
    let words: Vec<&str> = motions.iter().map(|motion| motion.words.as_str()).collect();
    let name = setup.description.name;
    match words.is_empty() {
        true => format!("{name}: forces and torques of its drives"),
        false => format!("{name}: forces and torques that a motion takes: {}", words.join("; ")),
    }
}

/// The states of the mechanism at the rows of a motion, and the statistics of the forces between them; where the
/// acceleration jumps, the states before and after the jump.
fn states(
    setup: &Setup,
    start: &Start,
    motions: &[Motion],
    actuators: &Actuators,
    rows: u32,
) -> Result<(Vec<PrescribedState>, Vec<Statistics>), Error> {
    let mechanism = setup.mechanism();
    let end_time = || constant(&setup.scene.run.end_time, &setup.parameters());
    let end = motions.first().map_or_else(end_time, |motion| motion.time);
    let mut times: Vec<f64> = motions.iter().flat_map(|motion| motion.profile.times()).chain([0.0, end]).collect();
    times.sort_by(f64::total_cmp);
    times.dedup();
    let prescribed = |ends: [f64; 2]| {
        move |i: usize, t: f64| {
            let motion = motions.iter().find(|motion| motion.coordinate == i);
            motion.map_or([start.q[i], 0.0, 0.0], |motion| motion.profile.at(t, ends))
        }
    };
    let wrong = |reason| not_possible(setup, &reason);
    let first = [times[0], times[1]];
    let mut moving = PrescribedMotion::new(&*mechanism, start, 0.0, &prescribed(first)).map_err(wrong)?;
    let numbers = |state: &PrescribedState| {
        let mut numbers = actuators.forces(state);
        numbers.push(actuators.power(&*mechanism, state));
        numbers
    };
    let mut statistics = MotionStatistics::new(moving.state(), &numbers);
    let mut states = vec![moving.state().clone()];
    for ends in times.windows(2) {
        let ends = [ends[0], ends[1]];
        let prescribed = prescribed(ends);
        if ends[0] > 0.0 {
            states.push(moving.advance(ends[0], &prescribed).map_err(wrong)?.clone());
        }
        let share = (ends[1] - ends[0]) / end * f64::from(rows - 1);
        let count = (share.round() as u32).max(1);
        for k in 1..=count {
            let t = if k == count { ends[1] } else { ends[0] + (ends[1] - ends[0]) * f64::from(k) / f64::from(count) };
            statistics.advance(&mut moving, t, &prescribed, &numbers).map_err(wrong)?;
            states.push(moving.state().clone());
            if interrupted() {
                return Err(Error::run(format!("interrupted at t = {t} s")));
            }
        }
    }
    Ok((states, statistics.finish()))
}

fn not_possible(setup: &Setup, reason: &NotPossible) -> Error {
    let position = |q: &[f64]| position(setup.description, q);
    match reason {
        NotPossible::NotAssembled(reason) => setup.not_assembled(reason),
        NotPossible::Singular => Error::usage(
            "the coordinates that are given do not determine the others at the start",
        )
        .help(
            "give as many coordinates in [initial] as there are degrees of freedom, at a position that is not singular",
        ),
        NotPossible::Friction => {
            Error::usage("friction depends on the forces in joints, which the torque would change")
                .help("prescribe the motion by the `drive` of a joint, and ask for its torque: `{ drive = \"JOINT\" }`")
        }
        NotPossible::LimitPosition { t, q } => {
            let at = position(q);
            Error::run(format!("the motion is not possible: after t = {t} s the mechanism locks at {at}"))
                .help("make the distance shorter, or look for limit positions with `qrm check`")
        }
        NotPossible::DeadPoint { t, q } => {
            let at = position(q);
            Error::run(format!("after t = {t} s the forces are not known: the motion reaches a dead point near {at}"))
                .help(
                    "prescribe another coordinate, or let a joint's `drive` move the mechanism and `qrm run` follow it",
                )
        }
        NotPossible::NotFinite { t } => {
            Error::run(format!("the motion, or a force that it needs, is not finite at t = {t} s"))
                .help("look for a singular position, for a formula that leaves its domain, and for its derivatives")
        }
        NotPossible::TooFast { t } => {
            Error::run(format!("the motion goes too far from one row to the next after t = {} s", number_of(*t)))
                .help("make it slower, or ask for more --rows")
        }
        NotPossible::Discontinuous { coordinate, t } => {
            let name = setup.description.coordinates[*coordinate].name;
            Error::run(format!("the motion of `{name}` jumps after t = {} s: no force can make it", number_of(*t)))
                .help("prescribe a motion whose value and rate are continuous")
        }
    }
}
