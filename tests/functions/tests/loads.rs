//! Loads against closed forms.
#![cfg(feature = "generate")]

use qrm_functions::loads::Loads;
use qrm_sim::motion::{Method, Scheme};
use qrm_sim::simulate::{Request, simulate};

#[test]
fn friction_a_stop_and_a_table() {
    // v0 sinh(v/v0) decays like exp(-F t/(m v0)).
    let speed = 0.5 * (3.0_f64.sinh() * (-8.0_f64).exp()).asinh();
    for (scheme, allowed) in [
        (Scheme::Rk4, 1e-6),
        (Scheme::Dopri5 { tolerance: 1e-9 }, 1e-6),
        (Scheme::Dop853 { tolerance: 1e-10 }, 1e-7),
        (Scheme::Rodas { tolerance: 1e-8 }, 1e-6),
        (Scheme::Auto { tolerance: 1e-10 }, 1e-7),
    ] {
        let method = Method { scheme, ..Method::default() };
        let request = Request { method, step: None, end: None, estimate_error: false };
        let outcome = simulate(&Loads::<f64>::default(), &request, &mut ()).expect("a start");
        let exact = [
            (outcome.qd[0], speed),
            (outcome.q[1], 0.5),
            (outcome.qd[1], 1.0),
            (outcome.q[2], 4.0),
            (outcome.qd[2], 4.0),
        ];
        for (value, exact) in exact {
            assert!((value - exact).abs() < allowed, "{scheme:?}: {value} instead of {exact}");
        }
        assert!(outcome.energy_imbalance < 1e-5, "{scheme:?}: {:e}", outcome.energy_imbalance);
    }
}
