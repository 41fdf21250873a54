//! A generated module is run, as syntax, before it is written, and compared with the scene itself: formulae evaluated
//! with automatic differentiation that shares nothing with the engine, the graph or the printer.

mod equations;
mod expected;
mod gradients;
mod interpret;
mod kernel;
mod linearization;
mod loads;
mod sample;
mod tape;

use std::collections::HashMap;

use syn::{ImplItem, Item};

use crate::emit::OwnedTape;
use crate::term::{Equations, Symbol, Term};
use expected::Expected;
use interpret::{Value, run, run_block};
use qrm_scene::evaluate::{State, constant, parameter_values};
use qrm_scene::scene::{Coordinate, Scene, Start, Value as Formula};
use sample::Sample;

/// How many random states are compared; fewer of large mechanisms, whose matrices are mostly zeros.
const STATES: usize = 40;
/// So many numbers are compared at least.
const NUMBERS: usize = 400;
/// How many random states may lie outside the domain of the formulae for each that lies inside.
const PATIENCE: usize = 50;
/// Largest difference of a number, relative to itself or to a thousandth of its largest value at any state.
const TOLERANCE: f64 = 1e-9;
/// Largest difference relative to the largest number of the function: what rounding leaves of terms that cancel.
const ROUNDING: f64 = 1e-14;
/// The largest number at a state counts for [`ROUNDING`] up to this size.
const TYPICAL: f64 = 100.0;
/// Where inputs that differ by a few units in the last place change a value by more than this fraction of a difference,
/// the difference says nothing.
const CONDITION: f64 = 1e-4;

/// Why a module must not be written.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Unverified {
    /// A function does not compute what the scene says.
    #[error("{0}\nnothing was written; this is a mistake of the generator, please report it with the scene")]
    Wrong(String),
    /// The formulae have no value at almost any state.
    #[error("{0}\n  = help: look for roots and logarithms of negative numbers, and for numbers beyond 1e308")]
    NoDomain(String),
}

/// Compares the module with its scene at random states, half of them near the start, and its tape with the module.
///
/// # Errors
/// Which function differs, by how much, and where; or that the scene has no value to compare with.
pub fn verify(scene: &Scene, equations: &Equations, file: &syn::File, tape: &OwnedTape) -> Result<(), Unverified> {
    let tape = tape.tape();
    let module = Generated::new(file).map_err(Unverified::Wrong)?;
    let states = (NUMBERS / scene.coordinates.len().max(1)).clamp(STATES / 5, STATES);
    let mut random = fastrand::Rng::with_seed(1);
    let samples = (0..states * PATIENCE).map(|number| Sample::random(scene, number, &mut random));
    let known = samples.filter_map(|sample| sample.expected(scene, equations).map(|expected| (sample, expected)));
    let known: Vec<(Sample, Expected)> = known.take(states).collect();
    let scales = scales(&known);
    let mut agreed = 0;
    for (sample, expected) in &known {
        let second = second_derivatives(scene, equations, sample, expected, &scales);
        let agrees = agrees(scene, equations, &module, (sample, expected), &scales);
        let wrong = |difference| Unverified::Wrong(format!("scene `{}`: {difference}\nat {sample:?}", scene.name));
        second.map_err(wrong)?;
        let kernel_agrees = kernel::agrees(scene, &module, (sample, expected));
        agreed += usize::from(agrees.map_err(wrong)?);
        kernel_agrees.map_err(wrong)?;
        linearization::agrees(scene, equations, &module, sample).map_err(wrong)?;
        tape::agrees(scene, &module, &tape, sample).map_err(wrong)?;
    }
    let problem = if known.len() < states / 4 {
        format!("have a value at only {} of {} random states", known.len(), states * PATIENCE)
    } else if agreed < states / 4 {
        format!(
            "are at {} of {} random states so sensitive that nothing can be compared",
            known.len() - agreed,
            known.len()
        )
    } else {
        let plain = verify_plain(scene, &module).and_then(|()| tape::agrees_at_start(scene, &module, &tape));
        return plain.map_err(Unverified::Wrong);
    };
    Err(Unverified::NoDomain(format!("error: the formulae of scene `{}` {problem}", scene.name)))
}

/// The largest size of each number of each function at any state.
fn scales(known: &[(Sample, Expected)]) -> Vec<Vec<f64>> {
    let Some((_, first)) = known.first() else { return Vec::new() };
    let mut scales: Vec<Vec<f64>> = first.iter().map(|(_, numbers)| vec![0.0; numbers.len()]).collect();
    for (_, expected) in known {
        for (scales, (_, numbers)) in scales.iter_mut().zip(expected) {
            scales.iter_mut().zip(numbers).for_each(|(scale, number)| *scale = scale.max(number.abs()));
        }
    }
    scales
}

/// Whether every function gives what is expected; `false` where rounding errors hide whether it does.
fn agrees(
    scene: &Scene,
    equations: &Equations,
    module: &Generated,
    (sample, expected): (&Sample, &Expected),
    scales: &[Vec<f64>],
) -> Result<bool, String> {
    let model = module.model(scene, &sample.parameters)?;
    let largest = |numbers: &[f64]| numbers.iter().fold(0.0, |most: f64, number| most.max(number.abs()));
    let inside = sample.largest_in_loads(scene);
    let overall = expected.iter().fold(0.0, |most: f64, (_, numbers)| most.max(largest(numbers)));
    let mut all_compared = true;
    let mut last = ("", Value::Nothing);
    for (place, ((function, expected), scales)) in expected.iter().zip(scales).enumerate() {
        // Parts of a result stand one after another.
        let (whole, part) = function.split_once('.').unwrap_or((function, ""));
        if whole != last.0 {
            last = (whole, module.value(whole, &sample.arguments(scene, whole, model.clone()))?);
        }
        let got = if part.is_empty() { last.1.numbers() } else { last.1.field(part)?.numbers() };
        // Where all terms of a function cancel, its own size says nothing of their rounding errors.
        let floor = ROUNDING * largest(scales).max(overall.min(TYPICAL)).max(inside);
        let allowed = |i: usize| (TOLERANCE * expected[i].abs().max(1e-3 * scales[i])).max(floor);
        let Err((i, difference)) = compare(function, &got, expected, allowed) else { continue };
        let nearby = sample.nearby().expected(scene, equations);
        let spread = nearby.map_or(f64::INFINITY, |nearby| (nearby[place].1[i] - expected[i]).abs());
        if !(spread > CONDITION * (got[i] - expected[i]).abs()) {
            return Err(format!("generated `{function}` is wrong: {difference}"));
        }
        all_compared = false;
    }
    Ok(all_compared)
}

/// Compares `C_qq`, which no function computes but the derivation shows, contracted with the rates on both sides.
fn second_derivatives(
    scene: &Scene,
    equations: &Equations,
    sample: &Sample,
    expected: &Expected,
    scales: &[Vec<f64>],
) -> Result<(), String> {
    let Some(place) = expected.iter().position(|(name, _)| *name == "constraint_bias") else { return Ok(()) };
    let (nearby, quadratic_velocity_term) = (sample.nearby(), sample.quadratic_velocity_term(scene));
    for (k, (hessian, constraint)) in equations.constraint_hessians.iter().zip(&scene.constraints).enumerate() {
        let (expected, scale) = (quadratic_velocity_term[k], scales[place][k]);
        let contracted = contraction(hessian, sample);
        let difference = (contracted - expected).abs();
        let spread = (contraction(hessian, &nearby) - contracted).abs();
        if !(difference <= 1e-7 * expected.abs().max(scale)) && !(spread > CONDITION * difference) {
            return Err(format!(
                "the C_qq of the derivation is wrong: that of constraint `{}`, contracted with the rates, is {contracted:e} instead \
                 of {expected:e}",
                constraint.name
            ));
        }
    }
    Ok(())
}

fn contraction(hessian: &[Vec<Term>], sample: &Sample) -> f64 {
    let value = |symbol: Symbol| match symbol {
        Symbol::Parameter(i) => sample.parameters[i],
        Symbol::Pi => std::f64::consts::PI,
        Symbol::Coordinate(i) => sample.q[i],
        Symbol::Time => sample.t,
        _ => f64::NAN,
    };
    let row = |row: &Vec<Term>| {
        let entries = row.iter().zip(&sample.qd).filter(|(entry, _)| !entry.is_zero());
        entries.map(|(entry, v)| entry.evaluate(&value) * v).sum::<f64>()
    };
    hessian.iter().zip(&sample.qd).map(|(entries, v)| row(entries) * v).sum()
}

/// The first number that differs by more than allowed, and how.
fn compare(what: &str, got: &[f64], expected: &[f64], allowed: impl Fn(usize) -> f64) -> Result<(), (usize, String)> {
    if got.len() != expected.len() {
        let lengths = format!("{} numbers instead of {}", got.len(), expected.len());
        return Err((0, format!("`{what}` has {lengths}")));
    }
    for (i, (got, expected)) in got.iter().zip(expected).enumerate() {
        // Written so that a difference that is not a number counts as one.
        if !((got - expected).abs() <= allowed(i)) {
            return Err((i, format!("number {i} is {got:e} instead of {expected:e}")));
        }
    }
    Ok(())
}

/// Compares numbers that are computed in the same way.
fn same(what: &str, got: &[f64], expected: &[f64]) -> Result<(), String> {
    let allowed = |i: usize| 1e-12 * expected[i].abs().max(f64::MIN_POSITIVE);
    compare(what, got, expected, allowed)
        .map_err(|(_, difference)| format!("generated `{what}` is wrong: {difference}"))
}

/// Start, schedule and stop condition, at the scene's own parameters and at a random state.
fn verify_plain(scene: &Scene, module: &Generated) -> Result<(), String> {
    let parameters = parameter_values(scene, |_| None);
    let model = module.model(scene, &parameters)?;
    let constant = |value: &Formula| constant(value, &parameters);
    let set = module.method("with", &[Value::Nothing])?;
    for (parameter, value) in scene.parameters.iter().zip(&parameters).filter(|(p, _)| !p.left_out) {
        let name = crate::emit::field_name(&parameter.name);
        same(&format!("value of parameter {}", parameter.name), &set.field(&name)?.numbers(), &[*value])?;
    }
    let starts = |start: fn(&Coordinate) -> &Start| -> Vec<f64> {
        let value = |coordinate| match start(coordinate) {
            Start::Given(value) | Start::Guess(value) => constant(value),
            Start::Free => 0.0,
        };
        scene.coordinates.iter().map(value).collect()
    };
    let start = module.method("start", std::slice::from_ref(&model))?;
    same("start", &start.field("q")?.numbers(), &starts(|c| &c.position))?;
    same("start", &start.field("qd")?.numbers(), &starts(|c| &c.rate))?;
    let schedule = module.method("schedule", std::slice::from_ref(&model))?;
    same("schedule", &schedule.field("step")?.numbers(), &[constant(&scene.run.step)])?;
    same("schedule", &schedule.field("end_time")?.numbers(), &[constant(&scene.run.end_time)])?;
    if let Some(condition) = &scene.run.until {
        let mut random = fastrand::Rng::with_seed(2);
        for number in 0..PATIENCE {
            let sample = Sample::random(scene, number, &mut random);
            let state = State::plain(scene, &parameters, sample.t, &sample.q, &sample.qd);
            let expected = state.value(&condition.difference) * condition.comparison.sign();
            let arguments = [model.clone(), Value::Number(sample.t), Value::list(&sample.q), Value::list(&sample.qd)];
            if expected.is_finite() {
                same("event", &module.method("event", &arguments)?.numbers(), &[expected])?;
            }
        }
    }
    Ok(())
}

/// The functions of a module, ready to be run.
struct Generated<'f> {
    functions: HashMap<String, &'f syn::ItemFn>,
    methods: HashMap<String, &'f syn::ImplItemFn>,
}

impl<'f> Generated<'f> {
    fn new(file: &'f syn::File) -> Result<Self, String> {
        let mut generated = Self { functions: HashMap::new(), methods: HashMap::new() };
        for item in &file.items {
            match item {
                Item::Fn(function) => {
                    generated.functions.insert(function.sig.ident.to_string(), function);
                }
                Item::Impl(block) => {
                    let owner = match &*block.self_ty {
                        syn::Type::Path(path) => path.path.segments.last().map(|s| s.ident.to_string()),
                        _ => None,
                    };
                    let owner = owner.ok_or("an impl of something without a name")?;
                    for item in &block.items {
                        let ImplItem::Fn(method) = item else { continue };
                        let name = if owner == "Constants" {
                            "Constants::new".to_owned()
                        } else {
                            method.sig.ident.to_string()
                        };
                        generated.methods.entry(name).or_insert(method);
                    }
                }
                _ => {}
            }
        }
        Ok(generated)
    }

    /// The mechanism with these parameters.
    fn model(&self, scene: &Scene, parameters: &[f64]) -> Result<Value, String> {
        let kept = scene.parameters.iter().zip(parameters).filter(|(p, _)| !p.left_out);
        let field = |(p, value): (&qrm_scene::scene::Parameter, &f64)| {
            (crate::emit::field_name(&p.name), Value::Number(*value))
        };
        let parameters = Value::Fields(kept.map(field).collect());
        let mut fields = HashMap::from([("parameters".to_owned(), parameters.clone())]);
        if self.methods.contains_key("Constants::new") {
            fields.insert("constants".to_owned(), self.method("Constants::new", &[parameters])?);
        }
        Ok(Value::Fields(fields))
    }

    fn value(&self, name: &str, arguments: &[Value]) -> Result<Value, String> {
        let function = self.functions.get(name).ok_or_else(|| format!("no function `{name}` was generated"))?;
        run(function, arguments).map_err(|e| format!("generated `{name}`: {e}"))
    }

    fn call(&self, name: &str, arguments: &[Value]) -> Result<Vec<f64>, String> {
        let (name, part) = name.split_once('.').unwrap_or((name, ""));
        let value = self.value(name, arguments)?;
        Ok(if part.is_empty() { value.numbers() } else { value.field(part)?.numbers() })
    }

    fn method(&self, name: &str, arguments: &[Value]) -> Result<Value, String> {
        let method = self.methods.get(name).ok_or_else(|| format!("no method `{name}` was generated"))?;
        run_block(&method.sig, &method.block, arguments).map_err(|e| format!("generated `{name}`: {e}"))
    }
}

/// A random number between two others.
fn between(random: &mut fastrand::Rng, low: f64, high: f64) -> f64 {
    low + (high - low) * random.f64()
}
