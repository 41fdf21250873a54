//! The crank driven at constant speed: its torque against the power of all bodies along closed-form kinematics.

use num_dual::{Dual2_64, DualNum};

use crate::common;
use crate::common::run;

/// Positions of the bodies that move, each with what it carries, and the position of the ram, at a time.
fn bodies(t: f64) -> ([(f64, Dual2_64); 10], Dual2_64) {
    let phi2 = Dual2_64::new(t, 1.0, 0.0) * (150.0 * std::f64::consts::PI / 60.0);
    let (ax, ay) = (phi2.cos() * 0.2, phi2.sin() * 0.2 + 0.3);
    // Half a turn and no less: the block stays above the pivot.
    let phi4 = (ax / (ax * ax + ay * ay).sqrt()).acos();
    let (bx, by) = (phi4.cos() * 0.7, phi4.sin() * 0.7);
    let phi5 = -((-by + 0.9) / 0.6).asin() + std::f64::consts::PI;
    let x6 = bx + phi5.cos() * 0.6;
    let bodies = [
        (100.0, phi2),
        (0.5, ax),
        (0.5, ay),
        (6.0, phi4.cos() * 0.4),
        (6.0, phi4.sin() * 0.4),
        (10.0, phi4),
        (4.0, bx + phi5.cos() * 0.3),
        (4.0, by + phi5.sin() * 0.3),
        (6.0, phi5),
        (2.0, x6),
    ];
    (bodies, x6)
}

#[test]
fn the_torque_of_the_drive_balances_the_power() {
    let run = run(&["quick-return-driven", "--no-figures"]);
    assert_eq!(run.status(), 0, "{}", run.stderr());
    let table = run.trajectory();
    let w = 150.0 * std::f64::consts::PI / 60.0;
    let mut largest = 0.0_f64;
    for row in 0..table.rows.len() {
        let (bodies, x6) = bodies(table.number(row, "t"));
        let inertia: f64 = bodies.iter().map(|(m, x)| m * x.v1 * x.v2).sum();
        let torque = (inertia - 1000.0 * x6.v1) / w;
        let got = table.number(row, "torque");
        assert!((got - torque).abs() < 1e-7, "row {row}: {got} instead of {torque}");
        assert!((table.number(row, "x6") - x6.re).abs() < 1e-12);
        assert!((table.number(row, "x6_dot") - x6.v1).abs() < 1e-10);
        largest = largest.max(torque.abs());
    }
    assert!(largest > 5900.0, "{largest}");
    // A revolution brings back the energy: the drive does no work in all, since the force on the ram has a potential.
    let last = table.last();
    assert!((table.number(last, "energy") - table.number(0, "energy")).abs() < 1e-8);
}

#[test]
fn what_has_no_meaning_for_a_driven_mechanism_is_said() {
    for (arguments, words) in [
        (&["stability", "quick-return-driven"][..], "has no degree of freedom"),
        (&["accuracy", "quick-return-driven", "--reference", "energy"][..], "a constraint depends on time"),
    ] {
        let output = common::qrm(arguments).output().expect("it starts");
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.code() == Some(2) && said.contains(words), "{said}");
    }
}

#[test]
fn extremes_between_long_steps_are_those_between_short_ones() {
    let torque = |step: &str| {
        let run = run(&["quick-return-driven", "--method", "dop853", "--tolerance", "1e-6", "--step", step]);
        assert_eq!(run.status(), 0, "{}", run.stderr());
        let torque = &run.summary()["extremes"]["torque"];
        ["min", "max"].map(|end| torque[end].as_f64().expect("a number"))
    };
    let fine = torque("1e-3");
    // All rows but two are left out.
    for (coarse, fine) in torque("10").into_iter().zip(fine) {
        assert!((coarse / fine - 1.0).abs() < 1e-3, "{coarse} instead of {fine}");
    }
}
