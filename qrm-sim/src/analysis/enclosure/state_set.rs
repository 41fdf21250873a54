//! A set of states that meet the constraints.

use nalgebra::DMatrix;
use qrm_core::Interval;

use super::linear::Linear;
use super::manifold::Manifold;
use super::matrix::{IntervalMatrix, negative, sum};

/// States `origin + frame w` on the constraints, at a time, where `w` has two components for each degree of freedom.
///
/// The frame is nearly orthogonal and turns with the motion, so that boxes of `w` need not contain boxes that are turned
/// against them (R. J. Lohner, Enclosing the solutions of ordinary initial and boundary value problems, 1987). What a
/// set is wide across the constraints follows from them, and does not grow from step to step.
#[derive(Clone, Debug)]
pub(super) struct StateSet {
    pub(super) t: f64,
    /// A box around what belongs to `w = 0`.
    pub(super) origin: Vec<Interval>,
    /// The derivatives of states by `w`.
    pub(super) frame: IntervalMatrix,
    /// The box of `w`.
    pub(super) along: Vec<Interval>,
    /// A box around all states, and around the origin.
    pub(super) hull: Vec<Interval>,
}

impl StateSet {
    /// The states of a box that meet the constraints; `None` if these do not determine their part of a state.
    pub(super) fn of_box(manifold: &mut Manifold, t: f64, states: &[Interval]) -> Option<Self> {
        let zero = vec![Interval::ZERO; states.len()];
        Self::moved(manifold, t, states, &IntervalMatrix::identity(states.len()), &zero)
    }

    /// The states `moved + derivatives w` that meet the constraints; `None` if these do not determine their part of a
    /// state.
    pub(super) fn moved(
        manifold: &mut Manifold,
        t: f64,
        moved: &[Interval],
        derivatives: &IntervalMatrix,
        w: &[Interval],
    ) -> Option<Self> {
        let time = Interval::point(t);
        let center: Vec<Interval> = moved.iter().map(|x| Interval::point(x.mid())).collect();
        let shift: Vec<Interval> = moved.iter().zip(&center).map(|(x, center)| *x - *center).collect();
        let at_center = manifold.linearized(time, &center);
        let (size, count) = (moved.len(), at_center.residuals.len());
        // The set in coordinates across the constraints, then along them.
        let basis = basis(&at_center.jacobian, derivatives, w);
        let inverse = Linear::new(&basis)?;
        let parts = sum(&inverse.solve(&shift), &inverse.solve_columns(derivatives).applied(w));
        let (normals, tangents, along) = (basis.part(0..count), basis.part(count..size), parts[count..].to_vec());
        let hull: Vec<Interval> = sum(&center, &basis.applied(&parts));
        let inside: Vec<Interval> = hull.iter().zip(&center).map(|(hull, center)| hull.hull(*center)).collect();
        // The mean value form of the constraints determines what is across from what is along.
        let jacobian = manifold.linearized(time, &inside).jacobian;
        let across = Linear::new(&jacobian.times(&normals))?;
        let origin = sum(&center, &normals.applied(&negative(&across.solve(&at_center.residuals))));
        let bent = normals.times(&across.solve_columns(&jacobian.times(&tangents)));
        let frame = IntervalMatrix::from_fn(size, size - count, |i, j| tangents.at(i, j) - bent.at(i, j));
        let on_constraints = sum(&origin, &frame.applied(&along));
        let both = |((a, b), origin): ((&Interval, &Interval), &Interval)| Some(a.intersection(*b)?.hull(*origin));
        let hull = on_constraints.iter().zip(&hull).zip(&origin).map(both).collect::<Option<_>>()?;
        Some(Self { t, origin, frame, along, hull })
    }
}

/// A nearly orthogonal basis: the normals of constraints, then the directions of derivatives, those of the longest sides
/// first.
fn basis(constraint_jacobian: &IntervalMatrix, derivatives: &IntervalMatrix, w: &[Interval]) -> IntervalMatrix {
    let (normals, directions) = (constraint_jacobian.mid().transpose(), derivatives.mid());
    let length = |j: usize| directions.column(j).norm() * w[j].width();
    let mut order: Vec<usize> = (0..w.len()).collect();
    order.sort_by(|a, b| length(*b).total_cmp(&length(*a)));
    let count = normals.ncols();
    let columns = DMatrix::from_fn(directions.nrows(), count + w.len(), |i, j| {
        if j < count { normals[(i, j)] } else { directions[(i, order[j - count])] }
    });
    IntervalMatrix::of(&columns.qr().q())
}
