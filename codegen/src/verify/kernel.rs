//! The kernel of a generated module against the equations of motion as one system, solved by elimination with pivots.

use std::collections::HashMap;

use super::Generated;
use super::expected::Expected;
use super::interpret::Value;
use super::sample::Sample;
use qrm_scene::scene::Scene;

/// Where the kernel magnifies rounding errors by more, a step does not rely on it.
const MAX_GROWTH: f64 = 1e3;
/// Largest difference relative to the largest number of the function, for each unit of growth.
const TOLERANCE: f64 = 1e-9;

/// Compares every function of the kernel at a state, as far as it suits the position and the equations are not nearly
/// singular there.
pub(super) fn agrees(
    scene: &Scene,
    module: &Generated,
    (sample, expected): (&Sample, &Expected),
) -> Result<(), String> {
    let model = module.model(scene, &sample.parameters)?;
    let list = |values: Vec<f64>| Value::list(&values);
    let angles = Value::Fields(HashMap::from([
        ("sin".to_owned(), list(sample.q.iter().map(|q| q.sin()).collect())),
        ("cos".to_owned(), list(sample.q.iter().map(|q| q.cos()).collect())),
    ]));
    let (t, q, qd) = (Value::Number(sample.t), Value::list(&sample.q), Value::list(&sample.qd));
    let is_timed = module.functions.get("position").is_some_and(|position| position.sig.inputs.len() == 4);
    let at = if is_timed { vec![t.clone(), q.clone()] } else { vec![q.clone()] };
    let position = module.value("position", &[vec![model.clone()], at, vec![angles.clone()]].concat())?;
    let growth_factor = module.value("growth_factor", std::slice::from_ref(&position))?.numbers();
    let call = |name: &str, more: &[Value]| {
        let arguments = [&[model.clone(), position.clone()], more].concat();
        module.value(name, &arguments).map(|value| value.numbers())
    };
    let known = |name: &str| expected.iter().find(|(n, _)| *n == name).map_or(&[][..], |(_, numbers)| numbers);
    let system = System::new(known("mass_matrix"), known("dynamics.constraint_jacobian"), sample.q.len());
    let constraints = known("loop_constraints.residuals");

    let rates = system.velocity_residual(&sample.qd).into_iter().zip(known("loop_constraints.constraint_rate"));
    let rates: Vec<f64> = rates.map(|(along, own)| along + own).collect();
    compare("residuals", &call("residuals", &[])?, constraints, 1.0)?;
    compare("velocity_residual", &call("velocity_residual", std::slice::from_ref(&qd))?, &rates, 1.0)?;
    if !growth_factor.iter().all(|growth_factor| growth_factor.abs() <= MAX_GROWTH) {
        return Ok(());
    }
    let bias: Vec<f64> = known("dynamics.constraint_bias").iter().map(|bias| -bias).collect();
    let opened: Vec<f64> = (0..constraints.len()).map(|k| 0.1 * (k as f64 + 1.0)).collect();
    let closing: Vec<f64> = opened.iter().map(|r| -r).collect();
    let (Some((accelerations, growth)), Some((correction, _))) =
        (system.solve(known("dynamics.generalized_forces"), &bias), system.solve(&vec![0.0; sample.q.len()], &closing))
    else {
        return Ok(());
    };
    compare("accelerations", &call("accelerations", &[t, q, qd, angles])?, &accelerations, growth)?;
    compare("correction", &call("correction", &[list(opened)])?, &correction[..sample.q.len()], growth)
}

fn compare(name: &str, got: &[f64], expected: &[f64], growth: f64) -> Result<(), String> {
    let largest = expected.iter().fold(1e-3, |most: f64, number| most.max(number.abs()));
    let allowed = |_| TOLERANCE * largest * growth;
    super::compare(name, got, expected, allowed).map_err(|(_, what)| format!("generated `{name}` is wrong: {what}"))
}

/// `| Mbar C_q' | C_q 0 |`
struct System {
    rows: Vec<Vec<f64>>,
    coordinates: usize,
}

impl System {
    fn new(mass: &[f64], jacobian: &[f64], n: usize) -> Self {
        let m = jacobian.len() / n.max(1);
        let mut rows = vec![vec![0.0; n + m]; n + m];
        for i in 0..n {
            rows[i][..n].copy_from_slice(&mass[i * n..(i + 1) * n]);
            for k in 0..m {
                rows[i][n + k] = jacobian[k * n + i];
                rows[n + k][i] = jacobian[k * n + i];
            }
        }
        Self { rows, coordinates: n }
    }

    fn velocity_residual(&self, qd: &[f64]) -> Vec<f64> {
        let row = |row: &Vec<f64>| row.iter().zip(qd).map(|(entry, v)| entry * v).sum();
        self.rows[self.coordinates..].iter().map(row).collect()
    }

    /// The solution, and how much pivots shrank; `None` if the equations are singular.
    fn solve(&self, forces: &[f64], closures: &[f64]) -> Option<(Vec<f64>, f64)> {
        let mut a = self.rows.clone();
        for (row, right) in a.iter_mut().zip(forces.iter().chain(closures)) {
            // Units differ from row to row.
            let size = row.iter().fold(0.0, |most: f64, entry| most.max(entry.abs()));
            row.push(*right);
            row.iter_mut().for_each(|entry| *entry /= size);
        }
        let (mut smallest, count) = (1.0_f64, a.len());
        for k in 0..count {
            let best = (k..count).max_by(|&x, &y| a[x][k].abs().total_cmp(&a[y][k].abs()))?;
            a.swap(k, best);
            smallest = smallest.min(a[k][k].abs());
            for i in 0..count {
                if i == k || a[i][k] == 0.0 {
                    continue;
                }
                let ratio = a[i][k] / a[k][k];
                for j in k..=count {
                    let part = ratio * a[k][j];
                    a[i][j] -= part;
                }
            }
        }
        let x: Vec<f64> = (0..count).map(|k| a[k][count] / a[k][k]).collect();
        (smallest > 1e-9 && x.iter().all(|x| x.is_finite())).then(|| (x, 1.0 / smallest))
    }
}
