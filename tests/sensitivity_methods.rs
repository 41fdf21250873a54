//! Derivatives by every method against differences of motions in double-double numbers.

mod common;

use common::model;
use num_dual::HyperDual64;
use qrm_sim::analysis::{
    Derivatives, Sensitivity, SensitivityEnd, SensitivityRequest, StateAt, reference_states, sensitivity,
};
use qrm_sim::integrate::{AUTO, DOP853, DOPRI5, GAUSS, METHODS, Method, MethodSettings, RK4, RODAS};

/// The difference quotient of order 8: places and weights.
const QUOTIENT: [(f64, f64); 8] = [
    (-4.0, 1.0 / 280.0),
    (-3.0, -4.0 / 105.0),
    (-2.0, 1.0 / 5.0),
    (-1.0, -4.0 / 5.0),
    (1.0, 4.0 / 5.0),
    (2.0, -1.0 / 5.0),
    (3.0, 4.0 / 105.0),
    (4.0, -1.0 / 280.0),
];
/// A parameter changes by this part of its value.
const CHANGE: f64 = 2e-3;

/// A scene with values of parameters, what derivatives are taken by, and the end.
struct Case {
    scene: &'static str,
    set: &'static [(&'static str, f64)],
    by: &'static [&'static str],
    end: End,
}

#[derive(Clone, Copy)]
enum End {
    Time(f64),
    /// The time at which this coordinate rises through a value, and a time near it.
    Rises(usize, f64, f64),
}

impl Case {
    fn value(&self, name: &str) -> Option<f64> {
        self.set.iter().find(|(own, _)| *own == name).map(|(_, value)| *value)
    }

    fn derivatives(&self, method: &'static Method, tolerance: f64) -> Sensitivity {
        let rises = |_: &str, _: HyperDual64, q: &[HyperDual64], _: &[HyperDual64]| match self.end {
            End::Rises(i, to, _) => q[i] - to,
            End::Time(_) => HyperDual64::from(0.0),
        };
        let end = match self.end {
            End::Time(t) => SensitivityEnd::Time(t),
            End::Rises(..) => SensitivityEnd::Condition(&rises),
        };
        let settings = MethodSettings::new(method, tolerance);
        let request = SensitivityRequest {
            by: self.by,
            settings,
            end: Some(end),
            estimate_errors: true,
            ..SensitivityRequest::default()
        };
        sensitivity(model(self.scene), &|name| self.value(name), &request).expect("smooth")
    }

    /// End time, coordinates and rates of the motion where a parameter has another value.
    fn exact(&self, name: &str, value: f64) -> Vec<f64> {
        let replace = |other: &str| if other == name { Some(value) } else { self.value(other) };
        let at = |t: f64| -> StateAt {
            let states = reference_states(model(self.scene), &replace, &[t], 1e-22).expect("a motion");
            states.into_iter().next().expect("one state")
        };
        let state = match self.end {
            End::Time(t) => at(t),
            End::Rises(i, to, near) => {
                let mut state = at(near);
                for _ in 0..4 {
                    state = at(state.t - (state.q[i] - to) / state.qd[i]);
                }
                state
            }
        };
        std::iter::once(state.t).chain(state.q).chain(state.qd).collect()
    }

    /// The derivatives of the same by each parameter.
    fn differences(&self) -> Vec<Vec<f64>> {
        let of = |name: &&str| {
            let values = model(self.scene).parameter_values(&|name| self.value(name));
            let parameters = model(self.scene).description.parameters;
            let value = values[parameters.iter().position(|own| own.name == *name).expect("a parameter")];
            let change = CHANGE * value.abs();
            let mut sum = Vec::new();
            for (place, weight) in QUOTIENT {
                let moved = self.exact(name, value + place * change);
                sum.resize(moved.len(), 0.0);
                sum.iter_mut().zip(moved).for_each(|(sum, moved)| *sum += weight / change * moved);
            }
            sum
        };
        self.by.iter().map(of).collect()
    }

    /// The largest error of a derivative and the largest of its estimates, relative to the largest derivative by the same
    /// parameter.
    fn worst(&self, found: &Sensitivity, exact: &[Vec<f64>]) -> (f64, f64) {
        let all: Vec<&Derivatives> = std::iter::once(&found.end_time).chain(&found.q).chain(&found.qd).collect();
        let mut worst = (0.0_f64, 0.0_f64);
        for (place, exact) in exact.iter().enumerate() {
            let size = exact.iter().map(|x| x.abs()).fold(0.0, f64::max);
            for (own, exact) in all.iter().zip(exact) {
                let estimate = own.errors.as_ref().expect("estimates").by[place];
                worst.0 = worst.0.max((own.by[place] - exact).abs() / size);
                worst.1 = worst.1.max(estimate / size);
            }
        }
        worst
    }
}

const CASES: [Case; 6] = [
    Case { scene: "slider-crank", set: &[], by: &["k", "c", "a", "J2"], end: End::Time(3.0) },
    Case { scene: "quick-return-loaded", set: &[], by: &["O2A", "m5", "w0"], end: End::Time(0.4) },
    Case { scene: "quick-return-loaded", set: &[("k", 1e5), ("cd", 1e5)], by: &["O2A", "cd", "k"], end: End::Time(0.05) },
    Case { scene: "slider-crank", set: &[("c", 1e3), ("k", 1e3)], by: &["a", "c", "k"], end: End::Time(0.2) },
    Case { scene: "quick-return-loaded", set: &[], by: &["O2A", "m5", "w0"], end: End::Rises(0, 2.0, 0.26) },
    Case { scene: "shaper", set: &[], by: &[], end: End::Time(0.1) },
];

#[test]
fn explore() {
    for case in &CASES {
        if case.by.is_empty() {
            println!("{:?}", model(case.scene).description.parameters.iter().map(|p| (p.name, p.formula)).collect::<Vec<_>>());
            continue;
        }
        println!("{} {:?}", case.scene, case.set);
        let exact = case.differences();
        println!("{exact:?}");
        for method in METHODS {
            for tolerance in [1e-6, 1e-8, 1e-10, 1e-12] {
                let begun = std::time::Instant::now();
                let found = case.derivatives(method, tolerance);
                let (error, estimate) = case.worst(&found, &exact);
                println!("  {:8} {tolerance:.0e} error {error:.1e} estimate {estimate:.1e} {:?}", method.name, begun.elapsed());
                if !method.is_adaptive() { break; }
            }
        }
    }
    let _ = (AUTO, DOP853, DOPRI5, GAUSS, RK4, RODAS);
}
