//! The sources of a motion's numbers, which allow their evaluation at any time.

use qrm_scene::evaluate::State;
use qrm_scene::scene::Value;
use qrm_sim::columns::Kind;

/// The source of a track.
#[derive(Clone, Debug)]
pub(crate) enum Source {
    /// A constant.
    Constant(f64),
    /// A component of a point.
    Point(usize, usize),
    /// A formula.
    Formula(Value),
    /// A column of a run.
    Column(Kind),
    /// A component of a force along a direction of any length.
    Along(Kind, [Value; 2], usize),
}

/// The sources of all tracks of a motion: of its nodes, its arrows, the angles of its shapes and its curves.
#[derive(Clone, Debug, Default)]
pub struct Sources(pub(crate) Vec<Source>);

impl Sources {
    /// Evaluates all sources at a state whose columns have these values.
    pub fn numbers(&self, state: &State<f64>, column: &dyn Fn(Kind) -> f64) -> Vec<f64> {
        self.0.iter().map(|source| source.number(state, column)).collect()
    }
}

impl Source {
    /// Evaluates the source at a state.
    pub(crate) fn number(&self, state: &State<f64>, column: &dyn Fn(Kind) -> f64) -> f64 {
        match self {
            Self::Constant(value) => *value,
            Self::Point(point, axis) => state.point(*point)[*axis],
            Self::Formula(value) => state.value(value),
            Self::Column(kind) => column(*kind),
            Self::Along(kind, along, axis) => {
                let [x, y] = [state.value(&along[0]), state.value(&along[1])];
                column(*kind) * [x, y][*axis] / (x * x + y * y).max(f64::MIN_POSITIVE)
            }
        }
    }
}
