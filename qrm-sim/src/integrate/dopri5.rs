//! The pair of order 5 with an estimate of order 4.

use qrm_core::dop853::Row;

use super::explicit::Explicit;
use super::method::Method;
use super::tableau::Tableau;

/// The Dormand-Prince pair of order 5.
pub const DOPRI5: &Method = &Method {
    name: "dopri5",
    doc: "Dormand-Prince pair of order 5, steps chosen by --tolerance",
    order: 5,
    is_for_stiff: false,
    needs_linearization: false,
    tableau: Some(&TABLEAU),
    formula: Some(|mechanism| Box::new(Explicit::new(&TABLEAU, mechanism.description().coordinates.len()))),
};

/// J. R. Dormand and P. J. Prince, A family of embedded Runge-Kutta formulae, J. Comp. Appl. Math. 6 (1980) 19-26.
pub(super) static TABLEAU: Tableau = Tableau {
    stages: 6,
    order: 5,
    beta: 0.04,
    nodes: &NODES,
    rows: &STAGE_ROWS,
    weights: STAGE_ROWS[6],
    errors: &[ERROR],
    dense: &[],
    error: |[sum, _], h, count| h.abs() * (sum / count).sqrt(),
};

const NODES: [f64; 7] = [0.0, 1.0 / 5.0, 3.0 / 10.0, 4.0 / 5.0, 8.0 / 9.0, 1.0, 1.0];

#[rustfmt::skip]
const STAGE_ROWS: [Row; 7] = [
    &[],
    &[(0, 1.0 / 5.0)],
    &[(0, 3.0 / 40.0), (1, 9.0 / 40.0)],
    &[(0, 44.0 / 45.0), (1, -56.0 / 15.0), (2, 32.0 / 9.0)],
    &[(0, 19372.0 / 6561.0), (1, -25360.0 / 2187.0), (2, 64448.0 / 6561.0), (3, -212.0 / 729.0)],
    &[(0, 9017.0 / 3168.0), (1, -355.0 / 33.0), (2, 46732.0 / 5247.0), (3, 49.0 / 176.0), (4, -5103.0 / 18656.0)],
    &[(0, 35.0 / 384.0), (2, 500.0 / 1113.0), (3, 125.0 / 192.0), (4, -2187.0 / 6784.0), (5, 11.0 / 84.0)],
];

/// The difference between order 5 and order 4; the last stage is the end of the step.
#[rustfmt::skip]
const ERROR: Row = &[(0, 71.0 / 57600.0), (2, -71.0 / 16695.0), (3, 71.0 / 1920.0), (4, -17253.0 / 339200.0), (5, 22.0 / 525.0), (6, -1.0 / 40.0)];
