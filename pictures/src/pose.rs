//! Places of a mechanism over the frames of an animation.

use qrm_scene::evaluate::State;
use qrm_scene::expression::Node as Operation;
use qrm_scene::scene::{Quantity, Scene, Value};
use qrm_view::motion::{Node, Track};

use crate::recording::Recording;

/// The poses of a mechanism at each of several times, and the places of it that are shown.
pub(super) struct Pose<'s> {
    pub(super) scene: &'s Scene,
    pub(super) parameters: &'s [f64],
    /// The scene at each frame.
    pub(super) states: Vec<State<f64>>,
    pub(super) nodes: Vec<Node>,
    /// Which node shows a point.
    points: Vec<Option<usize>>,
}

impl<'s> Pose<'s> {
    /// The poses at the frames of a recorded run.
    pub(super) fn recorded(scene: &'s Scene, parameters: &'s [f64], recording: &Recording) -> Self {
        Self::new(scene, parameters, &recording.states())
    }

    /// The poses at times with these coordinates and rates.
    pub(super) fn new(scene: &'s Scene, parameters: &'s [f64], states: &[(f64, Vec<f64>, Vec<f64>)]) -> Self {
        let state = |(t, q, qd): &(f64, Vec<f64>, Vec<f64>)| State::plain(scene, parameters, *t, q, qd);
        let states = states.iter().map(state).collect();
        Self { scene, parameters, states, nodes: Vec::new(), points: vec![None; scene.points.len()] }
    }

    /// The value of a formula at each frame.
    pub(super) fn track(&self, value: &Value) -> Track {
        track(self.states.iter().map(|state| state.value(value)).collect())
    }

    /// The node of a point.
    pub(super) fn point(&mut self, point: usize) -> usize {
        if let Some(node) = self.points[point] {
            return node;
        }
        let [x, y] = [0, 1].map(|axis| track(self.states.iter().map(|state| state.point(point)[axis]).collect()));
        let node = self.add(Node { name: self.scene.points[point].name.clone(), is_traced: false, x, y });
        self.points[point] = Some(node);
        node
    }

    /// The node of a place: that of a point if it is one.
    pub(super) fn place(&mut self, place: &[Value; 2]) -> usize {
        let component = |axis: usize| match place[axis].nodes() {
            [Operation::Name(Quantity::Point(point, of))] if *of == axis => Some(*point),
            _ => None,
        };
        if let (Some(point), true) = (component(0), component(0) == component(1)) {
            return self.point(point);
        }
        let [x, y] = [0, 1].map(|axis| self.track(&place[axis]));
        self.add(Node { name: String::new(), is_traced: false, x, y })
    }

    /// The node of a place that never moves, found up to rounding errors.
    pub(super) fn fixed(&mut self, [x, y]: [f64; 2]) -> usize {
        let near = |a: f64, b: f64| (a - b).abs() <= 1e-9 * (1e-6 + a.abs().max(b.abs()));
        let is_there = |node: &Node| node.x.len() == 1 && node.y.len() == 1 && near(node.x[0], x) && near(node.y[0], y);
        if let Some(place) = self.nodes.iter().position(is_there) {
            return place;
        }
        self.add(Node { name: String::new(), is_traced: false, x: vec![x], y: vec![y] })
    }

    fn add(&mut self, node: Node) -> usize {
        let is_same = |other: &Node| other.name == node.name && other.x == node.x && other.y == node.y;
        let place = self.nodes.iter().position(is_same);
        place.unwrap_or_else(|| {
            self.nodes.push(node);
            self.nodes.len() - 1
        })
    }
}

/// One value is enough for what never changes.
fn track(mut values: Vec<f64>) -> Track {
    if values.iter().all(|value| *value == values[0]) {
        values.truncate(1);
    }
    values
}
