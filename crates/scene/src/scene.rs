//! A scene with every name looked up: plain data, ready to be differentiated or evaluated.

mod dependencies;
mod drawing;
mod extreme;
mod load;
mod output;
mod reference;

use crate::diagnostic::Span;
use crate::document::{FourBar, Side};
use crate::expression::{Expression, Node};
use crate::function::Function;
use crate::parser::Condition;
pub use drawing::{Drawn, DrawnKind};
pub use extreme::Extreme;
pub use load::{Friction, LoadKind};
pub use output::{Displacement, OutputKind, Slide, Turn};
pub use reference::{Known, Reference};

/// A formula of a scene.
pub type Value = Expression<Quantity>;

/// The quantity denoted by a name in a formula; numbers are indices into the lists of [`Scene`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, serde::Serialize, serde::Deserialize)]
pub enum Quantity {
    /// A parameter.
    Parameter(usize),
    /// A generalized coordinate.
    Coordinate(usize),
    /// The rate of a generalized coordinate.
    Rate(usize),
    /// Abscissa (0) or ordinate (1) of a point.
    Point(usize, usize),
    /// The rate of the abscissa (0) or ordinate (1) of a point.
    PointRate(usize, usize),
    /// The acceleration of a generalized coordinate; this and the results below occur only in conditions.
    Acceleration(usize),
    /// The multiplier of a constraint.
    Multiplier(usize),
    /// An output.
    Output(usize),
    /// The kinetic energy.
    KineticEnergy,
    /// The potential of the conservative loads.
    PotentialEnergy,
    /// Both energies.
    Energy,
    /// The length or angle along which a load acts; occurs only in the load's own law.
    Stretch,
    /// The rate of the length or angle along which a load acts.
    StretchRate,
    /// Time.
    Time,
    /// The ratio of a circle's circumference to its diameter.
    Pi,
    /// A name that could not be read or looked up; occurs only in scenes with errors.
    Unknown,
}

/// A mechanism.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub struct Scene {
    /// The name of the mechanism.
    pub name: String,
    /// The location of its name.
    pub name_span: Span,
    /// The description of the mechanism, for people.
    pub doc: String,
    /// Generalized coordinates, in the order of q.
    pub coordinates: Vec<Coordinate>,
    /// Parameters; each may depend on those before it.
    pub parameters: Vec<Parameter>,
    /// Named points; each may depend on those before it.
    pub points: Vec<Point>,
    /// Bodies.
    pub bodies: Vec<Body>,
    /// Loop constraints.
    pub constraints: Vec<Constraint>,
    /// Applied loads.
    pub loads: Vec<Load>,
    /// The quantities to be computed in addition to the coordinates.
    pub outputs: Vec<Output>,
    /// The parts of a picture of the mechanism; empty if the scene defines none.
    pub drawing: Vec<Drawn>,
    /// Reference values.
    pub references: Vec<Reference>,
    /// Variants on which methods are tested.
    pub extremes: Vec<Extreme>,
    /// The step, the end and the options of a run.
    pub run: Run,
    /// Loops of four links; present only in scenes with links.
    #[serde(skip)]
    pub four_bars: Vec<FourBar>,
    /// Rough places of joints at the start.
    #[serde(skip)]
    pub near: Vec<Near>,
    /// Whether the scene has links: its user wrote joints, not constraints.
    #[serde(skip)]
    pub has_links: bool,
}

/// The rough place of a joint at the start.
#[derive(Clone, Debug)]
pub struct Near {
    /// The name of the joint.
    pub joint: String,
    /// A point of the joint.
    pub point: usize,
    /// The points of each moving link of the joint.
    pub links: Vec<Vec<usize>>,
    /// The rough place.
    pub place: [Value; 2],
}

/// A generalized coordinate.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub struct Coordinate {
    /// The name of the coordinate.
    pub name: String,
    /// The unit of the coordinate.
    pub unit: String,
    /// The description of the coordinate.
    pub doc: String,
    /// The value of the coordinate at the start.
    pub position: Start,
    /// The rate of the coordinate at the start.
    pub rate: Start,
    /// The location of its declaration.
    pub span: Span,
}

/// The way in which the start fixes a coordinate or a rate.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub enum Start {
    /// The user fixes it.
    Given(Value),
    /// The constraints determine the value, by iteration from this guess.
    Guess(Value),
    /// The constraints determine the value.
    Free,
}

/// A constant that users may change.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub struct Parameter {
    /// The name of the parameter.
    pub name: String,
    /// The unit of the parameter.
    pub unit: String,
    /// The description of the parameter.
    pub doc: String,
    /// The formula of the parameter, which may contain earlier parameters.
    pub formula: Value,
    /// The formula as written.
    pub text: String,
    /// The value of the formula.
    pub value: f64,
    /// Whether generated code keeps the parameter even if it is zero.
    pub runtime: bool,
    /// Whether the generated code omits it: it is exactly zero, and so are all parameters on which it depends.
    pub left_out: bool,
}

/// A named point.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub struct Point {
    /// The name of the point.
    pub name: String,
    /// Abscissa and ordinate.
    pub position: [Value; 2],
}

/// A rigid body; a missing part does not affect the motion.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub struct Body {
    /// The name of the body.
    pub name: String,
    /// Mass.
    pub mass: Option<Value>,
    /// Position of its centre of mass.
    pub com: Option<[Value; 2]>,
    /// Orientation.
    pub angle: Option<Value>,
    /// Moment of inertia about the centre of mass.
    pub inertia: Option<Value>,
}

impl Body {
    /// A negative mass or inertia: its name and its formula.
    pub fn negative_inertia(&self, number: impl Fn(&Value) -> f64) -> Option<(&'static str, &Value, f64)> {
        let all = [("mass", self.mass.as_ref()), ("inertia", self.inertia.as_ref())];
        let known = all.into_iter().filter_map(|(what, value)| value.map(|value| (what, value, number(value))));
        known.into_iter().find(|(_, _, number)| *number < 0.0)
    }
}

/// A loop closure: a formula that must stay zero.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub struct Constraint {
    /// The name of the constraint.
    pub name: String,
    /// The formula.
    pub residual: Value,
    /// Unit of the residual.
    pub unit: String,
    /// The side towards which the residual may move; `None` if the joint holds it on both sides.
    pub one_sided: Option<Side>,
    /// Whether the constraint is the drive of a joint.
    pub is_drive: bool,
    /// The description of the constraint.
    pub doc: String,
    /// The location of the formula.
    pub span: Span,
}

/// An applied load.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub struct Load {
    /// The name of the load.
    pub name: String,
    /// The kind of the load.
    pub kind: LoadKind,
}

/// A quantity that is computed for every row of a trajectory.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub struct Output {
    /// The name of the output.
    pub name: String,
    /// The unit of the output.
    pub unit: String,
    /// The factor from SI units to the unit; `None` if it is one.
    pub scale: Option<Value>,
    /// The description of the output.
    pub doc: String,
    /// The kind of computation, in SI units.
    pub kind: OutputKind,
}

/// The step, the end and the options of a run.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub struct Run {
    /// Step length.
    pub step: Value,
    /// The stop condition.
    pub until: Option<Condition<Quantity>>,
    /// The end; with a stop condition, the latest end.
    pub end_time: Value,
    /// Whether Jacobians of forces and constraints are generated, which implicit methods need.
    pub stiff: bool,
    /// Whether a function for inverse dynamics is generated.
    pub inverse: bool,
    /// The form of the kernel; `None` for the one with the fewest operations.
    pub elimination: Option<EliminationForm>,
}

/// The forms in which a kernel may solve the equations of motion.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, serde::Serialize, serde::Deserialize)]
pub enum EliminationForm {
    /// Constraints are solved for the dependent coordinates, `T' Mbar T` is factored.
    #[default]
    NullSpace,
    /// `Mbar` and `C_q Mbar^-1 C_q'` are factored.
    RangeSpace,
    /// Second rates of named quantities are unknowns too. On trees this is the articulated-body recursion.
    Sparse,
}

impl EliminationForm {
    /// All forms.
    pub const ALL: [Self; 3] = [Self::NullSpace, Self::RangeSpace, Self::Sparse];

    /// The name of the form in scenes.
    pub fn name(self) -> &'static str {
        match self {
            Self::NullSpace => "null-space",
            Self::RangeSpace => "range-space",
            Self::Sparse => "sparse",
        }
    }

    /// A description of the form in a few words.
    pub fn description(self) -> &'static str {
        match self {
            Self::NullSpace => "null space of C_q, or Mbar without constraints",
            Self::RangeSpace => "range space of C_q",
            Self::Sparse => "points and angles as unknowns",
        }
    }
}

/// The number of coordinates above which a scene is large.
pub const MANY_COORDINATES: usize = 12;
/// The number of coordinates above which a tree with `stiff = true` is large: generated Jacobians would expand sums of
/// angles.
const MANY_COORDINATES_WITH_JACOBIANS: usize = 6;

impl Scene {
    /// Whether points are variables of the equations of motion, which are then derived body by body: a scene with many
    /// coordinates, without constraints, that does not ask for inverse dynamics or another form of its kernel.
    pub fn is_large_tree(&self) -> bool {
        let many = if self.run.stiff { MANY_COORDINATES_WITH_JACOBIANS } else { MANY_COORDINATES };
        self.coordinates.len() > many
            && self.constraints.is_empty()
            && self.normal_forces().is_empty()
            && !self.run.inverse
            && self.run.elimination.is_none_or(|form| form == EliminationForm::Sparse)
    }

    /// The names that formulae can contain.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        let coordinates = self.coordinates.iter().map(|c| c.name.as_str());
        coordinates
            .chain(self.parameters.iter().map(|p| p.name.as_str()))
            .chain(self.points.iter().map(|p| p.name.as_str()))
    }

    /// The parameters that the generated code omits.
    pub fn left_out(&self) -> impl Iterator<Item = &Parameter> {
        self.parameters.iter().filter(|p| p.left_out)
    }

    /// Whether a load has a corner or a jump.
    pub fn has_corners(&self) -> bool {
        self.loads_contain(|node| node.is_piecewise())
    }

    /// Whether a load contains `sign`.
    pub fn has_jumps(&self) -> bool {
        self.loads_contain(|node| matches!(node, Node::Call(Function::Sign, _)))
    }

    fn loads_contain(&self, is_wanted: impl Fn(&Node<Quantity>) -> bool) -> bool {
        let formulae = self.loads.iter().flat_map(|load| load.kind.formulae());
        formulae.flat_map(|formula| formula.nodes()).any(is_wanted)
    }

    /// The outputs that are normal forces of friction, in their order.
    pub fn normal_forces(&self) -> Vec<usize> {
        let mut normals: Vec<usize> = self.loads.iter().filter_map(|load| load.kind.normal()).collect();
        normals.sort_unstable();
        normals.dedup();
        normals
    }

    /// The joints and loads whose friction depends on a joint force, in words.
    pub fn friction_by_forces(&self) -> impl Iterator<Item = &str> {
        self.loads.iter().filter_map(|load| match &load.kind {
            LoadKind::Spring { friction: Some(friction), .. } if friction.normal.is_some() => {
                Some(friction.owner.as_str())
            }
            _ => None,
        })
    }

    /// Whether a loop closure depends on time.
    pub fn is_driven(&self) -> bool {
        self.depends_on_time(self.constraints.iter().map(|constraint| &constraint.residual))
    }

    /// The driving constraints: drives of joints, and other constraints that depend on time.
    pub fn drives(&self) -> Vec<usize> {
        let is_drive = |i: &usize| {
            let constraint = &self.constraints[*i];
            constraint.is_drive || self.depends_on_time([&constraint.residual])
        };
        (0..self.constraints.len()).filter(is_drive).collect()
    }
}
