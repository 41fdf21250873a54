//! The residuals of a motion under way, and the units of its columns.
use qrm_core::Model;
use qrm_sim::columns::columns;
use qrm_sim::integrate::MethodSettings;
use qrm_sim::run::Simulation;
use qrm_sim::solve::Projection;

fn model() -> &'static Model {
    qrm_functions::MODELS.iter().find(|model| model.description.name == "watt").expect("a generated scene")
}

#[test]
fn residuals_are_those_of_the_state() {
    let residuals = |projection| {
        let settings = MethodSettings { projection, ..MethodSettings::default() };
        let mut simulation = Simulation::new(model(), &|_| None, settings, Some(0.02)).expect("a start");
        simulation.advance(0.5).expect("a motion");
        simulation.residuals()
    };
    let [position, rate] = residuals(Projection::None);
    assert!((1e-9..1e-2).contains(&position) && (1e-9..1.0).contains(&rate), "{position:e} {rate:e}");
    assert!(residuals(Projection::Mass).iter().all(|residual| *residual < 1e-13));
}

#[test]
fn multipliers_of_lengths_are_forces() {
    let columns = columns(model().description);
    let column = columns.iter().find(|column| column.name == "lambda_bx").expect("a column");
    assert_eq!(column.unit, "N");
}
