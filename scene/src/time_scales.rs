//! How fast loads and drives change with time by themselves: what steps must not pass over.

use crate::expression::{Node, NodeId};
use crate::function::Function;
use crate::scene::{Quantity, Scene, Value};

/// A change with time that a formula shows by itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TimeScale {
    /// A sine, cosine or tangent turns with time, at so many radians a second.
    Period(f64),
    /// Something happens around a time: the argument of a function is zero there, and changes by one within the width.
    Moment {
        /// The time.
        time: f64,
        /// The width, in s.
        width: f64,
    },
    /// A formula has a corner or a jump at a time.
    Corner(f64),
}

/// The time scales of the loads, drives and points of a scene with these values of its parameters.
///
/// A time scale is found where a function is applied to `a + b*t`, with any factors of constants; arguments that depend
/// on time otherwise, or on the motion as well, have none.
pub fn time_scales(scene: &Scene, parameters: &[f64]) -> Vec<TimeScale> {
    let loads = scene.loads.iter().flat_map(|load| load.kind.formulae());
    let constraints = scene.constraints.iter().map(|constraint| &constraint.residual);
    let points = scene.points.iter().flat_map(|point| &point.position);
    let mut scales = Vec::new();
    let is_timed = |value: &&Value| value.names().any(|name| *name == Quantity::Time);
    for value in loads.chain(constraints).chain(points).filter(is_timed) {
        for scale in of_formula(value, parameters) {
            if !scales.contains(&scale) {
                scales.push(scale);
            }
        }
    }
    scales
}

/// A value that is a line in time: at zero, and its rate.
type Line = (f64, f64);

fn of_formula(value: &Value, parameters: &[f64]) -> Vec<TimeScale> {
    let mut lines: Vec<Option<Line>> = Vec::new();
    let mut scales: Vec<Vec<TimeScale>> = Vec::new();
    for node in value.nodes() {
        let line = line_of(node, parameters, &lines);
        // What is multiplied by zero does not matter, and a line has no scale.
        let of_node = if line.is_some() {
            Vec::new()
        } else {
            let of_operands = node.operands().into_iter().flat_map(|operand| scales[operand].clone());
            of_operands.chain(own_scales(node, &lines)).collect()
        };
        lines.push(line);
        scales.push(of_node);
    }
    let mut scales = scales.pop().unwrap_or_default();
    scales.retain(|scale| match scale {
        TimeScale::Period(rate) => rate.is_finite(),
        TimeScale::Moment { time, width } => time.is_finite() && width.is_finite(),
        TimeScale::Corner(time) => time.is_finite(),
    });
    scales
}

/// The time scales of an operation on lines.
fn own_scales(node: &Node<Quantity>, lines: &[Option<Line>]) -> Vec<TimeScale> {
    let moves = |id: &NodeId| lines[*id].filter(|(_, rate)| *rate != 0.0);
    match node {
        Node::Call(function @ (Function::Min | Function::Max), arguments) => {
            // Where the two are the same, the other one becomes the smaller or larger one.
            let [Some(a), Some(b)] = [0, 1].map(|i| lines[arguments[i]]) else { return Vec::new() };
            let difference = (a.0 - b.0, a.1 - b.1);
            if difference.1 == 0.0 { Vec::new() } else { vec![of_function(*function, difference)] }
        }
        Node::Call(function, arguments) => {
            arguments.iter().filter_map(moves).map(|line| of_function(*function, line)).collect()
        }
        Node::Power(a, _) | Node::Divide(_, a) => moves(a).into_iter().map(moment).collect(),
        Node::Multiply(a, b) if moves(a).is_some() => moves(b).into_iter().map(moment).collect(),
        _ => Vec::new(),
    }
}

fn of_function(function: Function, (at_zero, rate): Line) -> TimeScale {
    match function {
        Function::Sin | Function::Cos | Function::Tan => TimeScale::Period(rate.abs()),
        Function::Abs | Function::Sign | Function::Min | Function::Max => TimeScale::Corner(-at_zero / rate),
        _ => moment((at_zero, rate)),
    }
}

fn moment((at_zero, rate): Line) -> TimeScale {
    TimeScale::Moment { time: -at_zero / rate, width: rate.abs().recip() }
}

/// The value of a node as a line in time, if it is one.
fn line_of(node: &Node<Quantity>, parameters: &[f64], lines: &[Option<Line>]) -> Option<Line> {
    let line = |id: &NodeId| lines[*id];
    let fixed = |id: &NodeId| line(id).filter(|(_, rate)| *rate == 0.0).map(|(value, _)| value);
    Some(match node {
        Node::Number(number) => (number.value, 0.0),
        Node::Name(Quantity::Time) => (0.0, 1.0),
        Node::Name(Quantity::Parameter(i)) => (parameters[*i], 0.0),
        Node::Name(Quantity::Pi) => (std::f64::consts::PI, 0.0),
        Node::Name(_) => return None,
        Node::Negate(a) => line(a).map(|(value, rate)| (-value, -rate))?,
        Node::Add(a, b) => line(a).zip(line(b)).map(|(a, b)| (a.0 + b.0, a.1 + b.1))?,
        Node::Subtract(a, b) => line(a).zip(line(b)).map(|(a, b)| (a.0 - b.0, a.1 - b.1))?,
        Node::Multiply(a, b) => match (fixed(a), fixed(b)) {
            (Some(0.0), _) | (_, Some(0.0)) => (0.0, 0.0),
            (Some(factor), _) => line(b).map(|(value, rate)| (factor * value, factor * rate))?,
            (_, Some(factor)) => line(a).map(|(value, rate)| (factor * value, factor * rate))?,
            _ => return None,
        },
        Node::Divide(a, b) => {
            let divisor = fixed(b)?;
            line(a).map(|(value, rate)| (value / divisor, rate / divisor))?
        }
        Node::Power(a, b) => (fixed(a)?.powf(fixed(b)?), 0.0),
        Node::Call(function, arguments) => {
            let values = arguments.iter().map(fixed).collect::<Option<Vec<f64>>>()?;
            (function.evaluate(&values), 0.0)
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::resolve::read;

    fn scales(force: &str) -> Vec<TimeScale> {
        let text = format!(
            r#"name = "one"
coordinates = [{{ name = "x", unit = "m" }}]
[parameters]
m = 1
w = {{ value = 1e-4, unit = "s" }}
f = 1000
z = {{ value = 0, runtime = true }}
[points]
P = ['x', '0']
[bodies]
b = {{ mass = 'm', com = "P" }}
[loads]
F = {{ force = ['{force}', '0'], on = "b" }}
[initial]
given = {{ x = 0, x_dot = 0 }}
[run]
step = 1e-3
end_time = 1
"#
        );
        let scene = read("one.toml", &text).unwrap_or_else(|report| panic!("{report}")).0;
        let parameters = crate::evaluate::parameter_values(&scene, |_| None);
        time_scales(&scene, &parameters)
    }

    #[test]
    fn lines_in_time_have_scales_where_functions_bend_them() {
        let near = |a: f64, b: f64| (a - b).abs() <= 1e-12 * b.abs();
        let turn = scales("sin(2*pi*f*t)");
        assert!(matches!(turn[..], [TimeScale::Period(rate)] if near(rate, 2000.0 * std::f64::consts::PI)), "{turn:?}");
        let pulse = scales("m*exp(-((t - 0.5)/w)^2)");
        assert!(
            matches!(pulse[..], [TimeScale::Moment { time, width }] if near(time, 0.5) && near(width, 1e-4)),
            "{pulse:?}"
        );
        assert_eq!(scales("abs(2*t - 1)*m"), [TimeScale::Corner(0.5)]);
        assert_eq!(scales("max(t, 0.25)"), [TimeScale::Corner(0.25)]);
        assert_eq!(scales("tanh(4*(t - 2))"), [TimeScale::Moment { time: 2.0, width: 0.25 }]);
        assert_eq!(scales("1/(1 + ((t - 0.5)*4)*((t - 0.5)*4))"), [TimeScale::Moment { time: 0.5, width: 0.25 }]);
    }

    #[test]
    fn what_is_straight_or_multiplied_by_zero_has_none() {
        for force in ["3*t + m", "z*sin(2*pi*f*t)", "x*t", "sin(x + t)", "exp(2*m)"] {
            assert_eq!(scales(force), [], "{force}");
        }
    }
}
