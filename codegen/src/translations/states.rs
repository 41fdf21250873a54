//! Random states, and what the functions of a module give there.

use std::collections::HashMap;

use super::interpret::{GeneratedModule, Value};
use super::libm::{self, Libm};
use qrm_language::ir::{Function, Program, Shape, StructKind};

pub(super) struct State {
    t: f64,
    /// What is added to parameters.
    change: Vec<f64>,
    q: Vec<f64>,
    qd: Vec<f64>,
    qdd: Vec<f64>,
    multipliers: Vec<f64>,
    residuals: Vec<f64>,
}

impl State {
    pub(super) fn random(program: &Program, count: usize) -> Vec<Self> {
        let mut random = fastrand::Rng::with_seed(7);
        let mut numbers =
            |count: usize, size: f64| -> Vec<f64> { (0..count).map(|_| size * (2.0 * random.f64() - 1.0)).collect() };
        let parameters = fields(program, StructKind::Parameters).len();
        let (n, m) = (program.coordinates.len(), program.constraints.len());
        let mut state = || State {
            t: numbers(1, 1.0)[0],
            change: numbers(parameters, 0.01),
            q: numbers(n, 4.0),
            qd: numbers(n, 5.0),
            qdd: numbers(n, 9.0),
            multipliers: numbers(m, 30.0),
            residuals: numbers(m, 0.1),
        };
        (0..count).map(|_| state()).collect()
    }

    /// All numbers, in the order in which the program reads them.
    pub(super) fn numbers(&self) -> Vec<f64> {
        let Self { t, change, q, qd, qdd, multipliers, residuals } = self;
        [&vec![*t], change, q, qd, qdd, multipliers, residuals].into_iter().flatten().copied().collect()
    }
}

/// The names of a struct's fields.
pub(super) fn fields(program: &Program, kind: StructKind) -> Vec<&str> {
    let fields =
        program.structs.iter().find(|structure| structure.kind == kind).map_or(&[][..], |structure| &structure.fields);
    fields.iter().map(|field| field.name.as_str()).collect()
}

/// The numbers that the program prints, with the names of the functions that give them.
pub(super) fn expected<'p>(program: &'p Program, module: &syn::File, states: &[State]) -> Vec<(&'p str, f64)> {
    let generated = GeneratedModule::new(module).expect("a module");
    let mut results = Vec::new();
    for state in states {
        let mut values = Values::new(state);
        for function in &program.functions {
            let value = values.call(program, &generated, function, &state.change);
            results
                .extend(numbers(program, function, &value).into_iter().map(|number| (function.name.as_str(), number)));
        }
    }
    results
}

/// Arguments of functions by their names.
struct Values {
    named: HashMap<String, Value<Libm>>,
    /// What replaces parameters.
    replace: Vec<f64>,
}

impl Values {
    fn new(state: &State) -> Self {
        let lists = [
            ("q", &state.q),
            ("qd", &state.qd),
            ("qdd", &state.qdd),
            ("multipliers", &state.multipliers),
            ("residuals", &state.residuals),
        ];
        let mut named: HashMap<String, Value<Libm>> =
            lists.into_iter().map(|(name, list)| (name.to_owned(), Value::list(list))).collect();
        named.insert("t".to_owned(), Value::Number(Libm(state.t)));
        Self { named, replace: Vec::new() }
    }

    /// The result of a function, kept where others need it.
    fn call(
        &mut self,
        program: &Program,
        generated: &GeneratedModule,
        function: &Function,
        change: &[f64],
    ) -> Value<Libm> {
        let name = function.name.as_str();
        match name {
            "default_parameters" => {
                let defaults = generated.method::<Libm>("with", &[Value::Nothing]).expect("parameters");
                let number = |name: &&str| defaults.field(name).expect("a field").numbers()[0].0;
                let names = fields(program, StructKind::Parameters);
                let places = names.iter().zip(change).enumerate();
                // Every other one is replaced.
                let replace =
                    places.map(|(i, (name, change))| if i % 2 == 1 { f64::NAN } else { number(name) + change });
                self.replace = replace.collect();
                defaults
            }
            "parameters_with" => {
                libm::replace(&self.replace);
                let parameters = generated.method::<Libm>("with", &[Value::Nothing]).expect("parameters");
                self.named.insert("p".to_owned(), parameters.clone());
                self.named.insert("m".to_owned(), Value::fields([("parameters", parameters.clone())]));
                parameters
            }
            "constants" => {
                let p = self.named["p"].clone();
                let constants = generated.method("Constants::new", std::slice::from_ref(&p)).expect("constants");
                self.named.insert("m".to_owned(), Value::fields([("parameters", p), ("constants", constants.clone())]));
                constants
            }
            "angles" => {
                let is_angle = generated.method::<Libm>("has_angle", &[Value::Nothing]).expect("truths").truths();
                let of = |compute: fn(f64) -> f64| {
                    let q = self.named["q"].numbers().into_iter().zip(&is_angle);
                    Value::list(&q.map(|(q, is_angle)| if *is_angle { compute(q.0) } else { 0.0 }).collect::<Vec<_>>())
                };
                let angles = Value::fields([("sin", of(f64::sin)), ("cos", of(f64::cos))]);
                self.named.insert("angles".to_owned(), angles.clone());
                angles
            }
            _ => {
                let value = match generated.functions.get(name) {
                    Some(item) => generated.value(name, &self.arguments(&item.sig)),
                    None => generated.method(name, &self.arguments(&generated.methods[name].sig)),
                };
                // The interpreter knows no options.
                let without = Value::Number(Libm(f64::NEG_INFINITY));
                let value = if name == "event" { value.unwrap_or(without) } else { value.expect(name) };
                if name == "position" {
                    self.named.insert(name.to_owned(), value.clone());
                }
                value
            }
        }
    }

    fn arguments(&self, signature: &syn::Signature) -> Vec<Value<Libm>> {
        let value = |input: &syn::FnArg| match input {
            syn::FnArg::Receiver(_) => self.named["m"].clone(),
            syn::FnArg::Typed(input) => match &*input.pat {
                syn::Pat::Ident(name) => self.named[name.ident.to_string().trim_start_matches('_')].clone(),
                _ => panic!("an argument without a name"),
            },
        };
        signature.inputs.iter().map(value).collect()
    }
}

/// The numbers of a result in their order.
fn numbers(program: &Program, function: &Function, value: &Value<Libm>) -> Vec<f64> {
    let plain = |value: &Value<Libm>| value.numbers().into_iter().map(|number| number.0).collect::<Vec<_>>();
    let of = |name: &str| value.field(name).expect("a field");
    match &function.results[..] {
        [result] => match result.shape {
            Shape::Struct(StructKind::Angles) => ["sin", "cos"].into_iter().flat_map(|name| plain(of(name))).collect(),
            Shape::Struct(kind) => fields(program, kind).into_iter().flat_map(|name| plain(of(name))).collect(),
            _ => plain(value),
        },
        _ if matches!(value, Value::List(_)) => plain(value),
        results => {
            let number = |result: &qrm_language::ir::Variable| match result.shape {
                Shape::Booleans(_) => of(&result.name).truths().into_iter().map(|t| f64::from(u8::from(t))).collect(),
                _ => plain(of(&result.name)),
            };
            results.iter().flat_map(number).collect()
        }
    }
}
