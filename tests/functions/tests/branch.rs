//! Designs are assembled on the branch of their scene, where its first guesses would lead to a mirrored position.
#![cfg(feature = "generate")]

use qrm_core::{Model, Replace};
use qrm_sim::batch::{LaneCount, SweepEnd, SweepRequest, sweep};
use qrm_sim::run::{Status, assemble, assembled};
use qrm_sim::start::Start;

fn model() -> &'static Model {
    qrm_functions::MODELS.iter().find(|model| model.description.name == "watt").expect("a generated scene")
}

/// The start with a length of the rocker, by Newton's method from the start with a length that is a little shorter.
fn followed(length: f64) -> Vec<f64> {
    let mut start = Start::of(&*model().mechanism(&|_| None));
    let steps = 1000;
    for i in 0..=steps {
        let now = 0.7 + (length - 0.7) * f64::from(i) / f64::from(steps);
        let mechanism = model().mechanism(&|name| (name == "l3").then_some(now));
        start.q = assemble(&*mechanism, &start).expect("it can be assembled").0;
    }
    start.q
}

#[test]
fn a_start_stays_on_its_branch() {
    let mut mirrored = 0;
    for length in [0.72, 1.0, 1.4, 1.5, 1.58] {
        let mechanism = model().mechanism(&|name| (name == "l3").then_some(length));
        let expected = followed(length);
        let near = |q: &[f64]| q.iter().zip(&expected).all(|(a, b)| (a - b).abs() < 1e-9);
        let found = assembled(&*mechanism).expect("it can be assembled").0;
        assert!(near(&found), "{length}: {found:?} instead of {expected:?}");
        let direct = assemble(&*mechanism, &Start::of(&*mechanism));
        mirrored += usize::from(!direct.is_ok_and(|(q, _)| near(&q)));
        // The branch ends at a length of 1.6, where links are in line.
        let replace = |name: &str| (name == "l3").then_some(length);
        let designs: [Replace; 1] = [&replace];
        let request =
            SweepRequest { step: None, end: Some(SweepEnd::Time(1e-9)), extremes: false, estimate_error: false };
        let result = &sweep(model(), &designs, &request, LaneCount::Most)[0];
        assert!(matches!(result.status, Ok(Status::Completed)), "{:?}", result.status);
        assert!(result.q.iter().zip(&expected).all(|(a, b)| (a - b).abs() < 1e-7), "{length}: {:?}", result.q);
    }
    assert!(mirrored > 0, "the guesses lead to the branch by themselves");
    let beyond = model().mechanism(&|name| (name == "l3").then_some(1.61));
    assert!(assembled(&*beyond).is_err());
}
