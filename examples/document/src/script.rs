//! The rows as the script stores them.

use nalgebra::Vector3;
use qrm_model::quick_return::QuickReturn;

use crate::motion::{Projection, Row, integrate};

/// The rows of the script.
///
/// Only angles and rates belong to the time of their row. Accelerations and multipliers are averages over the step that
/// ends there. The position and the acceleration of the ram are those of the row before; its velocity and the sliding
/// speed are differences to the row before.
pub fn script_rows(mechanism: &QuickReturn, step: f64) -> Result<Vec<Row>, String> {
    let states = integrate(mechanism, step, Projection::SCRIPT)?;
    let from_averages: Vec<Row> =
        states.iter().map(|s| Row::new(mechanism, s.t, s.q, s.qd, s.mean_qdd, s.mean_multipliers)).collect();
    let mut rows = vec![from_averages[0]];
    for pair in from_averages.windows(2) {
        let (before, now) = (&pair[0], &pair[1]);
        let h = now.t - before.t;
        let [late_x6, _, late_x6_ddot, ..] = before.outputs;
        let [x6, _, _, _, n3, n6] = now.outputs;
        let x6_dot = (x6 - late_x6) / h;
        let v_slide = (sliding_distance(mechanism, &now.q) - sliding_distance(mechanism, &before.q)) / h;
        rows.push(Row { outputs: [late_x6, x6_dot, late_x6_ddot, v_slide, n3, n6], ..*now });
    }
    Ok(rows)
}

/// The distance of the block from the pivot of the rocker, O4 to A.
fn sliding_distance(mechanism: &QuickReturn, q: &Vector3<f64>) -> f64 {
    let p = mechanism.parameters();
    (p.O2A * q[0].cos()).hypot(p.O4O2 + p.O2A * q[0].sin())
}
