//! Positions of a mechanism over the frames of an animation.

use qrm_scene::evaluate::State;
use qrm_scene::expression::Node as Operation;
use qrm_scene::scene::{Quantity, Scene, Value};
use qrm_view::motion::{Node, Track};

use crate::recording::Recording;
use crate::source::Source;

/// The poses of a mechanism at several times, and its drawn positions.
pub(super) struct Pose<'s> {
    pub(super) scene: &'s Scene,
    pub(super) parameters: &'s [f64],
    /// The scene at each frame.
    pub(super) states: Vec<State<f64>>,
    pub(super) nodes: Vec<Node>,
    /// The sources of both components of each node.
    pub(super) sources: Vec<Source>,
    /// The sources of the angles of shapes.
    pub(super) angles: Vec<Source>,
    /// The node of each point; `None` if it is not drawn.
    points: Vec<Option<usize>>,
}

impl<'s> Pose<'s> {
    /// Creates the poses at the frames of a recorded run.
    pub(super) fn recorded(scene: &'s Scene, parameters: &'s [f64], recording: &Recording) -> Self {
        Self::new(scene, parameters, &recording.states())
    }

    /// Creates the poses at times with these coordinates and rates.
    pub(super) fn new(scene: &'s Scene, parameters: &'s [f64], states: &[(f64, Vec<f64>, Vec<f64>)]) -> Self {
        let state = |(t, q, qd): &(f64, Vec<f64>, Vec<f64>)| State::plain(scene, parameters, *t, q, qd);
        let states = states.iter().map(state).collect();
        let points = vec![None; scene.points.len()];
        Self { scene, parameters, states, nodes: Vec::new(), sources: Vec::new(), angles: Vec::new(), points }
    }

    /// The numbers of a source at each frame; empty for columns.
    pub(super) fn track(&self, source: &Source) -> Track {
        track(self.states.iter().map(|state| source.number(state, &|_| f64::NAN)).collect())
    }

    /// The node of a point.
    pub(super) fn point(&mut self, point: usize) -> usize {
        if let Some(node) = self.points[point] {
            return node;
        }
        let node = self.add(self.scene.points[point].name.clone(), [0, 1].map(|axis| Source::Point(point, axis)));
        self.points[point] = Some(node);
        node
    }

    /// The node of a point, or a named one that always has the same position.
    pub(super) fn node_at_same_position(&mut self, point: usize) -> usize {
        if let Some(own) = self.points[point] {
            return own;
        }
        let near = 1e-6 * self.size();
        let is_same = |node: &Node| {
            self.states.iter().enumerate().all(|(frame, state)| {
                let [x, y] = state.point(point);
                let of = |track: &Track| track[frame.min(track.len() - 1)];
                (of(&node.x) - x).hypot(of(&node.y) - y) <= near
            })
        };
        let same = self.nodes.iter().position(|node| !node.name.is_empty() && is_same(node));
        same.unwrap_or_else(|| self.point(point))
    }

    /// The node of a position: that of a point if it is one.
    pub(super) fn place(&mut self, place: &[Value; 2]) -> usize {
        let component = |axis: usize| match place[axis].nodes() {
            [Operation::Name(Quantity::Point(point, of))] if *of == axis => Some(*point),
            _ => None,
        };
        if let (Some(point), true) = (component(0), component(0) == component(1)) {
            return self.point(point);
        }
        self.add(String::new(), place.clone().map(Source::Formula))
    }

    /// The track of a shape's angle, zero without one. Call it in the order of the shapes.
    pub(super) fn angle(&mut self, angle: Option<&Value>) -> Track {
        let source = angle.map_or(Source::Constant(0.0), |angle| Source::Formula(angle.clone()));
        let track = self.track(&source);
        self.angles.push(source);
        track
    }

    /// Whether a position belongs to the ground.
    pub(super) fn is_fixed(&self, place: &[Value; 2]) -> bool {
        place.iter().all(|component| self.never_changes(component))
    }

    /// Whether a formula depends on parameters alone.
    pub(super) fn never_changes(&self, value: &Value) -> bool {
        value.names().all(|name| match name {
            Quantity::Parameter(_) | Quantity::Pi => true,
            // Points depend only on earlier points.
            Quantity::Point(point, axis) => self.never_changes(&self.scene.points[*point].position[*axis]),
            _ => false,
        })
    }

    /// The longer side of the rectangle around all points.
    pub(super) fn size(&self) -> f64 {
        let side = |axis: usize| {
            let places =
                self.states.iter().flat_map(|state| (0..self.points.len()).map(|point| state.point(point)[axis]));
            let (low, high) = places.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
            (high - low).max(0.0)
        };
        side(0).max(side(1))
    }

    /// The node of a fixed position, found up to rounding errors.
    pub(super) fn fixed(&mut self, [x, y]: [f64; 2]) -> usize {
        let near = |a: f64, b: f64| (a - b).abs() <= 1e-9 * (1e-6 + a.abs().max(b.abs()));
        let is_there = |node: &Node| node.x.len() == 1 && node.y.len() == 1 && near(node.x[0], x) && near(node.y[0], y);
        if let Some(place) = self.nodes.iter().position(is_there) {
            return place;
        }
        self.add(String::new(), [x, y].map(Source::Constant))
    }

    fn add(&mut self, name: String, sources: [Source; 2]) -> usize {
        let [x, y] = [0, 1].map(|axis| self.track(&sources[axis]));
        let is_same = |other: &Node| other.name == name && other.x == x && other.y == y;
        if let Some(place) = self.nodes.iter().position(is_same) {
            return place;
        }
        self.nodes.push(Node { name, is_traced: false, x, y });
        self.sources.extend(sources);
        self.nodes.len() - 1
    }
}

/// A track; a single value if it never changes.
pub(super) fn track(mut values: Vec<f64>) -> Track {
    if values.iter().all(|value| *value == values[0]) {
        values.truncate(1);
    }
    values
}
