//! Random states, and the results of a tape's functions there.

use qrm_core::NamedTape;
use qrm_core::named_tape::Argument;
use qrm_language::ir::{Program, StructKind};

use super::libm::Libm;
use crate::verify::Evaluation;

pub(super) struct State {
    t: f64,
    /// The changes of the parameters.
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

/// The expected output of the program, with the names of the functions.
pub(super) fn expected<'p>(program: &'p Program, tape: &NamedTape, states: &[State]) -> Vec<(&'p str, f64)> {
    let defaults = Evaluation::<Libm>::parameters(tape, |_| None);
    let mut results = Vec::new();
    for state in states {
        // Every second one is replaced.
        let replaced = |i: usize| i.is_multiple_of(2).then(|| Libm(defaults[i].0 + state.change[i]));
        let parameters = Evaluation::parameters(tape, replaced);
        let on = |values: &[f64]| values.iter().map(|&value| Libm(value)).collect::<Vec<Libm>>();
        let arguments = [
            (Argument::Time, on(&[state.t])),
            (Argument::Coordinates, on(&state.q)),
            (Argument::Rates, on(&state.qd)),
            (Argument::Accelerations, on(&state.qdd)),
            (Argument::Multipliers, on(&state.multipliers)),
            (Argument::Residuals, on(&state.residuals)),
        ];
        let arguments = arguments.each_ref().map(|(argument, values)| (*argument, &values[..]));
        let evaluation = Evaluation::new(tape, &parameters, &arguments);
        let of = |name: &str| evaluation.results(name);
        let n = state.q.len();
        for function in &program.functions {
            let numbers = match &*function.name {
                "default_parameters" => defaults.clone(),
                "parameters_with" => parameters.clone(),
                "angles" => {
                    let angles = |compute: fn(f64) -> f64| {
                        let q = state.q.iter().zip(&tape.has_angle);
                        q.map(|(q, is_angle)| if *is_angle { compute(*q) } else { 0.0 }).collect::<Vec<f64>>()
                    };
                    on(&[angles(f64::sin), angles(f64::cos)].concat())
                }
                "start" => {
                    let given =
                        |values: &[bool]| -> Vec<f64> { values.iter().map(|&v| f64::from(u8::from(v))).collect() };
                    let (q, qd) = tape.given.split_at(n);
                    [of("start.q"), on(&given(q)), of("start.qd"), on(&given(qd))].concat()
                }
                "event" if tape.function("event").is_none() => vec![Libm(f64::NEG_INFINITY)],
                name => of(name),
            };
            results.extend(numbers.into_iter().map(|number| (function.name.as_str(), number.0)));
        }
    }
    results
}
