//! Interpreted mechanisms against compiled ones: the same operations in the same order, so the same numbers.

use qrm_core::{Model, ParameterOverrides};
use qrm_sim::batch::{LaneCount, SweepRequest, sweep};
use qrm_sim::integrate::{METHODS, Method, MethodSettings};
use qrm_sim::run::{ErrorEstimates, Request, simulate};

use crate::model;

/// The rows of a run, its estimated errors at the end.
fn rows(model: &Model, method: &'static Method) -> Vec<f64> {
    struct Rows(Vec<f64>);

    impl qrm_sim::run::Observer for Rows {
        fn row(&mut self, row: &qrm_sim::run::Row) -> std::io::Result<()> {
            self.0.extend_from_slice(row.columns);
            Ok(())
        }
    }

    let settings = MethodSettings { method, ..MethodSettings::default() };
    let request = Request { settings, estimate_error: true, ..Request::default() };
    let mut rows = Rows(Vec::new());
    match simulate(&*model.mechanism(&|_| None), &request, &mut rows) {
        Ok(outcome) => rows.0.extend(outcome.errors.iter().flat_map(ErrorEstimates::coordinates)),
        Err(error) => panic!("{}: {error:?}", model.description.name),
    }
    rows.0
}

/// The largest difference, relative to 1 and the numbers.
fn difference(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    let apart = |(a, b): (&f64, &f64)| if a == b { 0.0 } else { (a - b).abs() / (1.0 + a.abs()) };
    a.iter().zip(b).map(apart).fold(0.0, |most: f64, apart| if apart.is_nan() { f64::NAN } else { most.max(apart) })
}

#[test]
fn every_method_gives_the_same_rows_of_every_scene() {
    for compiled in qrm_model::MODELS {
        let interpreted = compiled.without_compiled_functions();
        for method in METHODS {
            if method.needs_linearization && !compiled.mechanism(&|_| None).has_linearization() {
                continue;
            }
            let [own, other] = [compiled, &interpreted].map(|model| rows(model, method));
            let apart = difference(&own, &other);
            assert!(apart == 0.0, "{}, {}: {apart:e}", compiled.description.name, method.name);
        }
    }
}

#[test]
fn every_lane_ends_at_the_same_state() {
    for compiled in qrm_model::MODELS {
        let mechanism = compiled.mechanism(&|_| None);
        let Some(parameter) = compiled.description.parameters.first().map(|parameter| parameter.name) else { continue };
        let value = mechanism.parameters()[0];
        let factors: Vec<f64> = (0..20).map(|i| 1.0 + 1e-3 * f64::from(i)).collect();
        let replacements: Vec<_> =
            factors.iter().map(|factor| move |name: &str| (name == parameter).then_some(factor * value)).collect();
        let designs: Vec<ParameterOverrides> =
            replacements.iter().map(|replace| replace as ParameterOverrides).collect();
        let interpreted = compiled.without_compiled_functions();
        let request = SweepRequest::default();
        let [own, other] = [compiled, &interpreted].map(|model| sweep(model, &designs, &request, LaneCount::Most));
        for (own, other) in own.iter().zip(&other) {
            let name = compiled.description.name;
            assert_eq!(format!("{:?}", own.status), format!("{:?}", other.status), "{name}");
            // Large kernels are not compiled for lanes, but are interpreted in them.
            let allowed = if own.is_alone == other.is_alone { 0.0 } else { 1e-6 };
            let apart = difference(&own.q, &other.q).max(difference(&own.qd, &other.qd));
            assert!(apart <= allowed, "{name}: {apart:e}");
        }
    }
}

#[test]
fn an_interpreted_model_says_so() {
    let compiled = model("quick-return");
    assert!(!compiled.is_interpreted());
    assert!(compiled.without_compiled_functions().is_interpreted());
}
