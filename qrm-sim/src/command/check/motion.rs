//! Facts of the scene's own motion: peaks, energy, recurrence.

use std::f64::consts::TAU;

use qrm_scene::scene::{Output, OutputKind};

use super::super::progress::Progress;
use super::super::setup::Setup;
use super::super::{Failure, account, words};
use super::{Fact, number, shown};
use crate::album::Album;
use crate::balance::Balance;
use crate::extremes::Extremes;
use crate::outcome::Status;
use crate::simulate::End;
use crate::turn::wrapped;

/// The facts in words.
pub(super) fn facts(setup: &Setup) -> Result<(Vec<Fact>, Option<String>), Failure> {
    let mut observer = (Progress::new(), (Album::new(&setup.description), Balance::default()));
    let outcome = setup.simulate(false, &mut observer)?;
    let (album, balance) = observer.1;
    let summary = account::summary(setup, &outcome, &album);
    let problem = account::problem(&outcome, &summary);
    let mut facts = vec![Fact::new("run", [summary.message])];
    facts.extend(peaks(setup, &album));
    facts.push(energy(&balance, outcome.energy_drift.is_some()));
    facts.extend(recurrence(setup)?);
    facts.extend(summary.warnings.into_iter().map(|warning| Fact::new("warning", [warning])));
    Ok((facts, problem))
}

/// The coordinate that the scene gives at its start, if it is a single angle.
fn driven(setup: &Setup) -> Option<usize> {
    let given = setup.scene.given();
    let mut places = (0..given.len()).filter(|&i| given[i]);
    let place = places.next()?;
    (places.next().is_none() && setup.description.coordinates[place].unit == "rad").then_some(place)
}

fn peaks(setup: &Setup, album: &Album) -> Vec<Fact> {
    let driven = driven(setup).map(|i| setup.description.coordinates[i].name);
    let course = driven.map(|name| album.course(name)).unwrap_or_default();
    let at = |t: f64| {
        let after = course.partition_point(|point| point.0 < t).clamp(1, course.len().max(2) - 1);
        let angle = course
            .get(after - 1)
            .zip(course.get(after))
            .map(|((t0, a0), (t1, a1))| (a0 + (a1 - a0) * (t - t0) / (t1 - t0)).rem_euclid(TAU));
        let angle = angle.zip(driven).map(|(angle, name)| format!(", {name} = {}", shown(angle, "rad")));
        format!("t = {t:.6} s{}", angle.unwrap_or_default())
    };
    let mut facts = Vec::new();
    for output in &setup.text.outputs {
        let is_reaction = matches!(output.kind, OutputKind::ReactionForce { .. } | OutputKind::ReactionMoment { .. });
        let (true, Some(e)) = (is_reaction, album.extremes(&output.name)) else { continue };
        let line =
            |what: &str, (value, t): (f64, f64)| format!("{what}  {} {} at {}", number(value), output.unit, at(t));
        facts.push(Fact::new(&output.name, [line("smallest", e.minimum), line("largest ", e.maximum)]));
    }
    facts
}

fn energy(balance: &Balance, is_conservative: bool) -> Fact {
    let Balance { work, change, error, .. } = balance;
    let line = match is_conservative {
        true => format!("kinetic and potential: constant within {error:.1e} J"),
        false => format!(
            "changes by {} J, while loads without potential do work of {} J: balanced within {error:.1e} J",
            number(*change),
            number(*work)
        ),
    };
    Fact::new("energy", [line])
}

/// Whether the state comes back after a turn of the driven angle.
fn recurrence(setup: &Setup) -> Result<Option<Fact>, Failure> {
    let Some(driven) = driven(setup) else { return Ok(None) };
    let name = setup.description.coordinates[driven].name;
    let mut observer = (Progress::new(), Album::new(&setup.description));
    let latest = setup.latest_end();
    let turned = std::cell::Cell::new(None);
    let condition = |t: f64, q: &[f64], _: &[f64]| {
        let from = turned.get().unwrap_or(q[driven]);
        turned.set(Some(from));
        if t >= latest { 0.0 } else { (q[driven] - from).abs() - TAU }
    };
    let outcome = setup.simulate_until(Some(End::Condition(&condition)), false, &mut observer)?;
    let album = observer.1;
    let n = setup.description.coordinates.len();
    let Some(first) = album.frames.first() else { return Ok(None) };
    let (q, qd): (Vec<f64>, Vec<f64>) = (0..n).map(|i| (first[1 + 3 * i], first[2 + 3 * i])).unzip();
    let t = words::seconds(outcome.end_time);
    let makes_none = || Some(Fact::new("cycle", [format!("{name} makes no full turn by t = {t}")]));
    match outcome.status {
        Status::Stopped if (outcome.q[driven] - q[driven]).abs() > 0.999 * TAU => {}
        Status::Stopped | Status::StopNotReached { .. } => return Ok(makes_none()),
        _ => return Ok(None),
    }
    let mut largest = [(0.0, 0); 2];
    for i in 0..n {
        let rest = wrapped(outcome.q[i] - q[i], setup.description.coordinates[i].unit);
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
        format!("{turn} {} is not back: it is off by {}", moved.name, shown(position, moved.unit))
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
    lines.extend(setup.text.outputs.iter().filter_map(|output| {
        strokes(output, &album.course(&output.name), album.extremes(&output.name), outcome.end_time)
    }));
    Ok(Some(Fact::new("cycle", lines)))
}

/// How long the two strokes of an output take in one turn, if it has no more than two.
fn strokes(output: &Output, course: &[(f64, f64)], e: Option<Extremes>, period: f64) -> Option<String> {
    let (OutputKind::Value(_), Some(e)) = (&output.kind, e) else { return None };
    let signs = || course.windows(2).map(|pair| pair[1].1 - pair[0].1).filter(|change| *change != 0.0);
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
