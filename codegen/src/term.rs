//! Symbolic results as plain data, free of the engine's types.

mod named;

use std::sync::Arc;

use num_rational::BigRational;
use num_traits::Zero as _;

pub use named::{Formula, Named, NamedKind, Root};
use qrm_scene::expression::to_f64;
use qrm_scene::function::Function;
use qrm_scene::spline::Spline;

/// A symbolic expression in normal form: flat sums and products, rational powers, functions of one argument.
#[derive(Clone, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Term {
    /// An exact number.
    Number(BigRational),
    /// A symbol.
    Symbol(Symbol),
    /// A sum.
    Sum(Vec<Term>),
    /// A product.
    Product(Vec<Term>),
    /// A power with a fixed rational exponent.
    Power(Box<Term>, BigRational),
    /// A function of one argument.
    Call(Function, Box<Term>),
    /// The derivative of a spline, of an order; the spline itself where that is zero.
    Spline(Arc<Spline>, usize, Box<Term>),
}

/// A symbol in a [`Term`]; numbers are places in the scene's lists.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Symbol {
    /// A parameter.
    Parameter(usize),
    /// The number pi.
    Pi,
    /// Time.
    Time,
    /// The size of a virtual displacement; it vanishes during the derivation.
    Displacement,
    /// A generalized coordinate.
    Coordinate(usize),
    /// The rate of a generalized coordinate.
    Rate(usize),
    /// The acceleration of a generalized coordinate.
    Acceleration(usize),
    /// A Lagrange multiplier.
    Multiplier(usize),
    /// The size of an output that is the normal force of friction.
    NormalForce(usize),
    /// A named quantity.
    Named(usize),
    /// The derivative of a named quantity by a coordinate.
    NamedSlope(usize, usize),
    /// The rate of a named quantity.
    NamedRate(usize),
    /// The second rate of a named quantity without its slopes times the accelerations.
    NamedBias(usize),
    /// How far a constraint is from closed, for a correction.
    Residual(usize),
    /// A function that changes in jumps alone: a constant to the engine.
    Switch(usize),
    /// A value that has a statement of its own, in the order of the statements.
    Local(usize),
}

impl Symbol {
    /// Whether it keeps its value during a run.
    pub fn is_constant(self) -> bool {
        matches!(self, Self::Parameter(_) | Self::Pi)
    }
}

impl Term {
    /// The number zero.
    pub fn zero() -> Self {
        Self::Number(BigRational::from_integer(0.into()))
    }

    /// Whether it is the number zero.
    pub fn is_zero(&self) -> bool {
        matches!(self, Self::Number(number) if number.is_zero())
    }

    /// A copy of the term with other terms for some of its symbols.
    #[must_use]
    pub fn replacing(&self, other: &impl Fn(Symbol) -> Option<Term>) -> Self {
        let inner = |term: &Term| term.replacing(other);
        match self {
            Self::Number(_) => self.clone(),
            Self::Symbol(symbol) => other(*symbol).unwrap_or_else(|| self.clone()),
            Self::Sum(terms) => Self::Sum(terms.iter().map(inner).collect()),
            Self::Product(factors) => Self::Product(factors.iter().map(inner).collect()),
            Self::Power(base, exponent) => Self::Power(Box::new(inner(base)), exponent.clone()),
            Self::Call(function, argument) => Self::Call(*function, Box::new(inner(argument))),
            Self::Spline(spline, order, argument) => Self::Spline(spline.clone(), *order, Box::new(inner(argument))),
        }
    }

    /// A copy of the term with symbols for the roots among these quantities.
    #[must_use]
    pub fn naming_roots(&self, names: &[Named]) -> Self {
        let inner = |term: &Term| term.naming_roots(names);
        let is_root = |named: &Named, base: &Term| matches!(&named.kind, NamedKind::Root(r) if r.radicand == *base);
        match self {
            Self::Number(_) | Self::Symbol(_) => self.clone(),
            Self::Sum(terms) => Self::Sum(terms.iter().map(inner).collect()),
            Self::Product(factors) => Self::Product(factors.iter().map(inner).collect()),
            Self::Call(function, argument) => Self::Call(*function, Box::new(inner(argument))),
            Self::Spline(spline, order, argument) => Self::Spline(spline.clone(), *order, Box::new(inner(argument))),
            Self::Power(base, exponent) => {
                let doubled = exponent * BigRational::from_integer(2.into());
                match names.iter().position(|named| is_root(named, base)) {
                    Some(k) if doubled.is_integer() => Self::Power(Box::new(Self::Symbol(Symbol::Named(k))), doubled),
                    _ => Self::Power(Box::new(inner(base)), exponent.clone()),
                }
            }
        }
    }

    /// The value of the term when each symbol has the value that `lookup` gives it.
    pub fn evaluate(&self, lookup: &impl Fn(Symbol) -> f64) -> f64 {
        match self {
            Self::Number(number) => to_f64(number),
            Self::Symbol(symbol) => lookup(*symbol),
            Self::Sum(terms) => terms.iter().map(|term| term.evaluate(lookup)).sum(),
            Self::Product(factors) => factors.iter().map(|factor| factor.evaluate(lookup)).product(),
            Self::Power(base, exponent) => base.evaluate(lookup).powf(to_f64(exponent)),
            Self::Call(function, argument) => function.evaluate(&[argument.evaluate(lookup); 2]),
            Self::Spline(spline, order, argument) => spline.value(*order, argument.evaluate(lookup)),
        }
    }

    /// Whether a symbol for which `test` holds occurs.
    pub fn any_symbol(&self, test: &impl Fn(Symbol) -> bool) -> bool {
        match self {
            Self::Number(_) => false,
            Self::Symbol(symbol) => test(*symbol),
            Self::Sum(terms) | Self::Product(terms) => terms.iter().any(|t| t.any_symbol(test)),
            Self::Power(inner, _) | Self::Call(_, inner) | Self::Spline(_, _, inner) => inner.any_symbol(test),
        }
    }
}

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
