//! Loads against closed forms.
use qrm_functions::MODELS;
use qrm_sim::integrate::{MethodSettings, method_named};
use qrm_sim::run::{Request, simulate};

#[test]
fn friction_a_stop_and_a_table() {
    // v0 sinh(v/v0) decays like exp(-F t/(m v0)).
    let speed = 0.5 * (3.0_f64.sinh() * (-8.0_f64).exp()).asinh();
    let model = MODELS.iter().find(|model| model.description.name == "loads").expect("a generated scene");
    let mechanism = model.mechanism(&|_| None);
    for (name, tolerance, allowed) in [
        ("rk4", 1e-9, 1e-6),
        ("dopri5", 1e-9, 1e-6),
        ("dop853", 1e-10, 1e-7),
        ("gauss", 1e-10, 1e-7),
        ("rodas", 1e-8, 1e-6),
        ("auto", 1e-10, 1e-7),
    ] {
        let settings = MethodSettings::new(method_named(name).expect("a method"), tolerance);
        let request = Request { settings, ..Request::default() };
        let outcome = simulate(&*mechanism, &request, &mut ()).expect("a start");
        let exact = [
            (outcome.qd[0], speed),
            (outcome.q[1], 0.5),
            (outcome.qd[1], 1.0),
            (outcome.q[2], 4.0),
            (outcome.qd[2], 4.0),
        ];
        for (value, exact) in exact {
            assert!((value - exact).abs() < allowed, "{name}: {value} instead of {exact}");
        }
        assert!(outcome.energy_imbalance < 1e-5, "{name}: {:e}", outcome.energy_imbalance);
    }
}
