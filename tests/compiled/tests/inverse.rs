//! Inverse dynamics of a compiled scene against its forward dynamics.

use qrm_core::{Angles, Kernel};
use qrm_model::quick_return_loaded::{ACTUATED, Parameters, QuickReturnLoaded, inverse_dynamics};
use qrm_sim::analysis::{PrescribedMotion, PrescribedState};
use qrm_sim::position::Start;

use crate::near;

const LOADS: [(&str, f64); 4] = [("g", 9.81), ("k", 300.0), ("x6_0", -0.4), ("cd", 20.0)];

fn loaded(torque: f64) -> QuickReturnLoaded {
    let value = |name: &str| LOADS.iter().find(|(own, _)| *own == name).map(|(_, value)| *value);
    QuickReturnLoaded::new(Parameters { T2: torque, ..Parameters::with(value) })
}

/// A turn of the crank from rest to rest in a second.
fn turn(_: usize, t: f64) -> [f64; 3] {
    let t = 2.0 * (t - 0.5);
    // The integral of (1 - t^2)^2.
    let place = t - 2.0 * t.powi(3) / 3.0 + t.powi(5) / 5.0 + 8.0 / 15.0;
    let [rate, change] = [(1.0 - t * t).powi(2), -4.0 * t * (1.0 - t * t)];
    let turn = std::f64::consts::TAU * 15.0 / 16.0;
    [turn * place, 2.0 * turn * rate, 4.0 * turn * change]
}

/// The coordinates and rates after a step of the Runge-Kutta method of order 4, with a torque at each of its times.
fn step(state: [[f64; 3]; 2], h: f64, torques: [f64; 3]) -> [[f64; 3]; 2] {
    let slope = |[q, qd]: [[f64; 3]; 2], torque: f64| {
        let mechanism = loaded(torque);
        let angles = Angles::new(&q, [true; 3]);
        let position = mechanism.position(0.0, &q, &angles);
        [qd, mechanism.accelerations(&position, 0.0, &q, &qd, &angles).0]
    };
    let moved = |by: [[f64; 3]; 2], h: f64| [0, 1].map(|k| [0, 1, 2].map(|i| state[k][i] + h * by[k][i]));
    let k1 = slope(state, torques[0]);
    let k2 = slope(moved(k1, h / 2.0), torques[1]);
    let k3 = slope(moved(k2, h / 2.0), torques[1]);
    let k4 = slope(moved(k3, h), torques[2]);
    let mean = [0, 1].map(|k| [0, 1, 2].map(|i| (k1[k][i] + 2.0 * (k2[k][i] + k3[k][i]) + k4[k][i]) / 6.0));
    moved(mean, h)
}

#[test]
fn forward_dynamics_return_the_motion_of_inverse_dynamics() {
    let mechanism = crate::model("quick-return-loaded")
        .mechanism(&|name| LOADS.iter().find(|(own, _)| *own == name).map(|(_, value)| *value));
    let start = Start::new(&*mechanism);
    assert_eq!(ACTUATED, [0]);
    let mut moving = PrescribedMotion::new(&*mechanism, &start, 0.0, &turn).expect("it can be moved");
    // The torque by the generated function, which is that of the simulator.
    let torque = |state: &PrescribedState| {
        let [q, qd, qdd] = [&state.q, &state.qd, &state.qdd].map(|values| [values[0], values[1], values[2]]);
        let ([torque], multipliers) = inverse_dynamics(&loaded(0.0), state.t, &q, &qd, &qdd);
        near("torque", torque, state.forces[0], 1e-11 * state.forces[0].abs().max(1e3));
        for (got, expected) in multipliers.iter().zip(&state.multipliers) {
            near("multiplier", *got, *expected, 1e-11 * expected.abs().max(1e3));
        }
        torque
    };
    let first = moving.state().clone();
    let mut now = [&first.q, &first.qd].map(|values| [values[0], values[1], values[2]]);
    let (mut before, mut farthest) = (torque(&first), 0.0_f64);
    let count = 8000;
    for k in 0..count {
        let h = 1.0 / f64::from(count);
        let t = f64::from(k) * h;
        let half = torque(moving.advance(t + h / 2.0, &turn).expect("it moves on"));
        let there = moving.advance(f64::from(k + 1) / f64::from(count), &turn).expect("it moves on").clone();
        let after = torque(&there);
        now = step(now, h, [before, half, after]);
        before = after;
        farthest = there.q.iter().zip(now[0]).fold(farthest, |most, (q, own)| most.max((q - own).abs()));
    }
    assert!(farthest < 1e-9, "the motion is {farthest:e} rad off");
}
