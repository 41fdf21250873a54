//! Derivatives by every method against differences of motions in double-double numbers, across jumps, and by second
//! order.

use qrm_sim::analysis::{Derivatives, Sensitivity, SensitivityRequest, reference_states, sensitivity};
use qrm_sim::integrate::{DOP853, METHODS, MethodSettings, RK4, RODAS};
use qrm_sim::run::End;

use crate::common;
use crate::common::{event, model};

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
const CHANGE: f64 = 5e-4;

/// The derivatives of numbers by one that changes by so much.
fn quotient(change: f64, numbers: impl Fn(f64) -> Vec<f64>) -> Vec<f64> {
    let mut sum = Vec::new();
    for (place, weight) in QUOTIENT {
        let moved = numbers(place * change);
        sum.resize(moved.len(), 0.0);
        sum.iter_mut().zip(moved).for_each(|(sum, moved)| *sum += weight / change * moved);
    }
    sum
}

/// A scene with values of parameters, what derivatives are taken by, and the end.
#[derive(Clone, Copy)]
struct Case {
    scene: &'static str,
    set: &'static [(&'static str, f64)],
    by: &'static [&'static str],
    end: CaseEnd,
}

#[derive(Clone, Copy)]
enum CaseEnd {
    Time(f64),
    /// The time at which this coordinate rises through a value, and a time near it.
    Rises(usize, f64, f64),
}

const SMOOTH: Case = Case { scene: "slider-crank", set: &[], by: &["k", "c", "a", "J2"], end: CaseEnd::Time(3.0) };
const EVENT: Case =
    Case { scene: "quick-return-loaded", set: &[], by: &["O2A", "BC", "w0"], end: CaseEnd::Rises(0, 2.0, 0.26) };
/// RK4 cannot follow it with the scene's step.
const STIFF: Case =
    Case { scene: "quick-return-loaded", set: &[("cd", 1e7)], by: &["O2A", "cd", "w0"], end: CaseEnd::Time(0.01) };
const LESS_STIFF: Case =
    Case { scene: "slider-crank", set: &[("c", 1e4), ("k", 1e4)], by: &["a", "c", "k"], end: CaseEnd::Time(0.1) };

impl Case {
    /// The value of a parameter, some of them moved.
    fn value(&self, name: &str, moved: &[(&str, f64)]) -> Option<f64> {
        let of = |values: &[(&str, f64)]| values.iter().find(|(own, _)| *own == name).map(|(_, value)| *value);
        of(moved).or_else(|| of(self.set))
    }

    fn own_value(&self, name: &str) -> f64 {
        let values = model(self.scene).parameter_values(&|name| self.value(name, &[]));
        values[model(self.scene).description.parameters.iter().position(|own| own.name == name).expect("a parameter")]
    }

    /// The derivatives of the case with some parameters moved; settings beside those of the case are from `request`.
    fn derivatives(&self, request: SensitivityRequest, moved: &[(&str, f64)]) -> Sensitivity {
        let rises = match self.end {
            CaseEnd::Rises(i, to, _) => {
                let name = model(self.scene).description.coordinates[i].name;
                Some(event(model(self.scene), &format!("{name} >= {to:?}")))
            }
            CaseEnd::Time(_) => None,
        };
        let end = match self.end {
            CaseEnd::Time(t) => Some(End::Time(t)),
            CaseEnd::Rises(..) => rises.as_ref().map(End::Event),
        };
        let request = SensitivityRequest { by: self.by, end, ..request };
        sensitivity(model(self.scene), &|name| self.value(name, moved), &request).expect("smooth")
    }

    /// End time, coordinates and rates in 32 digits, rounded.
    fn exact(&self, moved: &[(&str, f64)]) -> Vec<f64> {
        let at = |t: f64| {
            let replace = |name: &str| self.value(name, moved);
            reference_states(model(self.scene), &replace, &[t], 1e-22).expect("a motion").remove(0).rounded
        };
        let state = match self.end {
            CaseEnd::Time(t) => at(t),
            CaseEnd::Rises(i, to, near) => (0..4).fold(at(near), |at_t, _| at(at_t.t - (at_t.q[i] - to) / at_t.qd[i])),
        };
        std::iter::once(state.t).chain(state.q).chain(state.qd).collect()
    }

    /// The derivatives of these by each parameter.
    fn differences(&self) -> Vec<Vec<f64>> {
        let of = |name: &&str| {
            let value = self.own_value(name);
            quotient(CHANGE * value, |change| self.exact(&[(*name, value + change)]))
        };
        self.by.iter().map(of).collect()
    }
}

/// The end of a motion: time, coordinates and rates.
fn end(found: &Sensitivity) -> Vec<&Derivatives> {
    std::iter::once(&found.end_time).chain(&found.q).chain(&found.qd).collect()
}

/// The largest error of a derivative and the largest of its estimates, relative to the largest derivative by the same
/// parameter.
fn worst(found: &Sensitivity, exact: &[Vec<f64>]) -> [f64; 2] {
    let mut worst = [0.0_f64; 2];
    for (place, exact) in exact.iter().enumerate() {
        let size = exact.iter().map(|x| x.abs()).fold(0.0, f64::max);
        for (own, exact) in end(found).into_iter().zip(exact) {
            let estimate = own.errors.as_ref().expect("estimates").by[place];
            let errors = [(own.by[place] - exact).abs() / size, estimate / size];
            worst = [0, 1].map(|i| worst[i].max(errors[i]));
        }
    }
    worst
}

#[test]
#[ignore = "full tier: compiled"]
fn every_method_is_right_to_eight_digits() {
    for case in [SMOOTH, EVENT, STIFF, LESS_STIFF] {
        let exact = case.differences();
        for method in METHODS.into_iter().filter(|method| method.is_adaptive()) {
            let settings = MethodSettings::new(method, 1e-9);
            let request = SensitivityRequest { settings, estimate_errors: true, ..SensitivityRequest::default() };
            let [error, estimate] = worst(&case.derivatives(request, &[]), &exact);
            let name = format!("{} {:?} by {}: {error:.1e}, {estimate:.1e}", case.scene, case.set, method.name);
            println!("{name}");
            assert!(error < 1e-8, "{name}");
            assert!(error < 3.0 * estimate + 1e-9, "{name}");
        }
    }
}

#[test]
fn estimated_errors_hold() {
    for (case, method, tolerance) in
        [(SMOOTH, RK4, 1e-6), (EVENT, RK4, 1e-6), (LESS_STIFF, RODAS, 1e-5), (STIFF, RODAS, 1e-5)]
    {
        let settings = MethodSettings::new(method, tolerance);
        let request = SensitivityRequest { settings, estimate_errors: true, ..SensitivityRequest::default() };
        let [error, estimate] = worst(&case.derivatives(request, &[]), &case.differences());
        let ratio = error / estimate;
        assert!((0.3..3.0).contains(&ratio), "{} by {}: {error:.1e}, {estimate:.1e}", case.scene, method.name);
    }
}

#[test]
fn products_of_hessians_are_derivatives_of_derivatives() {
    for (case, method) in [(SMOOTH, DOP853), (EVENT, DOP853), (LESS_STIFF, RODAS)] {
        let direction: Vec<(&str, f64)> =
            case.by.iter().zip([0.3, -0.2, 0.1]).map(|(name, part)| (*name, part * case.own_value(name))).collect();
        let settings = MethodSettings::new(method, 1e-11);
        let request = || SensitivityRequest { settings, ..SensitivityRequest::default() };
        let found = case.derivatives(SensitivityRequest { direction: &direction, ..request() }, &[]);
        let by = |found: &Sensitivity| end(found).into_iter().flat_map(|own| own.by.clone()).collect::<Vec<f64>>();
        let along = |change: f64| {
            let moved: Vec<(&str, f64)> =
                direction.iter().map(|(name, along)| (*name, case.own_value(name) + change * along)).collect();
            by(&case.derivatives(request(), &moved))
        };
        let differences = quotient(0.005, along);
        let products = end(&found).into_iter().flat_map(|own| own.hessian_vector.clone());
        for (i, (product, difference)) in products.zip(&differences).enumerate() {
            let parts = case.by.len();
            let size = differences.iter().skip(i % parts).step_by(parts).map(|x| x.abs()).fold(0.0, f64::max);
            assert!((product - difference).abs() < 1e-8 * size, "{} {i}: {product} {difference}", case.scene);
        }
    }
}

/// A mass whose force changes its sign at a place and at a time.
const JUMPS: &str = r#"
name = "jumps"
coordinates = [{ name = "x", unit = "m" }]
[parameters]
m  = 2
F  = { value = 3, unit = "N" }
x0 = { value = 0.5, unit = "m" }
t0 = { value = 1.1, unit = "s" }
v0 = { value = 0.7, unit = "m/s" }
D  = { value = 1.5, unit = "N" }
[points]
P = ['x', '0']
[bodies]
mass = { mass = 'm', com = "P" }
[loads]
place = { force = ['-F*sign(x - x0)', '0'], at = "P" }
time  = { force = ['D*sign(t - t0)', '0'], at = "P" }
[initial]
given = { x = 0, x_dot = 'v0' }
[run]
step = 1e-2
end_time = 1.3
stiff = true
"#;

/// Place and speed of that mass at the end.
fn after_jumps([m, f, x0, t0, v0, d]: [f64; 6]) -> Vec<f64> {
    let moved = |[x, v]: [f64; 2], a: f64, t: f64| [x + v * t + a / 2.0 * t * t, v + a * t];
    let first = (f - d) / m;
    let at_place = ((v0 * v0 + 2.0 * first * x0).sqrt() - v0) / first;
    let behind = moved(moved([0.0, v0], first, at_place), (-f - d) / m, t0 - at_place);
    moved(behind, (d - f) / m, 1.3 - t0).to_vec()
}

#[test]
#[ignore = "full tier: engine"]
fn derivatives_jump_where_forces_do() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = |name: &str| folder.path().join(name).to_str().expect("a path").to_owned();
    std::fs::write(path("jumps.toml"), JUMPS).expect("a scene");
    // The second motion begins at a jump, and does not come back. It has no derivative by the place of the jump.
    for (x0, v0, names) in
        [(0.5, 0.7, &["m", "F", "x0", "t0", "v0", "D"][..]), (0.0, 3.0, &["m", "F", "t0", "v0", "D"])]
    {
        let parameters = [("m", 2.0), ("F", 3.0), ("x0", x0), ("t0", 1.1), ("v0", v0), ("D", 1.5)];
        let derivatives = |by: &&str| {
            let moved = |change| parameters.map(|(name, value)| value + if name == *by { change } else { 0.0 });
            quotient(CHANGE, |change| after_jumps(moved(change)))
        };
        let exact: Vec<Vec<f64>> = names.iter().map(derivatives).collect();
        for method in METHODS {
            let mut command =
                common::qrm(&["sensitivity", &path("jumps.toml"), "--no-check", "--of", "end", "--out", &path("out")]);
            command.args(["--method", method.name, "--set", &format!("x0={x0}"), "--set", &format!("v0={v0}")]);
            command.args(names.iter().flat_map(|name| ["--by", name]));
            let output = command.output().expect("the command starts");
            assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
            let mut table = csv::Reader::from_path(path("out/sensitivity.csv")).expect("a table");
            for (row, record) in table.records().enumerate() {
                let record = record.expect("a row");
                for (exact, found) in exact.iter().zip(record.iter().skip(4)) {
                    let error = (found.parse::<f64>().expect("a number") - exact[row]).abs();
                    assert!(error < 1e-9, "{} by {} with x0 = {x0}: off by {error:.1e}", &record[1], method.name);
                }
            }
        }
    }
}
