//! The time scales of loads and drives that depend on time explicitly: steps must not skip their changes.

mod time_function;

use std::collections::BTreeSet;
use std::f64::consts::FRAC_PI_2;

use crate::expression::{Node, NodeId};
use crate::function::Function;
use crate::scene::{Quantity, Scene, Value};
use time_function::{TimeFunction, TimeFunctions};

/// A change with time that a formula shows explicitly.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TimeScale {
    /// A sine, cosine or tangent turns with time at this rate, in rad/s; or a function of one changes as fast.
    Period(f64),
    /// A change around a time: the argument of a function is zero there, and changes by one within the width.
    Moment {
        /// The time.
        time: f64,
        /// The width, in s.
        width: f64,
    },
}

/// Finds the time scales of the loads, drives and points of a scene, for these values of its parameters.
///
/// A time scale is found where a function is applied to `a + b*t + c*t^2`, to the size of `a + b*t`, or to
/// `a + b*sin(c*t + d)`, with any constant factors. Points and driven coordinates that are such functions of time are
/// substituted. Arguments that depend on time in another way, or on the motion too, give none.
pub fn time_scales(scene: &Scene, parameters: &[f64]) -> Vec<TimeScale> {
    let courses = TimeFunctions::new(scene, parameters);
    let mut scales = Vec::new();
    for value in formulae(scene) {
        for scale in formula_scales(value, &courses.time_functions(value)) {
            if !scales.contains(&scale) {
                scales.push(scale);
            }
        }
    }
    scales
}

/// The parameters on which the time scales of a scene may depend.
pub fn parameters_of_time_scales(scene: &Scene) -> BTreeSet<usize> {
    if depends_on_time(scene) { scene.parameters_of(formulae(scene)) } else { BTreeSet::new() }
}

/// The rates at which sines, cosines and tangents in the formulae of a scene turn evenly with time, in rad/s.
pub fn turning_rates(scene: &Scene, parameters: &[f64]) -> Vec<f64> {
    let courses = TimeFunctions::new(scene, parameters);
    let rates = formulae(scene).flat_map(|value| {
        let of_value = courses.time_functions(value);
        let rate = |node: &Node<Quantity>| match node {
            Node::Call(Function::Sin | Function::Cos | Function::Tan, arguments) => match of_value[arguments[0]] {
                Some(TimeFunction::Line { rate, .. }) if rate != 0.0 => Some(rate.abs()),
                _ => None,
            },
            _ => None,
        };
        value.nodes().iter().filter_map(rate).collect::<Vec<_>>()
    });
    rates.collect()
}

/// Whether a load, a constraint or a point depends on time.
pub fn depends_on_time(scene: &Scene) -> bool {
    scene.depends_on_time(formulae(scene))
}

/// The formulae of loads, constraints and points.
fn formulae(scene: &Scene) -> impl Iterator<Item = &Value> {
    let loads = scene.loads.iter().flat_map(|load| load.kind.formulae());
    let constraints = scene.constraints.iter().map(|constraint| &constraint.residual);
    loads.chain(constraints).chain(scene.points.iter().flat_map(|point| &point.position))
}

fn formula_scales(value: &Value, courses: &[Option<TimeFunction>]) -> Vec<TimeScale> {
    let mut scales: Vec<Vec<TimeScale>> = Vec::new();
    for (node, course) in value.nodes().iter().zip(courses) {
        // Lines, parabolas and products with zero have no time scale.
        let of_node = if matches!(course, Some(TimeFunction::Line { .. } | TimeFunction::Parabola { .. })) {
            Vec::new()
        } else {
            let of_operands = node.operands().into_iter().flat_map(|operand| scales[operand].clone());
            of_operands.chain(own_scales(node, courses)).collect()
        };
        scales.push(of_node);
    }
    let mut scales = scales.pop().unwrap_or_default();
    scales.retain(|scale| match scale {
        TimeScale::Period(rate) => rate.is_finite(),
        TimeScale::Moment { time, width } => time.is_finite() && width.is_finite(),
    });
    scales
}

/// The time scales of an operation whose operands are known functions of time.
fn own_scales(node: &Node<Quantity>, courses: &[Option<TimeFunction>]) -> Vec<TimeScale> {
    let moves = |id: &NodeId| courses[*id].filter(|course| course.fixed().is_none());
    let smooth = |id: &NodeId| moves(id).into_iter().flat_map(smooth_scales).collect();
    let proportional = |id: &NodeId| moves(id).into_iter().flat_map(proportional_scales).collect();
    match node {
        Node::Call(Function::Min | Function::Max, arguments) => {
            // Where the two are equal, the larger and the smaller one are exchanged.
            let [Some(a), Some(b)] = [0, 1].map(|i| courses[arguments[i]]) else { return Vec::new() };
            let difference = a.plus(b.scaled(-1.0, 0.0)).filter(|course| course.fixed().is_none());
            difference.into_iter().flat_map(corner_scales).collect()
        }
        Node::Call(Function::Abs | Function::Sign, arguments) => {
            moves(&arguments[0]).map_or_else(Vec::new, corner_scales)
        }
        Node::Call(Function::Sin | Function::Cos | Function::Tan, arguments) => match moves(&arguments[0]) {
            Some(TimeFunction::Line { rate, .. }) => vec![TimeScale::Period(rate.abs())],
            Some(course) => smooth_scales(course),
            None => Vec::new(),
        },
        Node::Call(Function::Log | Function::Sqrt, arguments) => proportional(&arguments[0]),
        Node::Call(_, arguments) => arguments.iter().filter_map(moves).flat_map(smooth_scales).collect(),
        Node::Spline(spline, argument) if node.is_piecewise() => {
            let from = |corner: &f64| moves(argument).map(|course| course.scaled(1.0, -corner));
            spline.corners().iter().filter_map(from).flat_map(corner_scales).collect()
        }
        Node::Spline(spline, argument) => match moves(argument) {
            Some(TimeFunction::Line { rate, .. }) => vec![TimeScale::Period(rate.abs() / spline.shortest_interval())],
            Some(course) => smooth_scales(course),
            None => Vec::new(),
        },
        // A square of a sine is as smooth as the sine, and other powers nearly so.
        Node::Power(a, _) if !matches!(moves(a), Some(TimeFunction::Turning { .. })) => proportional(a),
        Node::Divide(_, a) => proportional(a),
        Node::Multiply(a, b) if moves(a).is_some() && moves(a) == moves(b) => smooth(b),
        _ => Vec::new(),
    }
}

/// The time scales of a smooth function: around times at which its argument passes zero or turns back, until the
/// argument has changed by one.
fn smooth_scales(course: TimeFunction) -> Vec<TimeScale> {
    match course {
        TimeFunction::Line { at_zero, rate } => {
            vec![TimeScale::Moment { time: -at_zero / rate, width: rate.abs().recip() }]
        }
        TimeFunction::Parabola { value, bend, time } => {
            let mut moments = vec![TimeScale::Moment { time, width: bend.abs().sqrt().recip() }];
            if let Some(half) = half_distance(value, bend) {
                let width = bend.abs().recip() / (half + (half * half + bend.abs().recip()).sqrt());
                moments.extend([time - half, time + half].map(|time| TimeScale::Moment { time, width }));
            }
            moments
        }
        TimeFunction::Bent { rate, time, .. } => vec![TimeScale::Moment { time, width: rate.abs().recip() }],
        TimeFunction::Turning { middle, amplitude, rate } => {
            let slope = rate * (amplitude * amplitude - middle * middle).max(0.0).sqrt();
            let bend = amplitude.abs() * rate * rate;
            vec![each(2.0 / (slope + (slope * slope + 2.0 * bend).sqrt()))]
        }
    }
}

/// The time scales of a smooth function that depends on the ratio of two arguments: a power, a fraction.
fn proportional_scales(course: TimeFunction) -> Vec<TimeScale> {
    match course {
        // It is twice its smallest value there.
        TimeFunction::Parabola { value, bend, time } if value / bend > 0.0 => {
            vec![TimeScale::Moment { time, width: (value / bend).sqrt() }]
        }
        course => smooth_scales(course),
    }
}

/// The time scales of a function with a corner where its argument is zero. Steps end at single corners anyway.
fn corner_scales(course: TimeFunction) -> Vec<TimeScale> {
    match course {
        TimeFunction::Parabola { value, bend, time } => {
            half_distance(value, bend).map(|width| TimeScale::Moment { time, width }).into_iter().collect()
        }
        TimeFunction::Turning { middle, amplitude, rate } => {
            // The shorter of the two times between consecutive zeros.
            let between = 2.0 * (middle / amplitude).abs().acos() / rate;
            if between > 0.0 { vec![each(0.5 * between)] } else { Vec::new() }
        }
        TimeFunction::Line { .. } | TimeFunction::Bent { .. } => Vec::new(),
    }
}

/// Half the time between two zeros of a parabola, if it has two.
fn half_distance(value: f64, bend: f64) -> Option<f64> {
    (value / bend < 0.0).then(|| (-value / bend).sqrt())
}

/// The time scale of periodic changes, each within this width.
fn each(width: f64) -> TimeScale {
    TimeScale::Period(FRAC_PI_2 / width)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::resolve::read;

    fn scene_with(force: &str) -> Scene {
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
        read("one.toml", &text).unwrap_or_else(|report| panic!("{report}")).0
    }

    fn scales(force: &str) -> Vec<TimeScale> {
        let scene = scene_with(force);
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
        assert_eq!(scales("tanh(4*(t - 2))"), [TimeScale::Moment { time: 2.0, width: 0.25 }]);
        assert_eq!(scales("1/(1 + ((t - 0.5)*4)*((t - 0.5)*4))"), [TimeScale::Moment { time: 0.5, width: 0.25 }]);
    }

    #[test]
    fn parabolas_have_scales_where_functions_bend_them() {
        let moments = |force: &str, expected: &[(f64, f64)]| {
            let found = scales(force);
            assert_eq!(found.len(), expected.len(), "{force}: {found:?}");
            for (scale, (at, wide)) in found.iter().zip(expected) {
                let TimeScale::Moment { time, width } = scale else { panic!("{force}: {scale:?}") };
                assert!((time - at).abs() <= 1e-9 && (width / wide - 1.0).abs() <= 1e-3, "{force}: {found:?}");
            }
        };
        for force in [
            "exp(-((t - 0.5)^2)/w^2)",
            "exp(-(t - 0.5)^2/(w*w))",
            "exp((t - 0.5)*(0.5 - t)/w^2)",
            "exp(-(t^2 - t + 0.25)/w^2)",
            "1/(w^2 + (t - 0.5)^2)",
            "(w^2 + (t - 0.5)^2)^(-3/2)",
            "max(w^2 - (t - 0.5)^2, 0)",
        ] {
            moments(force, &[(0.5, 1e-4)]);
        }
        // At its zeros, 0.2 and 0.8, its slope is 0.6/w; in the middle it changes by one within the root of w.
        moments("tanh((t - 0.2)*(t - 0.8)/w)", &[(0.5, 1e-2), (0.2, 1e-4 / 0.6), (0.8, 1e-4 / 0.6)]);
        moments("t^2 - 3*t + m*t*(t - 1)", &[]);
    }

    /// The longest step for a periodic change.
    fn width(force: &str) -> f64 {
        let rates = scales(force).into_iter().map(|scale| match scale {
            TimeScale::Period(rate) => rate,
            other => panic!("{force}: {other:?}"),
        });
        FRAC_PI_2 / rates.fold(0.0, f64::max)
    }

    #[test]
    fn corners_have_none() {
        for force in ["abs(2*t - 1)*m", "max(t, 0.25)", "max(0, 1 - abs(t - 0.5)/w)"] {
            assert_eq!(scales(force), [], "{force}");
        }
        assert!(matches!(scales("exp(-abs(t - 0.5)/w)")[..], [TimeScale::Moment { time: 0.5, .. }]));
    }

    #[test]
    fn functions_of_sines_may_be_narrower_than_a_period() {
        let near = |a: f64, b: f64| assert!((a - b).abs() <= 1e-2 * b.abs(), "{a} and {b}");
        // exp(-p sin^2(t/2)) falls to 1/e at 2/sqrt(p).
        near(width("exp(-1e8*sin(t/2)^2)"), 2e-4);
        near(width("exp(-(sin(3*t)/(3*w))^2)"), 1e-4);
        // The cosine is above 1 - w^2/2 for 2 w, which should take two steps.
        near(width("max(cos(t) - 1 + w^2/2, 0)"), 1e-4);
        near(width("tanh(100*sin(t))"), 0.01);
        // A function that is wider than the sine has the time scale of the sine.
        near(width("exp(0.1*sin(t))"), FRAC_PI_2);
        near(width("sin(t)^2"), FRAC_PI_2);
    }

    #[test]
    fn what_names_time_counts_as_time() {
        let text = r#"
name = "one"
coordinates = [{ name = "x", unit = "m" }, { name = "s", unit = "m" }]
[parameters]
m = 1
w = 1e-4
[points]
P = ['x', '0']
C = ['(t - 0.5)/w', '0']
[bodies]
b = { mass = 'm', com = "P" }
[constraints]
clock = { residual = 's - 2*t', unit = "m" }
[loads]
one = { force = ['exp(-C.x^2)', '0'], on = "b" }
two = { force = ['exp(-((s - 1.5)/w)^2)', '0'], on = "b" }
[initial]
given = { x = 0, x_dot = 0 }
solve = { s = 0 }
[run]
step = 1e-3
end_time = 1
"#;
        let scene = read("one.toml", text).unwrap_or_else(|report| panic!("{report}")).0;
        let scales = time_scales(&scene, &[1.0, 1e-4]);
        let moment = |at: f64, wide: f64| {
            scales.iter().any(|scale| {
                matches!(scale, TimeScale::Moment { time, width }
                    if (time - at).abs() < 1e-9 && (width / wide - 1.0).abs() < 1e-9)
            })
        };
        assert!(moment(0.5, 1e-4) && moment(0.75, 0.5e-4), "{scales:?}");
    }

    #[test]
    fn their_parameters_are_those_of_formulae_if_one_depends_on_time() {
        assert_eq!(parameters_of_time_scales(&scene_with("w*m*x")), BTreeSet::new());
        assert_eq!(parameters_of_time_scales(&scene_with("exp(-(t/w)^2)")), BTreeSet::from([1]));
        assert_eq!(parameters_of_time_scales(&scene_with("m*x*sin(2*t) + w")), BTreeSet::from([0, 1]));
    }

    #[test]
    fn what_is_straight_or_multiplied_by_zero_has_none() {
        for force in ["3*t + m", "z*sin(2*pi*f*t)", "x*t", "sin(x + t)", "exp(2*m)"] {
            assert_eq!(scales(force), [], "{force}");
        }
    }
}
