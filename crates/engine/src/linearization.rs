//! The derivatives of the equations of motion with respect to the state.

use symbolica::atom::Atom;

use super::algebra::Algebra;
use qrm_codegen::term::{Linearization, Symbol, Term};

/// Differentiates the equations for accelerations and multipliers, `fbar - Mbar qdd - C_q' lambda = 0` and
/// `C_q qdd + (C_q qd)_q qd = 0`, with both of them held constant.
pub(super) fn derive(
    algebra: &Algebra,
    mass: &[Vec<Atom>],
    forces: &[Atom],
    constraints: &[Atom],
    constraint_jacobian: &[Vec<Atom>],
) -> Linearization {
    let n = forces.len();
    let by_coordinates = |atom: &Atom| algebra.gradient(atom);
    let by_rates = |atom: &Atom| (0..n).map(|j| algebra.derivative(atom, Symbol::Rate(j))).collect();
    let rows = |atoms: &[Atom], gradient: &dyn Fn(&Atom) -> Vec<Atom>| -> Vec<Vec<Term>> {
        atoms.iter().map(|atom| gradient(atom).iter().map(|entry| algebra.simple_term(entry)).collect()).collect()
    };
    let pull = |i: usize| {
        let column: Vec<Atom> = constraint_jacobian.iter().map(|row| row[i].clone()).collect();
        algebra.contract(&column, Symbol::Multiplier)
    };
    let excess = |i: usize| algebra.contract(&mass[i], Symbol::Acceleration) + pull(i) - &forces[i];
    let excesses: Vec<Atom> = (0..n).map(excess).collect();
    let resistances: Vec<Atom> = forces.iter().map(|force| -force).collect();
    let biases: Vec<Atom> = constraints.iter().map(|c| algebra.simplify(&algebra.bias(c))).collect();
    let loops: Vec<Atom> = constraint_jacobian
        .iter()
        .zip(&biases)
        .map(|(row, bias)| algebra.contract(row, Symbol::Acceleration) + bias)
        .collect();
    let by_time = |atom: &Atom| algebra.simple_term(&-algebra.derivative(atom, Symbol::Time));
    Linearization {
        stiffness: rows(&excesses, &by_coordinates),
        damping: rows(&resistances, &by_rates),
        constraint_stiffness: rows(&loops, &by_coordinates),
        constraint_damping: rows(&biases, &by_rates),
        forcing: excesses.iter().map(by_time).collect(),
        constraint_forcing: loops.iter().map(by_time).collect(),
    }
}
