//! The quantities that the generated functions compute, as terms.

use super::named::Named;
use super::sparse::SparseEquations;
use super::{Symbol, Term};

/// The quantities that the generated functions compute, as symbolic terms; matrices are lists of rows.
#[derive(Clone, Debug, Default)]
pub struct Equations {
    /// Named quantities in the terms, each after those that it uses.
    pub names: Vec<Named>,
    /// The rows of x, each a coordinate of a body.
    pub rows: Vec<Row>,
    /// Omitted rows, with the reasons.
    pub left_out: Vec<String>,
    /// Positions of the bodies, x(q).
    pub com_positions: Vec<Term>,
    /// Jacobian of the positions, T = dx/dq; empty if there are `com_velocities`.
    pub com_jacobian: Vec<Vec<Term>>,
    /// Velocities of the bodies due to the rates of the coordinates, T qd; only for large trees.
    pub com_velocities: Vec<Term>,
    /// Bias of the positions, (T qd)_q qd.
    pub com_bias: Vec<Term>,
    /// Constraints, C(q).
    pub constraints: Vec<Term>,
    /// Jacobian of the constraints, C_q.
    pub constraint_jacobian: Vec<Vec<Term>>,
    /// Second derivatives C_qq, a symmetric matrix for each constraint; empty if quantities have names.
    pub constraint_hessians: Vec<Vec<Vec<Term>>>,
    /// Derivative of the constraints with respect to time, C_t.
    pub constraint_rate: Vec<Term>,
    /// Bias of the constraints, (C_q qd)_q qd; for constraints that depend on time, (C_q qd + C_t)_q qd + (C_q qd +
    /// C_t)_t.
    pub constraint_bias: Vec<Term>,
    /// Mass matrix, T' M T; empty if there are `momenta`.
    pub mass_matrix: Vec<Vec<Term>>,
    /// Generalized momenta, T' M T qd; only for large trees.
    pub momenta: Vec<Term>,
    /// Generalized forces, Q + T' (F - M bias).
    pub generalized_forces: Vec<Term>,
    /// Kinetic energy, and the potential of the conservative loads.
    pub energy: Vec<Term>,
    /// Power of the other loads.
    pub power: Vec<Term>,
    /// The outputs of the scene.
    pub outputs: Vec<Term>,
    /// The normal forces of friction.
    pub normal_forces: Vec<NormalForce>,
    /// The linearization with respect to the state, if the scene requests it.
    pub linearization: Option<Linearization>,
    /// Abscissa and ordinate of each named point.
    pub points: Vec<[Term; 2]>,
    /// The equations in the form for a kernel.
    pub kernel: KernelEquations,
    /// The equations for a sparse elimination; for scenes with more than twelve coordinates, and for trees with more
    /// than four.
    pub sparse: Option<SparseEquations>,
}

impl Equations {
    /// Whether products of `T` and `Mbar` with the rates stand in place of these matrices: the sparse equations give
    /// the generalized momenta and forces.
    pub fn has_momenta(&self) -> bool {
        self.sparse.is_some() && self.kernel.mass_matrix.is_empty()
    }

    /// Whether no motion changes a constraint, at any position.
    pub fn has_fixed_constraint(&self) -> bool {
        self.kernel.constraint_jacobian.iter().any(|row| row.iter().all(Term::is_zero))
    }

    /// All terms.
    pub fn terms(&self) -> impl Iterator<Item = &Term> {
        let of_loops = [&self.constraints, &self.constraint_bias, &self.constraint_rate];
        let vectors = [&self.com_positions, &self.com_bias].into_iter().chain(of_loops);
        let of_trees = [&self.com_velocities, &self.momenta];
        let more = [&self.generalized_forces, &self.energy, &self.power, &self.outputs].into_iter().chain(of_trees);
        let matrices = [&self.com_jacobian, &self.constraint_jacobian, &self.mass_matrix];
        let hessians = self.constraint_hessians.iter().flatten().flatten();
        let points = self.points.iter().flatten();
        let matrices = matrices.into_iter().flatten().flatten();
        points.chain(vectors.chain(more).flatten()).chain(matrices).chain(hessians)
    }
}

/// Derivatives of the equations of motion, with accelerations and multipliers held constant.
#[derive(Clone, Debug, Default)]
pub struct Linearization {
    /// Stiffness, -d(fbar - Mbar qdd - C_q' lambda)/dq.
    pub stiffness: Vec<Vec<Term>>,
    /// Damping, -d fbar/d qd.
    pub damping: Vec<Vec<Term>>,
    /// Stiffness of the constraints, d(C_q qdd + bias)/dq.
    pub constraint_stiffness: Vec<Vec<Term>>,
    /// Damping of the constraints, d bias/d qd.
    pub constraint_damping: Vec<Vec<Term>>,
    /// Forcing, d(fbar - C_q' lambda)/dt.
    pub forcing: Vec<Term>,
    /// Forcing of the constraints, -d(C_q qdd + bias)/dt.
    pub constraint_forcing: Vec<Term>,
}

impl Linearization {
    /// The matrices with their names.
    pub fn parts(&self) -> [(&'static str, &Vec<Vec<Term>>); 4] {
        [
            ("stiffness", &self.stiffness),
            ("damping", &self.damping),
            ("constraint_stiffness", &self.constraint_stiffness),
            ("constraint_damping", &self.constraint_damping),
        ]
    }
}

/// The equations of motion for a kernel. Varying roots have names and are differentiated by the chain rule, as on
/// paper, which keeps all terms short.
#[derive(Clone, Debug, Default)]
pub struct KernelEquations {
    /// Roots and other named quantities, each after those that it uses.
    pub names: Vec<Named>,
    /// Constraints, C(q).
    pub constraints: Vec<Term>,
    /// Jacobian of the constraints, C_q.
    pub constraint_jacobian: Vec<Vec<Term>>,
    /// Derivative of the constraints with respect to time, C_t.
    pub constraint_rate: Vec<Term>,
    /// The bias of the constraints at acceleration level: `C_q qdd + bias = 0`.
    pub constraint_bias: Vec<Term>,
    /// Mass matrix, T' M T.
    pub mass_matrix: Vec<Vec<Term>>,
    /// The parts of the generalized forces, Q + T' (F - M bias).
    pub effort_groups: Vec<EffortGroup>,
    /// The outputs of the scene.
    pub outputs: Vec<Term>,
    /// The normal forces of friction.
    pub normal_forces: Vec<NormalForce>,
}

impl KernelEquations {
    /// Creates the equations for a kernel from the terms of the plain functions.
    pub fn without_roots(equations: &Equations) -> Self {
        let is_normal = |symbol| matches!(symbol, Symbol::NormalForce(_)).then(Term::zero);
        let total = equations.generalized_forces.iter().map(|force| force.replacing(&is_normal)).collect();
        Self {
            names: equations.names.clone(),
            constraints: equations.constraints.clone(),
            constraint_jacobian: equations.constraint_jacobian.clone(),
            constraint_rate: equations.constraint_rate.clone(),
            constraint_bias: equations.constraint_bias.clone(),
            mass_matrix: equations.mass_matrix.clone(),
            outputs: equations.outputs.clone(),
            normal_forces: equations.normal_forces.clone(),
            effort_groups: vec![EffortGroup { name: String::new(), efforts: Vec::new(), total }],
        }
    }
}

/// The contribution of a body or a load to the generalized forces.
#[derive(Clone, Debug)]
pub struct EffortGroup {
    /// The name of the body or load.
    pub name: String,
    /// Forces and torques, each with the derivatives of its displacement with respect to the coordinates.
    pub efforts: Vec<(String, Term, Vec<Term>)>,
    /// The resulting generalized forces, simplified together.
    pub total: Vec<Term>,
}

/// A joint force to which friction is proportional.
#[derive(Clone, Debug)]
pub struct NormalForce {
    /// The output with this force.
    pub output: usize,
    /// The name of the normal force.
    pub name: String,
    /// The components of the normal force: a single one, or two whose norm is the force.
    pub components: Vec<AffineForce>,
    /// The generalized friction forces for a unit normal force.
    pub friction: Vec<Term>,
}

/// A force that depends linearly on accelerations, multipliers and normal forces, with constant factors.
#[derive(Clone, Debug)]
pub struct AffineForce {
    /// The part of the force without accelerations, multipliers and normal forces.
    pub rest: Term,
    /// The derivatives of the force with respect to the accelerations.
    pub by_accelerations: Vec<Term>,
    /// The derivatives of the force with respect to the multipliers.
    pub by_multipliers: Vec<Term>,
    /// The derivatives of the force with respect to the normal forces, in their order.
    pub by_normal_forces: Vec<Term>,
}

impl NormalForce {
    /// Maps all terms of the normal force.
    #[must_use]
    pub fn map(&self, f: impl Fn(&Term) -> Term) -> Self {
        let all = |terms: &[Term]| terms.iter().map(&f).collect();
        let component = |own: &AffineForce| AffineForce {
            rest: f(&own.rest),
            by_accelerations: all(&own.by_accelerations),
            by_multipliers: all(&own.by_multipliers),
            by_normal_forces: all(&own.by_normal_forces),
        };
        Self {
            output: self.output,
            name: self.name.clone(),
            components: self.components.iter().map(component).collect(),
            friction: all(&self.friction),
        }
    }
}

/// A row of x: one coordinate of one body.
#[derive(Clone, Debug)]
pub struct Row {
    /// The body.
    pub body: usize,
    /// Abscissa (0) or ordinate (1) of the centre of mass, or the angle (2).
    pub axis: usize,
    /// The mass of the body, or its moment of inertia.
    pub inertia: Term,
}
