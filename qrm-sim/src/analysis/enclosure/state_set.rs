//! A set of states that satisfy the constraints.

use nalgebra::DMatrix;
use qrm_core::Interval;

use super::linear::IntervalLinearSolver;
use super::manifold::Manifold;
use super::matrix::{IntervalMatrix, sum};

/// States `center + basis r` on the constraints, at a time, for all `r` in a box.
///
/// The first columns of the basis are normals of the constraints, the others span their tangents. The basis is nearly
/// orthogonal and turns with the motion, which avoids enclosing rotated boxes in boxes (R. J. Lohner, Enclosing the
/// solutions of ordinary initial and boundary value problems, 1987). The width of a set normal to the constraints
/// follows from the constraints, and does not grow from step to step.
#[derive(Clone, Debug)]
pub(super) struct StateSet {
    pub(super) t: f64,
    pub(super) center: Vec<Interval>,
    pub(super) basis: IntervalMatrix,
    /// The box of `r`.
    pub(super) parts: Vec<Interval>,
    /// A box that contains all states and the center.
    pub(super) hull: Vec<Interval>,
}

impl StateSet {
    /// The states of a box that satisfy the constraints; `None` if the constraints do not determine the normal part.
    pub(super) fn from_box(manifold: &mut Manifold, t: f64, states: &[Interval]) -> Option<Self> {
        let zero = vec![Interval::ZERO; states.len()];
        Self::from_affine(manifold, t, states, &IntervalMatrix::identity(states.len()), &zero)
    }

    /// The states `moved + derivatives r` that satisfy the constraints; `None` if the constraints do not determine the
    /// normal part.
    pub(super) fn from_affine(
        manifold: &mut Manifold,
        t: f64,
        moved: &[Interval],
        derivatives: &IntervalMatrix,
        r: &[Interval],
    ) -> Option<Self> {
        let (time, size) = (Interval::point(t), moved.len());
        let center: Vec<Interval> = moved.iter().map(|x| Interval::point(x.mid())).collect();
        let shift: Vec<Interval> = moved.iter().zip(&center).map(|(x, center)| *x - *center).collect();
        let at_center = manifold.linearized(time, &center);
        let basis = basis(&at_center.jacobian, derivatives, r);
        let inverse = IntervalLinearSolver::new(&basis)?;
        let mut parts = sum(&inverse.solve(&shift), &inverse.solve_columns(derivatives).applied(r));
        // The mean value form of the constraints determines the normal part from the tangential part.
        let count = at_center.residuals.len();
        let (normals, tangents) = (basis.part(0..count), basis.part(count..size));
        let jacobian = manifold.linearized(time, &hull(&center, &basis, &parts)).jacobian;
        let by_tangents = jacobian.times(&tangents).applied(&parts[count..]);
        let across =
            IntervalLinearSolver::new(&jacobian.times(&normals))?.solve(&sum(&at_center.residuals, &by_tangents));
        for (part, across) in parts.iter_mut().zip(across) {
            *part = part.intersection(-across)?;
        }
        let hull = hull(&center, &basis, &parts);
        Some(Self { t, center, basis, parts, hull })
    }
}

/// A box that contains all states and the center.
fn hull(center: &[Interval], basis: &IntervalMatrix, parts: &[Interval]) -> Vec<Interval> {
    let states = sum(center, &basis.applied(parts));
    states.into_iter().zip(center).map(|(x, center)| x.hull(*center)).collect()
}

/// A nearly orthogonal basis: the normals of the constraints, then the directions of the derivatives, longest sides
/// first.
fn basis(constraint_jacobian: &IntervalMatrix, derivatives: &IntervalMatrix, r: &[Interval]) -> IntervalMatrix {
    let (normals, directions) = (constraint_jacobian.mid().transpose(), derivatives.mid());
    let length = |j: usize| directions.column(j).norm() * r[j].width();
    let mut order: Vec<usize> = (0..r.len()).collect();
    order.sort_by(|a, b| length(*b).total_cmp(&length(*a)));
    let count = normals.ncols();
    let columns = DMatrix::from_fn(directions.nrows(), count + r.len(), |i, j| {
        if j < count { normals[(i, j)] } else { directions[(i, order[j - count])] }
    });
    IntervalMatrix::from_matrix(&columns.qr().q())
}
