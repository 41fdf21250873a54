//! Joints that are far from their rough places.

use qrm_scene::evaluate::State;
use qrm_scene::scene::Near;

use crate::error::Message;
use crate::format::number;
use crate::setup::Setup;

/// Distances above this part of the size of the mechanism are reported.
const FAR: f64 = 0.5;

/// A message for each joint that is far from its `near` at the start. A start that cannot be assembled has none: its
/// error is reported where it is needed.
pub(crate) fn far_places(setup: &Setup) -> Vec<Message> {
    if setup.scene.near.is_empty() {
        return Vec::new();
    }
    let Ok(q) = setup.assembled() else { return Vec::new() };
    let state = State::plain(&setup.scene, &setup.parameters(), 0.0, &q, &vec![0.0; q.len()]);
    let points: Vec<[f64; 2]> = (0..setup.scene.points.len()).map(|point| state.point(point)).collect();
    let range = |axis: usize| {
        let values = points.iter().map(|point| point[axis]);
        values.clone().fold(f64::NEG_INFINITY, f64::max) - values.fold(f64::INFINITY, f64::min)
    };
    let size = range(0).hypot(range(1));
    let message = |near: &Near| {
        let [x, y] = state.point(near.point);
        let place = near.place.each_ref().map(|value| state.value(value));
        let distance = (place[0] - x).hypot(place[1] - y);
        (distance > FAR * size).then(|| {
            let [x, y, distance] = [x, y, distance].map(number);
            let text = format!("joint `{}` starts {distance} m away from its `near`", near.joint);
            Message::new(text).help(format!("it starts at [{x}, {y}]; lengths without a unit are in m"))
        })
    };
    setup.scene.near.iter().filter_map(message).collect()
}
