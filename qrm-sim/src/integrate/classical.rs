//! The classical Runge-Kutta method of order 4 by the plain functions, for positions at which a kernel is not valid and
//! for projections in other metrics than the mass metric.

use super::method::Method;
use super::tableau::Tableau;

/// The classical Runge-Kutta method, the default.
pub const RK4: &Method = &Method {
    name: "rk4",
    doc: "Classical Runge-Kutta, order 4, fixed step",
    order: 4,
    is_for_stiff: false,
    needs_linearization: false,
    tableau: Some(&CLASSICAL),
    formula: None,
};

/// W. Kutta, Beitrag zur näherungsweisen Integration totaler Differentialgleichungen, Z. Math. Phys. 46 (1901) 435-453.
pub(super) static CLASSICAL: Tableau = Tableau {
    stages: 4,
    order: 4,
    beta: 0.0,
    nodes: &[0.0, 0.5, 0.5, 1.0],
    rows: &[&[], &[(0, 0.5)], &[(1, 0.5)], &[(2, 1.0)]],
    weights: &[(0, 1.0 / 6.0), (1, 1.0 / 3.0), (2, 1.0 / 3.0), (3, 1.0 / 6.0)],
    errors: &[],
    dense: &[],
    error: |_, _, _| 0.0,
};
