//! The rows of x, their derivatives and inertia.

use symbolica::atom::Atom;

use super::algebra::Algebra;
use super::loads::Effort;
use qrm_codegen::term::Row;
use qrm_scene::scene::Scene;

/// The rows of x: positions and angles of the bodies, except those without effect on the motion.
pub(super) struct Rows {
    pub(super) rows: Vec<Row>,
    pub(super) names: Vec<String>,
    pub(super) left_out: Vec<String>,
    pub(super) x: Vec<Atom>,
    pub(super) gradients: Vec<Vec<Atom>>,
    pub(super) bias: Vec<Atom>,
    pub(super) inertia: Vec<Atom>,
}

impl Rows {
    pub(super) fn new(scene: &Scene, algebra: &Algebra) -> Self {
        let empty = Vec::new;
        let mut rows = Self {
            rows: Vec::new(),
            names: Vec::new(),
            left_out: Vec::new(),
            x: empty(),
            gradients: Vec::new(),
            bias: empty(),
            inertia: empty(),
        };
        for (i, body) in scene.bodies.iter().enumerate() {
            let com = body.com.as_ref();
            let parts = [
                (com.map(|c| &c[0]), &body.mass, "x"),
                (com.map(|c| &c[1]), &body.mass, "y"),
                (body.angle.as_ref(), &body.inertia, "angle"),
            ];
            for (axis, (position, inertia, name)) in parts.into_iter().enumerate() {
                let Some(position) = position else { continue };
                let row_name = format!("{}_{name}", body.name);
                let x = algebra.simplify(&algebra.atom(position));
                // A centre of mass needs no name: inertia is expressed by the points in its formula.
                let x = match algebra.names_are_variables && axis < 2 {
                    true => algebra.in_known_sums(&x),
                    false => algebra.named_if_long(x, &row_name),
                };
                let m = inertia.as_ref().map_or_else(|| Atom::num(0), |m| algebra.atom(m));
                let row = Row { body: i, axis, inertia: algebra.simple_term(&m) };
                let gradient: Vec<Atom> = algebra.gradient(&x).iter().map(|entry| algebra.simplify(entry)).collect();
                let moves = match algebra.names_are_variables {
                    true => !algebra.local_derivatives(&x).is_empty(),
                    false => gradient.iter().any(|derivative| *derivative != Atom::num(0)),
                };
                let carries = if axis == 2 { "inertia" } else { "mass" };
                let reason =
                    if row.inertia.is_zero() { format!("carries no {carries}") } else { "is constant".to_owned() };
                if row.inertia.is_zero() || !moves {
                    rows.left_out.push(format!("{name} of body `{}`: {reason}", body.name));
                    continue;
                }
                rows.names.push(row_name);
                rows.rows.push(row);
                rows.bias.push(algebra.simplify(&algebra.bias(&x)));
                rows.x.push(x);
                rows.gradients.push(gradient);
                rows.inertia.push(m);
            }
        }
        rows
    }

    /// The mass matrix, T' M T.
    pub(super) fn mass_matrix(&self, scene: &Scene, algebra: &Algebra) -> Vec<Vec<Atom>> {
        let mass = |i: usize, j: usize| {
            let moving =
                self.gradients.iter().zip(&self.inertia).filter(|(row, _)| !row[i].is_zero() && !row[j].is_zero());
            let products = moving.map(|(row, m)| m * &row[i] * &row[j]);
            algebra.simplify(&products.fold(Atom::num(0), |sum, product| sum + product))
        };
        let n = scene.coordinates.len();
        let lower: Vec<Vec<Atom>> = (0..n).map(|i| (0..=i).map(|j| mass(i, j)).collect()).collect();
        (0..n).map(|i| (0..n).map(|j| lower[i.max(j)][i.min(j)].clone()).collect()).collect()
    }

    /// The forces of inertia at zero accelerations of the coordinates, `-M bias`.
    pub(super) fn inertial(&self) -> impl Iterator<Item = Effort> {
        let effort = |i: usize| Effort {
            group: self.rows[i].body,
            name: self.names[i].clone(),
            size: -(&self.inertia[i] * &self.bias[i]),
            normal: None,
            displacement: self.x[i].clone(),
            along: self.gradients[i].clone(),
        };
        (0..self.rows.len()).map(effort)
    }
}
