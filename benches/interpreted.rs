//! Interpreted mechanisms against compiled ones: one run by fixed steps and by chosen steps, and a sweep in lanes.
//!
//! `cargo bench --bench interpreted`

#[allow(dead_code, reason = "other benches count instructions")]
mod measure;

use std::hint::black_box;
use std::time::Instant;

use qrm_core::{Model, ParameterOverrides};
use qrm_sim::batch::{LaneCount, SweepRequest, sweep};
use qrm_sim::integrate::{DOP853, GAUSS, Method, MethodSettings, RK4};
use qrm_sim::run::{Request, simulate};

const SCENES: [&str; 3] = ["quick-return", "four-bar", "andrews"];
const RUNS: usize = 10;
const DESIGNS: usize = 64;

const METHODS: [&Method; 3] = [RK4, DOP853, GAUSS];

/// Nanoseconds of integration a step.
fn one(model: &Model, method: &'static Method) -> f64 {
    let mechanism = model.mechanism(&|_| None);
    let settings = MethodSettings::new(method, 1e-9);
    let request = Request { settings, ..Request::default() };
    let mut times: Vec<f64> = (0..RUNS)
        .map(|_| match simulate(black_box(&*mechanism), &request, &mut ()) {
            Ok(outcome) => outcome.integration.as_secs_f64() * 1e9 / outcome.counts.accepted as f64,
            Err(_) => f64::NAN,
        })
        .collect();
    times.sort_by(f64::total_cmp);
    times[RUNS / 2]
}

/// Microseconds a design in the most lanes.
fn designs(model: &Model) -> f64 {
    let parameter = model.description.parameters[0].name;
    let value = model.parameter_values(&|_| None)[0];
    let factor = |i: usize| 1.0 + 0.02 * i as f64 / DESIGNS as f64;
    let replacements: Vec<_> =
        (0..DESIGNS).map(|i| move |name: &str| (name == parameter).then_some(value * factor(i))).collect();
    let designs: Vec<ParameterOverrides> = replacements.iter().map(|replace| replace as ParameterOverrides).collect();
    let settings = MethodSettings::new(DOP853, 1e-9);
    let request = SweepRequest { settings, extremes: false, estimate_error: false, ..SweepRequest::default() };
    let begun = Instant::now();
    black_box(sweep(model, black_box(&designs), &request, LaneCount::Most));
    begun.elapsed().as_secs_f64() * 1e6 / DESIGNS as f64
}

fn main() {
    println!("{:32} {:>26} {:>26} {:>24}", "", "compiled", "interpreted", "ratio");
    for compiled in qrm_model::MODELS.iter().filter(|model| SCENES.contains(&model.description.name)) {
        let models = [*compiled, compiled.without_compiled_functions()];
        let name = compiled.description.name;
        for method in METHODS {
            let times = measure::in_turn(2, |i| one(&models[i], method));
            show(&format!("{name}, {}, ns a step", method.name), &times);
        }
        show(&format!("{name}, sweep, us a design"), &measure::in_turn(2, |i| designs(&models[i])));
    }
}

fn show(what: &str, times: &[measure::Spread]) {
    let [compiled, interpreted] = times else { return };
    println!(
        "{what:32} {:>26} {:>26} {:>24}",
        compiled.show(1),
        interpreted.show(1),
        interpreted.over(compiled).show(2)
    );
}
