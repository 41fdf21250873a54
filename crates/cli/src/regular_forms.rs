//! Rewrites constraints that are singular at some positions of a mechanism in a regular form.

use std::path::Path;
use std::sync::Arc;

use qrm_core::{Interval, Model};
use qrm_scene::direction::{Direction, directions};
use qrm_scene::expression::{Node, NodeId};
use qrm_scene::function::Function;
use qrm_scene::resolve;
use qrm_scene::scene::{Constraint, Quantity, Scene, Value};

use crate::error::{Error, Message};
use crate::scenes::cache::Entry;
use crate::scenes::{engine, scene_of_source};
use crate::setup::Setup;

/// The designs that use the same form of each constraint.
pub(crate) struct DesignSpace<'d> {
    /// The number of designs.
    pub(crate) count: usize,
    /// The value of a parameter in a design; `None` if it is not varied.
    pub(crate) value: &'d dyn Fn(usize, &str) -> Option<f64>,
    /// The ranges of these values.
    pub(crate) range: ParameterRange<'d>,
}

/// The range of a varied parameter; `None` if it is not varied.
type ParameterRange<'r> = &'r dyn Fn(&str) -> Option<Interval>;

/// A scene with rewritten constraints.
pub(crate) struct Rewritten {
    pub(crate) model: &'static Model,
    pub(crate) scene: Arc<Scene>,
    /// The messages about the rewritten constraints.
    pub(crate) notes: Vec<Message>,
}

/// Replaces the constraints that may be singular for these parameter values by regular forms; `None` if there are none,
/// or there is no engine to derive the result.
///
/// # Errors
/// The engine fails or is interrupted.
pub(crate) fn rewritten(setup: &Setup, range: ParameterRange) -> Result<Option<Rewritten>, Error> {
    let (path, source, scene) = (&setup.path, setup.description.source, &*setup.scene);
    let directions = directions(scene, source);
    if directions.is_empty() {
        return Ok(None);
    }
    let parameters = parameter_ranges(scene, &setup.parameters(), range);
    let may_be_singular = |direction: &Direction| {
        let residual = &scene.constraints[direction.constraint].residual;
        enclosure_of_node(scene, residual, direction.singular_component, &parameters).contains(0.0)
    };
    let mut singular: Vec<Direction> = directions.into_iter().filter(may_be_singular).collect();
    if singular.is_empty() {
        return Ok(None);
    }
    singular.sort_by_key(|direction| direction.span.start);
    let note = |Direction { constraint, singular_component, regular_form, .. }: &Direction| {
        let Constraint { name, residual, .. } = &scene.constraints[*constraint];
        let component = &source[residual.span(*singular_component)];
        let text =
            format!("constraint `{name}` is singular where {component} = 0, and is taken as `{regular_form}` instead");
        Message::new(text)
            .help(format!("`lambda_{name}` is the multiplier of that form; forces in joints are the same"))
    };
    let notes = singular.iter().map(note).collect();
    let mut text = source.to_owned();
    // From the end, so that the other locations stay valid.
    for direction in singular.iter().rev() {
        text.replace_range(direction.span.clone(), &direction.regular_form);
    }
    if engine::program().is_none() && Entry::new(&text).read(&text).is_none() {
        return Ok(None);
    }
    let model = scene_of_source(&[], Path::new(path), text)?.model;
    let scene = resolve::read_with(path, model.description.source, &setup.replace())?.0;
    Ok(Some(Rewritten { model, scene: Arc::new(scene), notes }))
}

/// The ranges of all parameters, including those that are not varied.
fn parameter_ranges(scene: &Scene, values: &[f64], range: ParameterRange) -> Vec<Interval> {
    let mut known: Vec<Interval> = values.iter().map(|value| Interval::point(*value)).collect();
    for (place, parameter) in scene.parameters.iter().enumerate() {
        let formula = &parameter.formula;
        if let Some(range) = range(&parameter.name) {
            known[place] = range;
        } else if scene.parameters_of([formula]).iter().any(|other| known[*other].width() > 0.0) {
            known[place] = enclosure(scene, formula, &known);
        }
    }
    known
}

/// The range of a formula over all positions and times.
fn enclosure(scene: &Scene, value: &Value, parameters: &[Interval]) -> Interval {
    enclosure_of_node(scene, value, value.nodes().len() - 1, parameters)
}

/// The range of an operation of a formula over all positions and times.
fn enclosure_of_node(scene: &Scene, value: &Value, id: NodeId, parameters: &[Interval]) -> Interval {
    let of = |id: &NodeId| enclosure_of_node(scene, value, *id, parameters);
    match &value.nodes()[id] {
        Node::Number(number) => Interval::rounded(number.value),
        Node::Name(Quantity::Parameter(place)) => parameters[*place],
        Node::Name(Quantity::Point(place, axis)) => enclosure(scene, &scene.points[*place].position[*axis], parameters),
        Node::Name(Quantity::Pi) => Interval::pi(),
        Node::Negate(a) => -of(a),
        Node::Add(a, b) => of(a) + of(b),
        Node::Subtract(a, b) => of(a) - of(b),
        Node::Multiply(a, b) if a == b => of(a).square(),
        Node::Multiply(a, b) => of(a) * of(b),
        Node::Divide(a, b) => of(a) / of(b),
        Node::Power(a, _) if value.base(id, 2.0).is_some() => of(a).square(),
        Node::Power(a, _) if value.base(id, 0.5).is_some() => of(a).sqrt(),
        Node::Call(Function::Sin, a) => of(&a[0]).sin_cos().0,
        Node::Call(Function::Cos, a) => of(&a[0]).sin_cos().1,
        Node::Call(Function::Sqrt, a) => of(&a[0]).sqrt(),
        _ => Interval::ENTIRE,
    }
}
