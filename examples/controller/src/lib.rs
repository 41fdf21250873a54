//! The quick-return mechanism for a controller: one step at a time, the torque of its motor as an input.
//!
//! There is no allocator, no standard library and no way to a panic: where the compiler could not prove that,
//! `panic_is_reachable` would be missing when the program is linked.

#![no_std]

use qrm_core::{Angles, Equations, Kernel, KernelState, rk4_step};
use qrm_model::quick_return_loaded::{Parameters, Position, QuickReturnLoaded, inverse_dynamics};

/// The motion at one time; the struct of the same name in main.c.
#[repr(C)]
pub struct Motion {
    t: f64,
    q: [f64; 3],
    qd: [f64; 3],
    qdd: [f64; 3],
    multipliers: [f64; 2],
}

/// The mechanism as the scene has it, but for the torque on the crank.
fn mechanism(torque: f64) -> QuickReturnLoaded {
    QuickReturnLoaded::new(Parameters { T2: torque, ..Parameters::with(|_| None) })
}

/// One step of `h` seconds under a torque in N m; 0 if it can be relied on. Otherwise the motion stays where it is.
#[unsafe(no_mangle)]
pub extern "C" fn quick_return_step(motion: &mut Motion, torque: f64, h: f64) -> i32 {
    let mechanism = mechanism(torque);
    let from = KernelState::new(&mechanism, motion.t, motion.q, motion.qd);
    let step = rk4_step(&mechanism, motion.t, h, &from);
    if !step.is_good(1e-12) {
        return 1;
    }
    let KernelState { q, qd, qdd, multipliers, .. } = step.end;
    *motion = Motion { t: motion.t + h, q, qd, qdd, multipliers };
    0
}

/// The torque in N m at which the crank keeps its speed: the feed-forward of a speed controller.
#[unsafe(no_mangle)]
pub extern "C" fn quick_return_torque(motion: &Motion) -> f64 {
    let Motion { t, q, qd, .. } = motion;
    // With a crank as heavy as that its speed stays, and the others follow.
    let qdd = KernelState::new(&heavy(), *t, *q, *qd).qdd;
    let ([torque], _) = inverse_dynamics(&mechanism(0.0), *t, q, qd, &qdd);
    torque
}

/// The crank at an angle in rad with a speed in rad/s, the loops closed; 0 if they can be.
#[unsafe(no_mangle)]
pub extern "C" fn quick_return_start(motion: &mut Motion, angle: f64, speed: f64) -> i32 {
    // Corrections are least in the metric of the masses: a crank as heavy as that stays where it is.
    let heavy = heavy();
    let (mut q, mut qd) = (heavy.start().q, [speed, 0.0, 0.0]);
    q[0] = angle;
    for _ in 0..50 {
        let position = at(&heavy, &q);
        q = sum(&q, &heavy.correction(&position, &heavy.residuals(&position)));
    }
    let position = at(&heavy, &q);
    qd = sum(&qd, &heavy.correction(&position, &heavy.velocity_residual(&position, &qd)));
    let KernelState { q, qd, qdd, multipliers, .. } = KernelState::new(&mechanism(0.0), 0.0, q, qd);
    *motion = Motion { t: 0.0, q, qd, qdd, multipliers };
    let is_closed = heavy.residuals(&position).iter().all(|residual| residual.abs() < 1e-12);
    let is_finite = qd.iter().chain(&qdd).all(|value| value.is_finite());
    if is_closed && is_finite { 0 } else { 1 }
}

fn heavy() -> QuickReturnLoaded {
    QuickReturnLoaded::new(Parameters { J2: 1e15, ..Parameters::with(|_| None) })
}

fn at(mechanism: &QuickReturnLoaded, q: &[f64; 3]) -> Position<f64> {
    mechanism.position(0.0, q, &Angles::new(q, [true; 3]))
}

fn sum(x: &[f64; 3], change: &[f64; 3]) -> [f64; 3] {
    [x[0] + change[0], x[1] + change[1], x[2] + change[2]]
}

#[panic_handler]
fn panic(_: &core::panic::PanicInfo) -> ! {
    unsafe extern "C" {
        fn panic_is_reachable() -> !;
    }
    // SAFETY: it takes nothing and never returns; it is defined nowhere, so that a program in which this is reached
    // cannot be linked.
    unsafe { panic_is_reachable() }
}
