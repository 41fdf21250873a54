//! Degrees of freedom, by count and by rank, and the classes of four-bar linkages.

use qrm_scene::document;
use qrm_scene::evaluate::State;
use qrm_sim::analysis::{FourBar, GrashofClass};
use qrm_sim::solve::constraint_rank;

use super::{Topic, inputs};
use crate::error::Error;
use crate::format::{counted, number, quantity};
use crate::setup::Setup;

/// The lines about degrees of freedom and four-bar linkages.
pub(super) fn report_lines(setup: &Setup) -> Result<Vec<Topic>, Error> {
    let q = setup.assembled()?;
    let mut topics = vec![mobility(setup, &q)];
    let values = setup.parameters();
    let state = State::plain(&setup.scene, &values, 0.0, &q, &vec![0.0; q.len()]);
    topics.extend(setup.scene.four_bars.iter().filter_map(|four_bar| grashof(setup, &state, four_bar)));
    Ok(topics)
}

fn mobility(setup: &Setup, q: &[f64]) -> Topic {
    let count = setup.description.constraints.len();
    let rank = constraint_rank(&*setup.mechanism(), 0.0, q);
    let counted = |number: usize, noun: &str| counted(number as u64, noun);
    let freedoms = match q.len() - rank {
        0 if !setup.scene.drives().is_empty() => "no degree of freedom is left by the drives".to_owned(),
        1 => "1 degree of freedom".to_owned(),
        freedoms => format!("{freedoms} degrees of freedom"),
    };
    let (coordinates, constraints) = (counted(q.len(), "coordinate"), counted(count, "constraint"));
    let mut lines = vec![match count {
        0 => format!("{freedoms}: {coordinates}, no constraint"),
        _ => format!("{freedoms}: {coordinates}, {constraints} of rank {rank}"),
    }];
    if rank < count {
        let by_count = q.len() as i64 - count as i64;
        let more = counted(count - rank, "constraint");
        let verb = if count - rank == 1 { "repeats" } else { "repeat" };
        lines.push(format!(
            "by count there would be {by_count}: {more} {verb} others, and the reactions are not unique"
        ));
    }
    Topic::new("mobility", lines)
}

/// The class of a four-bar linkage after Grashof, and its transmission angle; `None` for a loop without lengths.
fn grashof(setup: &Setup, state: &State<f64>, four_bar: &document::FourBar) -> Option<Topic> {
    let length = |side: usize| side_vector(setup, state, four_bar, side).map(|[x, y]| x.hypot(y));
    let [input, output] = sides_from_input(setup, four_bar)?;
    let linkage = FourBar { ground: length(0)?, input: length(input)?, coupler: length(2)?, output: length(output)? };
    let class = linkage.class()?;
    let name = |side: usize| four_bar.links[side].as_str();
    let sides =
        [0, input, 2, output].map(|side| format!("{} {}", name(side), number(length(side).unwrap_or(f64::NAN))));
    let mut lines = vec![format!("{} (m)", sides.join(", ")), class_text(class, name(input), name(2), name(output))];
    let angle = quantity(linkage.transmission_angle()?, "rad");
    lines.push(format!(
        "transmission angle between `{}` and `{}`: at least {angle} as `{}` moves",
        name(2),
        name(output),
        name(input)
    ));
    Some(Topic::new("four-bar", lines))
}

/// The vector between the ends of a side of a four-bar linkage.
pub(super) fn side_vector(
    setup: &Setup,
    state: &State<f64>,
    four_bar: &document::FourBar,
    side: usize,
) -> Option<[f64; 2]> {
    let point = |name: &str| Some(state.point(setup.scene.points.iter().position(|point| point.name == name)?));
    let [from, to] = &four_bar.sides[side];
    let [[ax, ay], [bx, by]] = [point(from)?, point(to)?];
    Some([bx - ax, by - ay])
}

/// The sides that are input and output of a four-bar linkage.
pub(super) fn sides_from_input(setup: &Setup, four_bar: &document::FourBar) -> Option<[usize; 2]> {
    let inputs = inputs(setup).ok()?;
    let is_input = |name: &str| inputs.iter().any(|input| input.name == name);
    Some(if is_input(&four_bar.angles[1]) && !is_input(&four_bar.angles[0]) { [3, 1] } else { [1, 3] })
}

fn class_text(class: GrashofClass, input: &str, coupler: &str, output: &str) -> String {
    match class {
        GrashofClass::CrankRocker => format!("crank-rocker: `{input}` turns fully, `{output}` rocks"),
        GrashofClass::RockerCrank => format!("rocker-crank: `{output}` turns fully, `{input}` rocks"),
        GrashofClass::DoubleCrank => format!("double crank: `{input}` and `{output}` turn fully"),
        GrashofClass::DoubleRocker => format!("double rocker: `{coupler}` turns fully, `{input}` and `{output}` rock"),
        GrashofClass::ChangePoint => "change point: all links can be in one line, where branches cross".to_owned(),
        GrashofClass::TripleRocker => "triple rocker: no link turns fully, against Grashof's condition".to_owned(),
    }
}
