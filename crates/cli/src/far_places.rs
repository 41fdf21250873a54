//! Joints that are far from their rough places.

use qrm_scene::evaluate::State;
use qrm_scene::scene::Near;

use crate::error::Message;
use crate::format::number;
use crate::setup::Setup;

/// A message for each joint whose `near` is farther away at the start than the shorter of its links is long. A start
/// that cannot be assembled has none: its error is reported where it is needed.
pub(crate) fn far_places(setup: &Setup) -> Vec<Message> {
    if setup.scene.near.is_empty() {
        return Vec::new();
    }
    let Ok(q) = setup.assembled() else { return Vec::new() };
    let state = State::plain(&setup.scene, &setup.parameters(), 0.0, &q, &vec![0.0; q.len()]);
    let distance = |[x, y]: [f64; 2], point: usize| {
        let [px, py] = state.point(point);
        (x - px).hypot(y - py)
    };
    let length = |points: &Vec<usize>| {
        let pairs = points.iter().flat_map(|a| points.iter().map(|b| distance(state.point(*a), *b)));
        pairs.fold(0.0, f64::max)
    };
    let message = |near: &Near| {
        // A block without a second point has no length.
        let shortest = near.links.iter().map(length).filter(|length| *length > 0.0).reduce(f64::min)?;
        let place = near.place.each_ref().map(|value| state.value(value));
        let away = distance(place, near.point);
        (away > shortest).then(|| {
            let [x, y] = state.point(near.point).map(number);
            let text = format!("joint `{}` starts {} m away from its `near`", near.joint, number(away));
            Message::new(text).help(format!("it starts at [{x}, {y}]; lengths without a unit are in m"))
        })
    };
    setup.scene.near.iter().filter_map(message).collect()
}
