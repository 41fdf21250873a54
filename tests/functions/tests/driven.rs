//! Closures that depend on time: against a closed form, by every method, and in the balance of energy.
#[path = "../../common/plain.rs"]
mod plain;

use std::io;

use qrm_core::Model;
use qrm_sim::integrate::{MethodSettings, method_named};
use qrm_sim::run::{Observer, Outcome, Request, Row, simulate};

use plain::Plain;

fn model(name: &str) -> &'static Model {
    qrm_functions::MODELS.iter().find(|model| model.description.name == name).expect("a generated scene")
}

/// Compares every row with the bead's closed form.
struct AgainstClosedForm {
    off: f64,
}

impl Observer for AgainstClosedForm {
    fn row(&mut self, row: &Row) -> io::Result<()> {
        let (w, r0, m) = (2.0, 0.1, 3.0);
        let (r, v) = (r0 * (w * row.t).cosh(), r0 * w * (w * row.t).sinh());
        let (sin, cos) = (w * row.t).sin_cos();
        let exact = [
            (row.q[0], r * cos),
            (row.q[1], r * sin),
            (row.qd[0], v * cos - r * w * sin),
            (row.qd[1], v * sin + r * w * cos),
            // The rod's force on the bead, across the rod: m 2 w r'.
            (row.outputs[0], 2.0 * m * w * v),
            // It brings all the energy: power is force times w r.
            (row.power, 2.0 * m * w * v * w * r),
            (row.energy, 0.5 * m * (v * v + w * w * r * r)),
        ];
        for (value, exact) in exact {
            self.off = self.off.max((value - exact).abs());
        }
        Ok(())
    }
}

fn settings(name: &str, tolerance: f64) -> MethodSettings {
    MethodSettings::new(method_named(name).expect("a method"), tolerance)
}

fn run(model: &Model, settings: MethodSettings, step: Option<f64>, observer: &mut dyn Observer) -> Outcome {
    let request = Request { settings, step, ..Request::default() };
    simulate(&*model.mechanism(&|_| None), &request, observer).expect("a start")
}

fn off(settings: MethodSettings, step: Option<f64>) -> f64 {
    let mut observer = AgainstClosedForm { off: 0.0 };
    let outcome = run(model("bead"), settings, step, &mut observer);
    assert!(outcome.status.is_done() && outcome.energy_imbalance < 1e-6, "{outcome:?}");
    observer.off
}

#[test]
fn a_bead_on_a_turning_rod() {
    let (coarse, fine) = (off(settings("rk4", 1e-9), Some(2e-2)), off(settings("rk4", 1e-9), Some(1e-2)));
    assert!(fine < 1e-6 && (10.0..24.0).contains(&(coarse / fine)), "{coarse:e} {fine:e}");
    let mut observer = AgainstClosedForm { off: 0.0 };
    let request = Request { settings: settings("rk4", 1e-9), ..Request::default() };
    simulate(&Plain(model("bead").mechanism(&|_| None)), &request, &mut observer).expect("a start");
    assert!(observer.off < 1e-10, "by the plain functions: {:e}", observer.off);
    for (name, tolerance, allowed) in [
        ("dopri5", 1e-10, 1e-8),
        ("dop853", 1e-12, 1e-9),
        ("gauss", 1e-11, 1e-9),
        ("rodas", 1e-9, 1e-7),
        ("auto", 1e-10, 1e-8),
    ] {
        let off = off(settings(name, tolerance), None);
        assert!(off < allowed, "{name} is off by {off:e}");
    }
}

/// The implicit method has the order that it claims only with the exact derivatives by time.
#[test]
fn every_method_finds_the_same_driven_motion() {
    let end = |name: &str, tolerance: f64| {
        let outcome = run(model("driven"), settings(name, tolerance), None, &mut ());
        assert!(outcome.status.is_done() && outcome.energy_imbalance < 1e-5, "{name} {outcome:?}");
        ([outcome.q, outcome.qd].concat(), outcome.counts.accepted)
    };
    let (exact, _) = end("dop853", 1e-13);
    let off = |q: &[f64]| q.iter().zip(&exact).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    for (name, tolerance, allowed) in
        [("rk4", 1e-9, 1e-9), ("dopri5", 1e-11, 1e-9), ("gauss", 1e-10, 1e-9), ("auto", 1e-11, 1e-9)]
    {
        let (state, _) = end(name, tolerance);
        assert!(off(&state) < allowed, "{name}: off by {:e}", off(&state));
    }
    let (coarse, few) = end("rodas", 1e-6);
    let (fine, many) = end("rodas", 1e-10);
    let order = (off(&coarse) / off(&fine)).ln() / (many as f64 / few as f64).ln();
    assert!(off(&fine) < 1e-8 && order > 3.5, "order {order}: {:e} and {:e}", off(&coarse), off(&fine));
}
