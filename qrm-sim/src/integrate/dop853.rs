//! The pair of order 8 with estimates of order 5 and 3, and its dense output of order 7.

use qrm_core::dop853::{DENSE, ERROR_3, ERROR_5, NODES, ROWS};

use super::explicit::Explicit;
use super::method::Method;
use super::tableau::Tableau;

/// The Dormand-Prince pair of order 8.
pub const DOP853: &Method = &Method {
    name: "dop853",
    doc: "Dormand-Prince pair of order 8, steps chosen by --tolerance",
    order: 8,
    is_for_stiff: false,
    needs_linearization: false,
    formula: Some(|n| Box::new(Explicit::new(&TABLEAU, n))),
};

/// Dormand and Prince's method of order 8, with the error estimates and the dense output of E. Hairer, S. P. Nørsett
/// and G. Wanner, Solving Ordinary Differential Equations I, 2nd ed., Springer 1993, II.5 and II.6 (their code DOP853).
pub(super) static TABLEAU: Tableau = Tableau {
    stages: 12,
    order: 8,
    beta: 0.0,
    nodes: &NODES,
    rows: &ROWS,
    weights: ROWS[12],
    errors: &[ERROR_5, ERROR_3],
    dense: &DENSE,
    error: |[fifth, third], h, count| {
        let denominator = fifth + 0.01 * third;
        if denominator > 0.0 { h.abs() * fifth / (denominator * count).sqrt() } else { 0.0 }
    },
};
