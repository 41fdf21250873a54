//! Closures that depend on time: against a closed form, by every method, and in the balance of energy.
#![cfg(feature = "generate")]

use std::io;

use qrm_core::{Mechanism, Plain};
use qrm_functions::bead::Bead;
use qrm_functions::driven::Driven;
use qrm_sim::motion::{Method, Scheme};
use qrm_sim::observer::{Observer, Row};
use qrm_sim::outcome::Outcome;
use qrm_sim::simulate::{Request, simulate};

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

    fn goes_on(&mut self, _t: f64, _end_time: f64) -> io::Result<bool> {
        Ok(true)
    }

    fn finish(&mut self) -> io::Result<()> {
        Ok(())
    }
}

fn run<X: Mechanism<N, M>, const N: usize, const M: usize>(
    mechanism: &X,
    scheme: Scheme,
    step: Option<f64>,
    observer: &mut dyn Observer,
) -> Outcome {
    let method = Method { scheme, ..Method::default() };
    let request = Request { method, step, end: None, estimate_error: false };
    simulate(mechanism, &request, observer).expect("a start")
}

fn off(scheme: Scheme, step: Option<f64>) -> f64 {
    let mut observer = AgainstClosedForm { off: 0.0 };
    let outcome = run(&Bead::<f64>::default(), scheme, step, &mut observer);
    // The document's rows are half a step late.
    let is_balanced = scheme == Scheme::Document || outcome.energy_imbalance < 1e-6;
    assert!(outcome.status.is_done() && is_balanced, "{outcome:?}");
    observer.off
}

#[test]
fn a_bead_on_a_turning_rod() {
    let (coarse, fine) = (off(Scheme::Rk4, Some(2e-2)), off(Scheme::Rk4, Some(1e-2)));
    assert!(fine < 1e-6 && (10.0..24.0).contains(&(coarse / fine)), "{coarse:e} {fine:e}");
    let mut observer = AgainstClosedForm { off: 0.0 };
    run(&Plain(Bead::<f64>::default()), Scheme::Rk4, None, &mut observer);
    assert!(observer.off < 1e-10, "by the plain functions: {:e}", observer.off);
    for (scheme, allowed) in [
        (Scheme::Dopri5 { tolerance: 1e-10 }, 1e-8),
        (Scheme::Dop853 { tolerance: 1e-12 }, 1e-9),
        (Scheme::Rodas { tolerance: 1e-9 }, 1e-7),
        (Scheme::Auto { tolerance: 1e-10 }, 1e-8),
        (Scheme::Document, 1.0),
    ] {
        let off = off(scheme, None);
        assert!(off < allowed, "{scheme:?} is off by {off:e}");
    }
}

/// The implicit method has the order that it claims only with the exact derivatives by time.
#[test]
fn every_method_finds_the_same_driven_motion() {
    let end = |scheme| {
        let outcome = run(&Driven::<f64>::default(), scheme, None, &mut ());
        assert!(outcome.status.is_done() && outcome.energy_imbalance < 1e-5, "{scheme:?} {outcome:?}");
        ([outcome.q, outcome.qd].concat(), outcome.counts.accepted)
    };
    let (exact, _) = end(Scheme::Dop853 { tolerance: 1e-13 });
    let off = |q: &[f64]| q.iter().zip(&exact).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    for (scheme, allowed) in
        [(Scheme::Rk4, 1e-9), (Scheme::Dopri5 { tolerance: 1e-11 }, 1e-9), (Scheme::Auto { tolerance: 1e-11 }, 1e-9)]
    {
        let (state, _) = end(scheme);
        assert!(off(&state) < allowed, "{scheme:?}: off by {:e}", off(&state));
    }
    let (coarse, few) = end(Scheme::Rodas { tolerance: 1e-6 });
    let (fine, many) = end(Scheme::Rodas { tolerance: 1e-10 });
    let order = (off(&coarse) / off(&fine)).ln() / (many as f64 / few as f64).ln();
    assert!(off(&fine) < 1e-8 && order > 3.5, "order {order}: {:e} and {:e}", off(&coarse), off(&fine));
}
