//! The reference that needs no integration of the equations of motion, against exact values.

mod common;

use std::f64::consts::TAU;

use common::{Table, mechanism, model, near};
use qrm_sim::analysis::{EnergyIntegral, NoEnergyIntegral, PANELS, reference_states};

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
fn reference_states_are_exact() {
    let exact = Table::reference("quick-return-states.csv");
    let mut rows: Vec<usize> = (0..exact.rows.len()).collect();
    rows.sort_by(|&a, &b| exact.number(a, "t").total_cmp(&exact.number(b, "t")));
    let times: Vec<f64> = rows.iter().map(|&row| exact.number(row, "t")).collect();
    let states = reference_states(model("quick-return"), &|_| None, &times, 1e-22).expect("a smooth motion");
    for (state, row) in states.iter().zip(rows) {
        let t = state.t;
        for (i, name) in ["phi2", "phi4", "phi5"].into_iter().enumerate() {
            near(&format!("{name} at t = {t}"), state.q[i], exact.number(row, name), 1e-14);
            let rate = format!("{name}_dot");
            near(&format!("{rate} at t = {t}"), state.qd[i], exact.number(row, &rate), 1e-14);
        }
        near(&format!("energy at t = {t}"), state.energy, exact.number(row, "E"), 1e-11);
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
