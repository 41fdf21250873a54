//! Designs are assembled on the branch of their scene, where its first guesses would lead to a mirrored position.
use qrm_core::{Mechanism, Model, ParameterOverrides};
use qrm_sim::batch::{LaneCount, SweepRequest, sweep};
use qrm_sim::position::{Start, assemble, assemble_from_guesses};
use qrm_sim::run::{End, Status};

fn model() -> &'static Model {
    qrm_functions::MODELS.iter().find(|model| model.description.name == "watt").expect("a generated scene")
}

/// The scene with other parameters.
fn with(parameters: &[(&str, f64)]) -> Box<dyn Mechanism> {
    model().mechanism(&|name| parameters.iter().find(|(other, _)| *other == name).map(|(_, value)| *value))
}

/// The start with other parameters, by Newton's method from the start with parameters that differ a little less from
/// those of the scene.
fn followed(parameters: &[(&str, f64)]) -> Vec<f64> {
    let own = with(&[]);
    let mut start = Start::new(&*own);
    let steps = 1000;
    for i in 0..=steps {
        let now: Vec<(&str, f64)> = parameters
            .iter()
            .map(|(name, value)| {
                let place = model().description.parameters.iter().position(|other| other.name == *name);
                let own = own.parameters()[place.expect("a parameter")];
                (*name, own + (value - own) * f64::from(i) / f64::from(steps))
            })
            .collect();
        start.q = assemble_from_guesses(&*with(&now), &start).expect("it can be assembled").0;
    }
    start.q
}

#[test]
fn a_start_stays_on_its_branch() {
    let mut mirrored = 0;
    for length in [0.72, 1.0, 1.4, 1.5, 1.58] {
        let mechanism = with(&[("l3", length)]);
        let expected = followed(&[("l3", length)]);
        let near = |q: &[f64]| q.iter().zip(&expected).all(|(a, b)| (a - b).abs() < 1e-9);
        let found = assemble(&*mechanism, Start::new(&*mechanism)).expect("it can be assembled").0;
        assert!(near(&found), "{length}: {found:?} instead of {expected:?}");
        let direct = assemble_from_guesses(&*mechanism, &Start::new(&*mechanism));
        mirrored += usize::from(!direct.is_ok_and(|(q, _)| near(&q)));
        // The branch ends at a length of 1.6, where links are in line.
        let replace = |name: &str| (name == "l3").then_some(length);
        let designs: [ParameterOverrides; 1] = [&replace];
        let request = SweepRequest {
            end: Some(End::Time(1e-9)),
            extremes: false,
            estimate_error: false,
            ..SweepRequest::default()
        };
        let result = &sweep(model(), &designs, &request, LaneCount::Most)[0];
        assert!(matches!(result.status, Ok(Status::Completed)), "{:?}", result.status);
        assert!(result.q.iter().zip(&expected).all(|(a, b)| (a - b).abs() < 1e-7), "{length}: {:?}", result.q);
    }
    assert!(mirrored > 0, "the guesses lead to the branch by themselves");
    let longer = with(&[("l3", 1.61)]);
    assert!(assemble(&*longer, Start::new(&*longer)).is_err());
}

/// Two mirrored loops leave the sign of the determinant as it is.
#[test]
fn two_mirrored_loops_are_another_branch() {
    let parameters = [("l3", 0.24), ("xs", 0.95), ("ys", -0.04)];
    let expected = followed(&parameters);
    let mechanism = with(&parameters);
    let near = |q: &[f64]| q.iter().zip(&expected).all(|(a, b)| (a - b).abs() < 1e-9);
    let direct = assemble_from_guesses(&*mechanism, &Start::new(&*mechanism)).expect("it can be assembled").0;
    assert!(!near(&direct), "the guesses lead to the branch by themselves");
    let found = assemble(&*mechanism, Start::new(&*mechanism)).expect("it can be assembled").0;
    assert!(near(&found), "{found:?} instead of {expected:?}");
}
