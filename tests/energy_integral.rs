//! The reference that needs no integration of the equations of motion, against exact values.

use std::f64::consts::TAU;

use qrm_sim::analysis::{EnergyIntegral, NoEnergyIntegral, PANELS};

use crate::common::{Table, mechanism, near};

#[test]
fn the_period_is_exact() {
    let mechanism = mechanism("quick-return", &[]);
    let integral = EnergyIntegral::new(&*mechanism, 1.8, PANELS[0]).expect("a conservative mechanism that turns");
    near("one turn", integral.time_of(TAU).expect("within the time"), 0.877_997_139_511_224_4, 1e-15);
    near("two turns", integral.time_of(2.0 * TAU).expect("within the time"), 2.0 * 0.877_997_139_511_224_4, 2e-15);
}

#[test]
fn the_states_are_exact() {
    let mechanism = mechanism("quick-return", &[]);
    let integral = EnergyIntegral::new(&*mechanism, 1.8, PANELS[0]).expect("a conservative mechanism that turns");
    let exact = Table::reference("quick-return-states.csv");
    for row in 0..exact.rows.len() {
        let t = exact.number(row, "t");
        let (q, qd) = integral.state(t).expect("within the time");
        for (i, name) in ["phi2", "phi4", "phi5"].into_iter().enumerate() {
            near(&format!("{name} at t = {t}"), q[i], exact.number(row, name), 1e-13);
            let rate = format!("{name}_dot");
            near(&format!("{rate} at t = {t}"), qd[i], exact.number(row, &rate), 1e-12);
        }
    }
}

#[test]
fn what_has_no_such_integral_is_told_apart() {
    let turning_back = mechanism("quick-return", &[("w0", 3.0)]);
    assert_eq!(EnergyIntegral::new(&*turning_back, 10.0, PANELS[0]).err(), Some(NoEnergyIntegral::TurnsBack));
    let at_rest = mechanism("quick-return", &[("w0", 0.0)]);
    assert_eq!(EnergyIntegral::new(&*at_rest, 10.0, PANELS[0]).err(), Some(NoEnergyIntegral::TurnsBack));
    let damped = mechanism("quick-return-loaded", &[("cd", 50.0)]);
    assert_eq!(EnergyIntegral::new(&*damped, 1.0, PANELS[0]).err(), Some(NoEnergyIntegral::NotConservative));
    let heavy = mechanism("quick-return-loaded", &[("g", 9.81)]);
    assert!(EnergyIntegral::new(&*heavy, 1.0, PANELS[0]).is_ok(), "gravity has a potential");
}
