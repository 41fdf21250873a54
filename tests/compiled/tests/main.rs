//! Compiled scenes, all of them: `QRM_SCENES=all cargo test --release -p qrm-compiled`. Nothing in other builds.
#![cfg(all_scenes)]

mod evaluators;
mod interpreted;
mod inverse;
mod steps_in_c;

/// The mechanism of this name.
fn model(name: &str) -> &'static qrm_core::Model {
    qrm_model::MODELS.iter().find(|model| model.description.name == name).expect("a scene of the repository")
}

/// Asserts that two numbers differ by no more than allowed.
#[track_caller]
fn near(what: &str, got: f64, expected: f64, allowed: f64) {
    let error = (got - expected).abs();
    assert!(error <= allowed, "{what}: {got:?} instead of {expected:?}, off by {error:e}");
}
