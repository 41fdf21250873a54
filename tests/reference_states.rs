//! References in double-double numbers against quadrature, values of 128 bits and closed forms, to more digits than a
//! double has.

use std::path::Path;

use qrm_core::{DoubleDouble, Model, Scalar, TapeEvaluator};
use qrm_sim::analysis::{ReferenceState, StateAt, reference_states};

use crate::common::{Table, derived, model, near};

type Number = DoubleDouble;

fn number(value: f64) -> Number {
    value.into()
}

/// A decimal number.
fn decimal(text: &str) -> Number {
    let (sign, text) = text.strip_prefix('-').map_or((1.0, text), |rest| (-1.0, rest));
    let (whole, fraction) = text.split_once('.').unwrap_or((text, ""));
    let digits = whole.chars().chain(fraction.chars()).map(|digit| f64::from(digit.to_digit(10).expect("a digit")));
    let all = digits.fold(number(0.0), |sum, digit| number(10.0) * sum + number(digit));
    number(sign) * all / number(10.0).powi(i32::try_from(fraction.len()).expect("few digits"))
}

#[track_caller]
fn same(what: &str, value: Number, exact: Number, allowed: f64) {
    let error = (value - exact).to_f64().abs();
    assert!(error <= allowed, "{what}: {value:?} instead of {exact:?}, off by {error:e}");
}

/// States at increasing times.
fn states(model: &Model, times: &[f64]) -> Vec<ReferenceState> {
    reference_states(model, &|_| None, times, 1e-24).expect("a motion")
}

#[test]
fn states_agree_with_exact_ones_of_30_digits() {
    let exact = Table::reference("quick-return-states.csv");
    let mut rows: Vec<usize> = (0..exact.rows.len()).collect();
    rows.sort_by(|&a, &b| exact.number(a, "t").total_cmp(&exact.number(b, "t")));
    let times: Vec<f64> = rows.iter().map(|&row| exact.number(row, "t")).collect();
    for (ReferenceState { rounded: state, .. }, row) in states(model("quick-return"), &times).iter().zip(rows) {
        let t = state.t;
        for (i, name) in ["phi2", "phi4", "phi5"].into_iter().enumerate() {
            near(&format!("{name} at t = {t}"), state.q[i], exact.number(row, name), 1e-14);
            let rate = format!("{name}_dot");
            near(&format!("{rate} at t = {t}"), state.qd[i], exact.number(row, &rate), 1e-14);
        }
        near(&format!("energy at t = {t}"), state.energy, exact.number(row, "E"), 1e-11);
    }
}

/// The quick-return with its crank at an angle.
struct QuickReturn {
    equations: TapeEvaluator<'static, Vec<Number>>,
    energy: Number,
}

impl QuickReturn {
    fn new(start: &ReferenceState) -> Self {
        let model = model("quick-return");
        let mut equations = TapeEvaluator::with_parameters(model.tape(), model.mechanism(&|_| None).parameters());
        let (q, qd) = start.digits.split_at(3);
        let [kinetic, potential] = equations.energy(q, qd);
        Self { equations, energy: kinetic + potential }
    }

    /// Coordinates near some with the crank at an angle, and their derivatives by it.
    fn at(&mut self, angle: Number, mut q: [Number; 3]) -> [[Number; 3]; 2] {
        q[0] = angle;
        let mut results = [number(0.0); 10];
        let mut rates = [number(1.0); 3];
        for _ in 0..7 {
            self.equations.loop_constraints(number(0.0), &q, &mut results);
            let [residuals, jacobian, _] = self.equations.tape().split_loop_constraints(&results);
            let solve = |right: [Number; 2]| {
                let determinant = jacobian[1] * jacobian[5] - jacobian[2] * jacobian[4];
                let first = right[0] * jacobian[5] - jacobian[2] * right[1];
                [first / determinant, (jacobian[1] * right[1] - right[0] * jacobian[4]) / determinant]
            };
            let change = solve([residuals[0], residuals[1]]);
            let slope = solve([jacobian[0], jacobian[3]]);
            for i in 0..2 {
                q[1 + i] = q[1 + i] - change[i];
                rates[1 + i] = -slope[i];
            }
        }
        [q, rates]
    }

    /// The time that the crank takes through a unit of its angle.
    fn slowness(&mut self, [q, rates]: &[[Number; 3]; 2]) -> Number {
        let [kinetic, potential] = self.equations.energy(q, rates);
        (kinetic / (self.energy - potential)).sqrt()
    }
}

/// Nodes and weights of Gauss and Legendre's rule on -1 to 1.
fn gauss_legendre(count: u32) -> Vec<[Number; 2]> {
    let node = |k: u32| {
        let mut x = number(((f64::from(k) + 0.75) / (f64::from(count) + 0.5) * std::f64::consts::PI).cos());
        let mut slope = number(0.0);
        for _ in 0..6 {
            let (mut last, mut value) = (number(1.0), x);
            for i in 2..=count {
                let i = f64::from(i);
                (last, value) = (value, (number(2.0 * i - 1.0) * x * value - number(i - 1.0) * last) / number(i));
            }
            slope = number(count.into()) * (x * value - last) / (x * x - number(1.0));
            x = x - value / slope;
        }
        [x, number(2.0) / ((number(1.0) - x * x) * slope * slope)]
    };
    (0..count).map(node).collect()
}

#[test]
fn times_agree_with_the_energy_integral_to_18_digits() {
    let times: Vec<f64> = (0..=9).map(|k| 0.1 * f64::from(k)).collect();
    let states = states(model("quick-return"), &times);
    let mut mechanism = QuickReturn::new(&states[0]);
    let rule = gauss_legendre(40);
    let mut t = number(0.0);
    for pair in states.windows(2) {
        let [from, to] = pair else { unreachable!() };
        let mut near = [from.digits[0], from.digits[1], from.digits[2]];
        const PANELS: u32 = 4;
        let half = (to.digits[0] - from.digits[0]) / number(f64::from(2 * PANELS));
        for panel in 0..PANELS {
            let middle = from.digits[0] + number(f64::from(2 * panel + 1)) * half;
            for [node, weight] in rule.iter().rev() {
                let at = mechanism.at(middle + *node * half, near);
                near = at[0];
                t = t + half * *weight * mechanism.slowness(&at);
            }
        }
        let [q, rates] = mechanism.at(to.digits[0], near);
        same("time", to.rounded.t.into(), t, 1e-18);
        let rate = mechanism.slowness(&[q, rates]).recip();
        for i in 0..3 {
            same("angle", to.digits[i], q[i], 1e-18);
            same("rate", to.digits[3 + i], rates[i] * rate, 1e-18);
        }
    }
}

/// Andrews' squeezer at 0.03 s, by extrapolation of order 20 with 128 bits.
const END: [&str; 14] = [
    "15.8107711951537070971",
    "-15.7563710584118394697",
    "0.0408222401196458048583",
    "-0.534730116342079593770",
    "0.524409965879954069372",
    "0.534730116342079593770",
    "1.04808074104193787307",
    "1139.92030225910606420",
    "-1424.37929517754007320",
    "11.0329119106185937453",
    "19.2933741050320408316",
    "0.573569914829502453818",
    "-19.2933741050320408316",
    "0.323179149249130874991",
];

#[test]
fn andrews_squeezer_agrees_with_values_of_128_bits() {
    let ReferenceState { digits, rounded } = states(model("andrews"), &[0.03]).remove(0);
    // The double nearest to 0.03 is another time. So are those of the parameters, which moves the end by 4e-16 of it.
    let later = decimal("0.03") - number(rounded.t);
    let end = END.map(decimal);
    let size = |of: &[Number]| of.iter().map(|value| value.to_f64().abs()).fold(0.0, f64::max);
    let sizes = [size(&end[..7]), size(&end[7..])];
    let slopes = rounded.qd.iter().chain(&rounded.qdd);
    for (i, ((value, slope), exact)) in digits.iter().zip(slopes).zip(end).enumerate() {
        same("end", *value + number(*slope) * later, exact, 1e-15 * sizes[i / 7]);
    }
}

/// `x'' = -sign(x)` between 0.375 and -0.375: parabolas that meet at zero.
#[test]
#[ignore = "full tier: engine"]
fn a_motion_across_jumps_has_27_digits() {
    let scene = r#"name = "parabolas"
coordinates = [{ name = "x", unit = "m" }]
[parameters]
m = 1
[points]
P = ['x', '0']
[bodies]
b = { mass = 'm', com = "P" }
[loads]
F = { force = ['-sign(x)', '0'], on = "b" }
[initial]
given = { x = 0.375, x_dot = 0 }
[run]
step = 0.01
end_time = 10
"#;
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("parabolas.toml");
    std::fs::write(&path, scene).expect("written");
    let quarter = number(0.75).sqrt();
    // Times behind the start, two jumps and three jumps.
    for (state, jumps) in states(&derived(&path), &[0.5, 3.0, 5.0]).iter().zip([0.0, 2.0, 3.0]) {
        let since = number(state.rounded.t) - number(2.0 * jumps) * quarter;
        let sign = number(if jumps == 3.0 { -1.0 } else { 1.0 });
        let [x, v] = [number(0.375) - number(0.5) * since * since, -since];
        same("x", state.digits[0], sign * x, 1e-27);
        same("v", state.digits[1], sign * v, 1e-27);
    }
}

/// Three rods of which two repeat the first: forces of least norm are as their distances.
#[test]
#[ignore = "full tier: engine"]
fn constraints_that_repeat_others_have_forces_of_least_norm() {
    for state in states(&derived(Path::new("tests/functions/redundant.toml")), &[0.1, 0.7]) {
        let ReferenceState { digits, rounded: StateAt { q, qdd, multipliers, .. } } = state;
        let exact = -(3.0 / 2.0 + 10.0) * 9.81 * q[0].cos() / ((3.0 / 3.0 + 10.0) * 0.5);
        near("acceleration", qdd[0], exact, 1e-14 * exact.abs());
        same("angle of the beam", digits[1], number(0.0), 1e-26);
        for (multiplier, distance) in multipliers[1..].iter().zip([2.0, 3.0]) {
            near("multiplier", *multiplier, distance * multipliers[0], 1e-14 * multiplier.abs());
        }
    }
}
