//! Everything that the generated functions compute, as terms.

use super::named::Named;
use super::{Symbol, Term};

/// Everything that the generated functions compute, as symbolic terms; matrices are lists of rows.
#[derive(Clone, Debug, Default)]
pub struct Equations {
    /// Quantities that stand under a name in the terms, each after those that it needs.
    pub names: Vec<Named>,
    /// The rows of x: a coordinate of a body each.
    pub rows: Vec<Row>,
    /// Rows that do not matter, and why.
    pub left_out: Vec<String>,
    /// x(q)
    pub com_positions: Vec<Term>,
    /// T = dx/dq
    pub com_jacobian: Vec<Vec<Term>>,
    /// (T qd)_q qd
    pub com_bias: Vec<Term>,
    /// C(q)
    pub constraints: Vec<Term>,
    /// C_q
    pub constraint_jacobian: Vec<Vec<Term>>,
    /// C_qq, a symmetric matrix for each constraint; none if quantities have names
    pub constraint_hessians: Vec<Vec<Vec<Term>>>,
    /// C_t
    pub constraint_rate: Vec<Term>,
    /// (C_q qd)_q qd, where closures depend on time (C_q qd + C_t)_q qd + (C_q qd + C_t)_t
    pub constraint_bias: Vec<Term>,
    /// T' M T
    pub mass_matrix: Vec<Vec<Term>>,
    /// Q + T' (F - M bias)
    pub generalized_forces: Vec<Term>,
    /// Kinetic energy and the potential of the conservative loads.
    pub energy: Vec<Term>,
    /// Power of the other loads.
    pub power: Vec<Term>,
    /// The outputs that the scene asks for.
    pub outputs: Vec<Term>,
    /// The normal forces that friction depends on.
    pub normal_forces: Vec<NormalForce>,
    /// How the equations change with the state, if the scene asks for it.
    pub linearization: Option<Linearization>,
    /// Abscissa and ordinate of each named point.
    pub points: Vec<[Term; 2]>,
    /// All that a kernel needs, in its own form.
    pub kernel: KernelEquations,
}

impl Equations {
    /// Every term.
    pub fn terms(&self) -> impl Iterator<Item = &Term> {
        let of_loops = [&self.constraints, &self.constraint_bias, &self.constraint_rate];
        let vectors = [&self.com_positions, &self.com_bias].into_iter().chain(of_loops);
        let more = [&self.generalized_forces, &self.energy, &self.power, &self.outputs];
        let matrices = [&self.com_jacobian, &self.constraint_jacobian, &self.mass_matrix];
        let hessians = self.constraint_hessians.iter().flatten().flatten();
        let points = self.points.iter().flatten();
        let matrices = matrices.into_iter().flatten().flatten();
        points.chain(vectors.chain(more).flatten()).chain(matrices).chain(hessians)
    }
}

/// Derivatives of the equations of motion, accelerations and multipliers held.
#[derive(Clone, Debug, Default)]
pub struct Linearization {
    /// -d(fbar - Mbar qdd - C_q' lambda)/dq
    pub stiffness: Vec<Vec<Term>>,
    /// -d fbar/d qd
    pub damping: Vec<Vec<Term>>,
    /// d(C_q qdd + bias)/dq
    pub constraint_stiffness: Vec<Vec<Term>>,
    /// d bias/d qd
    pub constraint_damping: Vec<Vec<Term>>,
    /// d(fbar - C_q' lambda)/dt
    pub forcing: Vec<Term>,
    /// -d(C_q qdd + bias)/dt
    pub constraint_forcing: Vec<Term>,
}

impl Linearization {
    /// The matrices under their names.
    pub fn parts(&self) -> [(&'static str, &Vec<Vec<Term>>); 4] {
        [
            ("stiffness", &self.stiffness),
            ("damping", &self.damping),
            ("constraint_stiffness", &self.constraint_stiffness),
            ("constraint_damping", &self.constraint_damping),
        ]
    }
}

/// The equations of motion for a kernel. Roots of what varies have names and are differentiated by the chain rule, as
/// one does on paper, so that everything stays short.
#[derive(Clone, Debug, Default)]
pub struct KernelEquations {
    /// Roots and other named quantities, each after those that it needs.
    pub names: Vec<Named>,
    /// C(q)
    pub constraints: Vec<Term>,
    /// C_q
    pub constraint_jacobian: Vec<Vec<Term>>,
    /// C_t
    pub constraint_rate: Vec<Term>,
    /// The bias of the constraints at acceleration level: `C_q qdd + bias = 0`.
    pub constraint_bias: Vec<Term>,
    /// T' M T
    pub mass_matrix: Vec<Vec<Term>>,
    /// The parts of Q + T' (F - M bias).
    pub pushes: Vec<Push>,
    /// The outputs that the scene asks for.
    pub outputs: Vec<Term>,
    /// The normal forces that friction depends on.
    pub normal_forces: Vec<NormalForce>,
}

impl KernelEquations {
    /// The equations for a kernel with the same terms as in the plain functions.
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
            pushes: vec![Push { name: String::new(), efforts: Vec::new(), total }],
        }
    }
}

/// A part of the generalized forces: what acts on a body, or a load.
#[derive(Clone, Debug)]
pub struct Push {
    /// The name of the body or load that acts.
    pub name: String,
    /// Forces and torques, each with the derivative by each coordinate of the displacement that it acts along.
    pub efforts: Vec<(String, Term, Vec<Term>)>,
    /// The generalized forces that these make, simplified together.
    pub total: Vec<Term>,
}

/// A force in a joint whose size friction is proportional to.
#[derive(Clone, Debug)]
pub struct NormalForce {
    /// The output that it is.
    pub output: usize,
    /// The name of the normal force.
    pub name: String,
    /// The components of the normal force: one, or two of which it is the norm.
    pub components: Vec<AffineForce>,
    /// The generalized forces of friction for a unit of it.
    pub friction: Vec<Term>,
}

/// A force that depends on accelerations, multipliers and normal forces by constant factors.
#[derive(Clone, Debug)]
pub struct AffineForce {
    /// The part of the force without accelerations, multipliers and normal forces.
    pub rest: Term,
    /// The derivatives of the force by the accelerations.
    pub by_accelerations: Vec<Term>,
    /// The derivatives of the force by the multipliers.
    pub by_multipliers: Vec<Term>,
    /// The derivatives of the force by the normal forces, in their order.
    pub by_normal_forces: Vec<Term>,
}

impl NormalForce {
    /// The normal force with other terms.
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
    /// Abscissa (0) or ordinate (1) of its centre of mass, or its angle (2).
    pub axis: usize,
    /// The mass of the body, or its moment of inertia.
    pub inertia: Term,
}
