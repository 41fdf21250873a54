//! The parts of the equations of motion.

use num_rational::BigRational;
use symbolica::atom::Atom;

use super::algebra::Algebra;
use super::loads::Loads;
use super::rows::Rows;
use qrm_codegen::term::{Symbol, Term};

/// The parts of the equations of motion.
pub(super) struct System<'s> {
    pub(super) algebra: Algebra<'s>,
    pub(super) rows: Rows,
    pub(super) loads: Loads,
    /// Mass matrix, T' M T; empty where names are variables.
    pub(super) mass: Vec<Vec<Atom>>,
    /// Constraints, C.
    pub(super) constraints: Vec<Atom>,
    /// Jacobian of the constraints, C_q.
    pub(super) constraint_jacobian: Vec<Vec<Atom>>,
    /// The bias of the constraints, `-C_q qdd`.
    pub(super) constraint_bias: Vec<Atom>,
    /// Derivatives of the constraints with respect to time, C_t.
    pub(super) constraint_rates: Vec<Atom>,
}

impl<'s> System<'s> {
    pub(super) fn new(algebra: Algebra<'s>) -> Self {
        let scene = algebra.scene;
        let rows = Rows::new(scene, &algebra);
        let simple = |atom: &Atom| algebra.simplify(atom);
        let constraints: Vec<Atom> = scene.constraints.iter().map(|c| simple(&algebra.atom(&c.residual))).collect();
        let gradient = |row: &Atom| algebra.gradient(row).iter().map(simple).collect();
        Self {
            constraint_jacobian: constraints.iter().map(gradient).collect(),
            constraint_rates: constraints.iter().map(|row| algebra.partial_time_derivative(row)).collect(),
            constraint_bias: constraints.iter().map(|row| simple(&algebra.bias(row))).collect(),
            mass: if algebra.names_are_variables { Vec::new() } else { rows.mass_matrix(scene, &algebra) },
            loads: Loads::new(scene, &algebra, &rows),
            constraints,
            rows,
            algebra,
        }
    }

    /// The kinetic energy: half of each inertia times the square of a rate if rates have names, otherwise half of
    /// `qd' Mbar qd`.
    pub(super) fn kinetic_energy(&self) -> Atom {
        let (algebra, rows) = (&self.algebra, &self.rows);
        let sum = |terms: &mut dyn Iterator<Item = Atom>| terms.fold(Atom::num(0), |sum, term| sum + term);
        let twice = if algebra.names_formulae {
            let rates = rows.x.iter().map(|x| algebra.rate(x));
            sum(&mut rates.zip(&rows.inertia).map(|(rate, m)| m * &rate * &rate))
        } else {
            let momenta: Vec<Atom> = self.mass.iter().map(|row| algebra.contract(row, Symbol::Rate)).collect();
            algebra.contract(&momenta, Symbol::Rate)
        };
        twice / Atom::num(2)
    }
}

/// The square root of the sum of the squares.
pub(super) fn norm(parts: [&Term; 2]) -> Term {
    let [one, two] = [1, 2].map(|n: i32| BigRational::from_integer(n.into()));
    let squares = parts.map(|part| Term::Power(Box::new(part.clone()), two.clone()));
    Term::Power(Box::new(Term::Sum(squares.to_vec())), one / two)
}
