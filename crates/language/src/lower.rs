//! Converts a tape into the program from which C and MATLAB are written.

mod expression;
mod functions;
mod scope;

use qrm_core::NamedTape;
use qrm_core::named_tape;
use qrm_scene::names::module_name;
use qrm_scene::scene::Scene;

use crate::ir::{
    Builtin, Expression, Field, Function, Program, Quantity, Shape, Statement, Struct, StructKind, Variable,
};
use crate::texts::{self, lines};
use functions::Lower;

/// Creates the program of a scene.
pub(super) fn program(scene: &Scene, tape: &NamedTape, source: &str) -> Program {
    let quantity = |name: &str, unit: &str, doc: &str| Quantity {
        name: name.to_owned(),
        unit: unit.to_owned(),
        doc: doc.to_owned(),
    };
    let lower = Lower { tape };
    let mut functions = lower.parameters();
    functions.extend(lower.constants());
    for (name, doc) in METHODS {
        functions.push(match tape.function(name) {
            Some(own) => lower.function(own, doc, scene),
            None => lower.never(name, doc),
        });
    }
    functions.push(angles(&tape.has_angle));
    let is_printed = |own: &&named_tape::Function| crate::rust::is_module_function(&own.name);
    functions.extend(tape.functions.iter().filter(is_printed).map(|own| {
        let doc = texts::function(scene, tape, own);
        lower.function(own, &doc, scene)
    }));
    Program {
        name: module_name(&scene.name),
        doc: lines(&texts::mechanism(scene, source)),
        notes: tape.notes.clone(),
        coordinates: scene.coordinates.iter().map(|c| quantity(&c.name, &c.unit, &c.doc)).collect(),
        constraints: scene.constraints.iter().map(|c| quantity(&c.name, &c.unit, &c.doc)).collect(),
        outputs: scene.outputs.iter().map(|o| quantity(&o.name, &o.unit, &o.doc)).collect(),
        has_angle: tape.has_angle.clone(),
        is_length: scene.coordinates.iter().map(|coordinate| coordinate.unit != "rad").collect(),
        structs: structs(scene, tape),
        functions,
    }
}

/// Methods in Rust that are functions in other languages.
const METHODS: [(&str, &str); 3] = [
    ("start", "The start of the motion: given values, and first guesses of the others."),
    ("schedule", "Step and end of the motion, in s."),
    ("event", "A value that rises through zero when the stop condition becomes true; minus infinity without one."),
];

fn structs(scene: &Scene, tape: &NamedTape) -> Vec<Struct> {
    let kept = scene.parameters.iter().filter(|p| !p.left_out);
    let parameter = |p: &qrm_scene::scene::Parameter| Field { name: p.name.clone(), doc: vec![texts::parameter(p)] };
    let fields = |name: &str| -> Option<Vec<Field>> {
        let field = |part: &named_tape::ResultField| Field { name: part.name.clone(), doc: lines(&part.doc) };
        tape.function(name).map(|own| own.parts.iter().map(field).collect())
    };
    let parameters = Some(kept.map(parameter).collect());
    [
        (StructKind::Parameters, texts::PARAMETERS, parameters),
        (StructKind::Constants, texts::CONSTANTS, fields("constants")),
        (StructKind::Position, texts::POSITION, fields("position")),
    ]
    .into_iter()
    .filter_map(|(kind, doc, fields)| Some(Struct { kind, doc: vec![doc.to_owned()], fields: fields? }))
    .collect()
}

/// The function that computes sines and cosines.
fn angles(is_angle: &[bool]) -> Function {
    let mut body = Vec::new();
    for (i, is_angle) in is_angle.iter().enumerate() {
        for (field, builtin) in [("sin", Builtin::Sin), ("cos", Builtin::Cos)] {
            let value = match is_angle {
                true => Expression::Call(builtin, vec![Expression::name("q").element(i)]),
                false => Expression::Number("0.0".to_owned()),
            };
            body.push(Statement::Assign { place: Expression::name("angles").field(field).element(i), value });
        }
    }
    let q = Variable { name: "q".to_owned(), shape: Shape::Vector(is_angle.len()) };
    let angles = Variable { name: "angles".to_owned(), shape: Shape::Struct(StructKind::Angles) };
    let doc = "Sines and cosines of the coordinates that are angles; zero in the places of others.";
    Function { name: "angles".to_owned(), doc: vec![doc.to_owned()], arguments: vec![q], results: vec![angles], body }
}
