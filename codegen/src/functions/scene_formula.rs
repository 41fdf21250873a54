//! Formulae that are evaluated as written: values of parameters, the start, the schedule.

use qrm_core::NamedTape;
use qrm_core::named_tape::{self, ResultField, Shape};
use qrm_scene::formula_tape::Formula;
use qrm_scene::scene::{Coordinate, Scene, Start};

/// The function for the scene's parameter values, each computed from earlier ones.
pub(super) fn parameters(scene: &Scene, tape: &mut NamedTape) -> named_tape::Function {
    let kept = || scene.parameters.iter().filter(|p| !p.left_out);
    let parts = kept().map(|p| {
        let value = Formula::new(scene, tape).value(&p.formula);
        ResultField { name: p.name.clone(), doc: String::new(), values: Shape::Scalar(value) }
    });
    named_tape::Function { name: "parameters".to_owned(), parts: parts.collect(), ..Default::default() }
}

/// The function for the start of the motion.
pub(super) fn start(scene: &Scene, tape: &mut NamedTape) -> named_tape::Function {
    let mut values = |start: fn(&Coordinate) -> &Start| {
        let each = scene.coordinates.iter().map(|coordinate| match start(coordinate) {
            Start::Given(value) | Start::Guess(value) => Formula::new(scene, tape).value(value),
            Start::Free => tape.number(0.0),
        });
        Shape::Vector(each.collect())
    };
    let (q, qd) = (values(|c| &c.position), values(|c| &c.rate));
    let parts =
        [("q", q), ("qd", qd)].map(|(name, values)| ResultField { name: name.to_owned(), doc: String::new(), values });
    named_tape::Function { name: "start".to_owned(), parts: parts.into(), ..Default::default() }
}

/// The function for the step and the end of the motion.
pub(super) fn schedule(scene: &Scene, tape: &mut NamedTape) -> named_tape::Function {
    let parts = [("step", &scene.run.step), ("end_time", &scene.run.end_time)].map(|(name, formula)| {
        let value = Formula::new(scene, tape).value(formula);
        ResultField { name: name.to_owned(), doc: String::new(), values: Shape::Scalar(value) }
    });
    named_tape::Function { name: "schedule".to_owned(), parts: parts.into(), ..Default::default() }
}
