//! Functions of time alone, in the forms whose changes are known in closed form.

use crate::expression::{Node, NodeId};
use crate::function::Function;
use crate::scene::{Quantity, Scene, Value};

/// A value as a function of time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum TimeFunction {
    /// `at_zero + rate*t`
    Line { at_zero: f64, rate: f64 },
    /// `value + bend*(t - time)^2`
    Parabola { value: f64, bend: f64, time: f64 },
    /// `value + rate*abs(t - time)`
    Bent { value: f64, rate: f64, time: f64 },
    /// `middle + amplitude*sin(rate*t + phase)`
    Turning { middle: f64, amplitude: f64, rate: f64 },
}

impl TimeFunction {
    /// The value, if it is constant.
    pub(super) fn fixed(self) -> Option<f64> {
        if let Self::Line { at_zero, rate: 0.0 } = self { Some(at_zero) } else { None }
    }

    /// `shift + factor*self`
    pub(super) fn scaled(self, factor: f64, shift: f64) -> Self {
        if factor == 0.0 {
            return Self::Line { at_zero: shift, rate: 0.0 };
        }
        match self {
            Self::Line { at_zero, rate } => Self::Line { at_zero: shift + factor * at_zero, rate: factor * rate },
            Self::Parabola { value, bend, time } => {
                Self::Parabola { value: shift + factor * value, bend: factor * bend, time }
            }
            Self::Bent { value, rate, time } => Self::Bent { value: shift + factor * value, rate: factor * rate, time },
            Self::Turning { middle, amplitude, rate } => {
                Self::Turning { middle: shift + factor * middle, amplitude: factor * amplitude, rate }
            }
        }
    }

    /// The sum, if it has such a form too.
    pub(super) fn plus(self, other: Self) -> Option<Self> {
        match (self, other) {
            (Self::Line { at_zero: a, rate: r }, Self::Line { at_zero: b, rate: s }) => {
                Some(Self::Line { at_zero: a + b, rate: r + s })
            }
            (Self::Parabola { value, bend, time }, Self::Line { at_zero, rate })
            | (Self::Line { at_zero, rate }, Self::Parabola { value, bend, time }) => {
                let shift = -0.5 * rate / bend;
                let value = value + at_zero + rate * (time + 0.5 * shift);
                Some(Self::Parabola { value, bend, time: time + shift })
            }
            _ => match (self.fixed(), other.fixed()) {
                (Some(shift), _) => Some(other.scaled(1.0, shift)),
                (_, Some(shift)) => Some(self.scaled(1.0, shift)),
                _ => None,
            },
        }
    }

    /// The product, if it has such a form too.
    fn times(self, other: Self) -> Option<Self> {
        match (self, other) {
            (Self::Line { at_zero: a, rate: r }, Self::Line { at_zero: b, rate: s }) => {
                let (bend, half) = (r * s, 0.5 * (a / r - b / s));
                Some(Self::Parabola { value: -bend * half * half, bend, time: -0.5 * (a / r + b / s) })
            }
            // The square of a sine is a cosine of twice the angle.
            (Self::Turning { middle: 0.0, amplitude, rate }, other) if self == other => {
                let half = 0.5 * amplitude * amplitude;
                Some(Self::Turning { middle: half, amplitude: half, rate: 2.0 * rate })
            }
            _ => None,
        }
    }
}

/// The functions of time of the names in formulae.
pub(super) struct TimeFunctions<'a> {
    parameters: &'a [f64],
    coordinates: Vec<Option<TimeFunction>>,
    points: Vec<[Option<TimeFunction>; 2]>,
}

impl<'a> TimeFunctions<'a> {
    /// Finds the functions of time of points and driven coordinates of a scene with these values of its parameters.
    pub(super) fn new(scene: &Scene, parameters: &'a [f64]) -> Self {
        let mut courses = Self { parameters, coordinates: vec![None; scene.coordinates.len()], points: Vec::new() };
        for constraint in &scene.constraints {
            courses.drive(&constraint.residual);
        }
        for point in &scene.points {
            let position =
                point.position.each_ref().map(|value| courses.time_functions(value).last().copied().flatten());
            courses.points.push(position);
        }
        courses
    }

    /// Records a drive, `q - f(t)` or `f(t) - q`.
    fn drive(&mut self, residual: &Value) {
        let nodes = residual.nodes();
        let Some(Node::Subtract(a, b)) = nodes.last() else { return };
        let courses = self.time_functions(residual);
        for (driven, by) in [(a, b), (b, a)] {
            if let (Node::Name(Quantity::Coordinate(i)), Some(course)) = (&nodes[*driven], courses[*by]) {
                self.coordinates[*i] = Some(course);
            }
        }
    }

    /// The functions of time of the nodes of a formula.
    pub(super) fn time_functions(&self, value: &Value) -> Vec<Option<TimeFunction>> {
        let mut courses = Vec::new();
        for node in value.nodes() {
            courses.push(self.time_function(node, &courses));
        }
        courses
    }

    fn time_function(&self, node: &Node<Quantity>, courses: &[Option<TimeFunction>]) -> Option<TimeFunction> {
        let course = |id: &NodeId| courses[*id];
        let fixed = |id: &NodeId| course(id).and_then(TimeFunction::fixed);
        let constant = |value: f64| Some(TimeFunction::Line { at_zero: value, rate: 0.0 });
        match node {
            Node::Number(number) => constant(number.value),
            Node::Name(Quantity::Time) => Some(TimeFunction::Line { at_zero: 0.0, rate: 1.0 }),
            Node::Name(Quantity::Parameter(i)) => constant(self.parameters[*i]),
            Node::Name(Quantity::Pi) => constant(std::f64::consts::PI),
            Node::Name(Quantity::Coordinate(i)) => self.coordinates[*i],
            Node::Name(Quantity::Point(i, axis)) => self.points.get(*i)?[*axis],
            Node::Name(_) => None,
            Node::Negate(a) => Some(course(a)?.scaled(-1.0, 0.0)),
            Node::Add(a, b) => course(a)?.plus(course(b)?),
            Node::Subtract(a, b) => course(a)?.plus(course(b)?.scaled(-1.0, 0.0)),
            Node::Multiply(a, b) => match (fixed(a), fixed(b)) {
                // A product with zero is constant, for any other factor.
                (Some(0.0), _) | (_, Some(0.0)) => constant(0.0),
                (Some(factor), _) => Some(course(b)?.scaled(factor, 0.0)),
                (_, Some(factor)) => Some(course(a)?.scaled(factor, 0.0)),
                _ => course(a)?.times(course(b)?),
            },
            Node::Divide(a, b) => Some(course(a)?.scaled(fixed(b)?.recip(), 0.0)),
            Node::Power(a, b) => match (fixed(a), fixed(b)?) {
                (Some(base), exponent) => constant(base.powf(exponent)),
                (None, 2.0) => course(a)?.times(course(a)?),
                _ => None,
            },
            Node::Call(function, arguments) => {
                let values: Option<Vec<f64>> = arguments.iter().map(fixed).collect();
                match (values, function, course(arguments.first()?)?) {
                    (Some(values), ..) => constant(function.evaluate(&values)),
                    (None, Function::Abs, TimeFunction::Line { at_zero, rate }) => {
                        Some(TimeFunction::Bent { value: 0.0, rate: rate.abs(), time: -at_zero / rate })
                    }
                    (None, Function::Sin | Function::Cos, TimeFunction::Line { rate, .. }) => {
                        Some(TimeFunction::Turning { middle: 0.0, amplitude: 1.0, rate: rate.abs() })
                    }
                    _ => None,
                }
            }
            Node::Spline(spline, argument) => constant(spline.value(0, fixed(argument)?)),
        }
    }
}
