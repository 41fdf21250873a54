//! A load shorter than any step, known by its formula, is not stepped over.
use qrm_core::Mechanism;
use qrm_scene::evaluate::parameter_values;
use qrm_scene::resolve::read;
use qrm_scene::time_scales::{TimeScale, time_scales};
use qrm_sim::analysis::{EnergyIntegral, NoEnergyIntegral};
use qrm_sim::integrate::{MethodSettings, StepBounds, method_named};
use qrm_sim::run::{Outcome, Request, simulate};

fn mechanism(width: f64) -> Box<dyn Mechanism> {
    let model =
        qrm_functions::MODELS.iter().find(|model| model.description.name == "pulse").expect("a generated scene");
    model.mechanism(&|name| (name == "wb").then_some(width))
}

fn run(mechanism: &dyn Mechanism, settings: MethodSettings, step: Option<f64>) -> Outcome {
    let request = Request { settings, step, estimate_error: true, ..Request::default() };
    let outcome = simulate(mechanism, &request, &mut ()).expect("the run starts");
    assert!(outcome.status.is_done(), "{outcome:?}");
    outcome
}

#[test]
fn a_blow_is_no_potential() {
    let mechanism = mechanism(1e-4);
    let found = EnergyIntegral::new(&*mechanism, 1.0, 96.0).err();
    assert_eq!(found, Some(NoEnergyIntegral::NotConservative));
    // Until then nothing happens.
    assert!(EnergyIntegral::new(&*mechanism, 0.2, 96.0).is_ok());
}

#[test]
#[ignore = "full tier: compiled"]
fn a_blow_that_no_step_would_meet_is_seen() {
    for width in [1e-4, 2e-5] {
        let mechanism = mechanism(width);
        // Steps much shorter than the blow.
        let exact = run(&*mechanism, MethodSettings::default(), Some(0.01 * width)).q;
        for name in ["dopri5", "dop853", "gauss"] {
            let settings = MethodSettings::new(method_named(name).expect("a method"), 1e-10);
            let blind = run(&*mechanism, settings, None);
            assert!((blind.q[0] - exact[0]).abs() > 1.0, "{name} sees it without being told: {:?}", blind.q);
            let step_bounds = StepBounds::new(f64::INFINITY, &[0.50037 - width, 0.50037, 0.50037 + width]);
            let seeing = run(&*mechanism, MethodSettings { step_bounds, ..settings }, None);
            assert!((seeing.q[0] - exact[0]).abs() < 1e-7, "{name}: {:?} instead of {exact:?}", seeing.q);
        }
    }
}

#[test]
fn the_formula_tells_when_the_blow_falls() {
    let (scene, _) = read("pulse.toml", include_str!("../pulse.toml")).unwrap_or_else(|report| panic!("{report}"));
    let found = time_scales(&scene, &parameter_values(&scene, |_| None));
    // The shaker is off.
    let [TimeScale::Moment { time, width }] = found[..] else { panic!("{found:?}") };
    assert!((time - 0.50037).abs() < 1e-12 && (width - 1e-4).abs() < 1e-16, "{found:?}");
    let shaken = time_scales(&scene, &parameter_values(&scene, |name| (name == "Fs").then_some(1.0)));
    assert!(shaken.iter().any(|scale| matches!(scale, TimeScale::Period(rate) if (rate - 6283.185).abs() < 1e-3)));
}
