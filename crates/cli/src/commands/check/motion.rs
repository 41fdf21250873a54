//! The scene's own motion: peaks, energy, recurrence.

use std::f64::consts::TAU;

use qrm_scene::scene::{Output, OutputKind};
use qrm_sim::analysis::wrap_angle;
use qrm_sim::columns::Kind;
use qrm_sim::run::Balance;
use qrm_sim::run::End;
use qrm_sim::run::Extremes;
use qrm_sim::run::Status;

use super::{Topic, inputs, transmission};
use crate::error::Error;
use crate::format::{number, quantity, seconds};
use crate::progress::Progress;
use crate::run_report::RunReport;
use crate::setup::Setup;
use qrm_pictures::Recording;

/// The lines about the motion, and an error if its run failed.
pub(super) fn report_lines(setup: &Setup) -> Result<(Vec<Topic>, Option<Error>), Error> {
    let mut observer = (Progress::new(), (Recording::new(setup.description), Balance::default()));
    let outcome = setup.simulate(false, &mut observer)?;
    let (recording, balance) = observer.1;
    let report = RunReport::new(setup, &outcome, &recording);
    let mut topics = vec![Topic::new("run", [report.message.to_string()])];
    let driven = driven(setup);
    let input =
        Input { name: driven.map(|i| setup.description.coordinates[i].name), series: series(driven, &recording) };
    topics.extend(transmission::report_lines(setup, &input, &recording));
    topics.extend(peaks(setup, &input, &recording));
    topics.push(energy(&balance, outcome.energy_drift.is_some()));
    if let Some(driven) = driven {
        topics.extend(recurrence(setup, driven)?);
    }
    topics.extend(report.warnings.iter().map(|warning| Topic::new("warning", warning.lines())));
    Ok((topics, report.problem()))
}

/// The coordinate that the scene gives at its start, or that a drive prescribes, if it is a single angle.
fn driven(setup: &Setup) -> Option<usize> {
    let [input] = inputs(setup).ok()?[..] else { return None };
    let place = setup.description.coordinates.iter().position(|coordinate| coordinate.name == input.name)?;
    (input.unit == "rad").then_some(place)
}

/// The driven angle over time.
pub(super) struct Input {
    name: Option<&'static str>,
    series: Vec<(f64, f64)>,
}

impl Input {
    /// A time, and the driven angle at it.
    pub(super) fn at(&self, t: f64) -> String {
        let after = self.series.partition_point(|point| point.0 < t).clamp(1, self.series.len().max(2) - 1);
        let angle = self
            .series
            .get(after - 1)
            .zip(self.series.get(after))
            .map(|((t0, a0), (t1, a1))| (a0 + (a1 - a0) * (t - t0) / (t1 - t0)).rem_euclid(TAU));
        let angle = angle.zip(self.name).map(|(angle, name)| format!(", {name} = {}", quantity(angle, "rad")));
        format!("t = {t:.6} s{}", angle.unwrap_or_default())
    }
}

fn series(driven: Option<usize>, recording: &Recording) -> Vec<(f64, f64)> {
    driven.map(|i| recording.series(Kind::Coordinate(i))).unwrap_or_default()
}

fn peaks(setup: &Setup, input: &Input, recording: &Recording) -> Vec<Topic> {
    let mut topics = Vec::new();
    for (i, output) in setup.scene.outputs.iter().enumerate() {
        let (true, Some(e)) = (output.kind.is_reaction(), recording.extremes(Kind::Output(i))) else { continue };
        let line = |what: &str, (value, t): (f64, f64)| {
            format!("{what}  {} {} at {}", number(value), output.unit, input.at(t))
        };
        topics.push(Topic::new(&output.name, [line("smallest", e.minimum), line("largest ", e.maximum)]));
    }
    topics
}

fn energy(balance: &Balance, is_conservative: bool) -> Topic {
    let Balance { work, change, error, .. } = balance;
    let line = match is_conservative {
        true => format!("kinetic and potential: constant within {error:.1e} J"),
        false => format!(
            "changes by {} J, while loads without potential do work of {} J: balanced within {error:.1e} J",
            number(*change),
            number(*work)
        ),
    };
    Topic::new("energy", [line])
}

/// Tests whether the state returns after a turn of the driven angle.
fn recurrence(setup: &Setup, driven: usize) -> Result<Option<Topic>, Error> {
    let name = setup.description.coordinates[driven].name;
    let mut observer = (Progress::new(), Recording::new(setup.description));
    let [start, _] = setup.first_state()?;
    let turn = format!("abs({name} - ({:?})) - 2*pi", start[driven]);
    let turn_or_end = match setup.end_time {
        Some(t) => format!("max({turn}, t - {t:?}) >= 0"),
        None => format!("{turn} >= 0"),
    };
    let event = setup.event(&turn_or_end)?;
    let outcome = setup.simulate_until(Some(End::Event(&event)), false, &mut observer)?;
    let recording = observer.1;
    let Some((_, q, qd)) = recording.states().into_iter().next() else { return Ok(None) };
    let t = seconds(outcome.end_time);
    let makes_none = || Some(Topic::new("cycle", [format!("{name} makes no full turn by t = {t}")]));
    match outcome.status {
        Status::Stopped if (outcome.q[driven] - q[driven]).abs() > 0.999 * TAU => {}
        Status::Stopped | Status::StopNotReached { .. } => return Ok(makes_none()),
        _ => return Ok(None),
    }
    let mut largest = [(0.0, 0); 2];
    for i in 0..q.len() {
        let rest = wrap_angle(outcome.q[i] - q[i], setup.description.coordinates[i].unit);
        for (largest, difference) in largest.iter_mut().zip([rest, outcome.qd[i] - qd[i]]) {
            if difference.abs() > largest.0 {
                *largest = (difference.abs(), i);
            }
        }
    }
    let [(position, moved), (rate, place)] = largest;
    let scale = qd.iter().fold(0.0, |most: f64, v| most.max(v.abs()));
    let turn = format!("after a turn of {name}, at t = {t},");
    let line = if position > 1e-6 {
        let moved = setup.description.coordinates[moved];
        format!("{turn} {} is not back: it is off by {}", moved.name, quantity(position, moved.unit))
    } else if rate > 1e-6 * scale {
        let fastest = setup.description.coordinates[place].name;
        let [now, then] = [outcome.qd[place], qd[place]].map(number);
        format!("{turn} the motion does not repeat: {fastest}_dot is {now} instead of {then}")
    } else {
        format!(
            "{turn} the state is that of the start within {position:.1e} in the coordinates, {rate:.1e} in the rates"
        )
    };
    let mut lines = vec![line];
    lines.extend(setup.scene.outputs.iter().enumerate().filter_map(|(i, output)| {
        let kind = Kind::Output(i);
        strokes(output, &recording.series(kind), recording.extremes(kind), outcome.end_time)
    }));
    Ok(Some(Topic::new("cycle", lines)))
}

/// The durations of the two strokes of an output in one turn, if it has at most two.
fn strokes(output: &Output, series: &[(f64, f64)], e: Option<Extremes>, period: f64) -> Option<String> {
    let (OutputKind::Value(_), Some(e)) = (&output.kind, e) else { return None };
    let signs = || series.windows(2).map(|pair| pair[1].1 - pair[0].1).filter(|change| *change != 0.0);
    let turns_back = signs().zip(signs().skip(1)).filter(|(a, b)| a * b < 0.0).count();
    let there = (e.maximum.1 - e.minimum.1).abs();
    let (slow, fast) = if there > period - there { (there, period - there) } else { (period - there, there) };
    (turns_back == 2 && fast > 0.0).then(|| {
        format!(
            "{}: one stroke {slow:.6} s, the other {fast:.6} s: ratio {:.6} in this motion",
            output.name,
            slow / fast
        )
    })
}
