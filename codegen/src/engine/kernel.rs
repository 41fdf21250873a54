//! The equations of motion once more, in the form that a kernel evaluates: roots have names, and what acts on the bodies is kept
//! apart.

use symbolica::atom::Atom;

use super::Place;
use super::algebra::Algebra;
use super::derive::{Effort, Loads, Rows};
use crate::term::{KernelEquations, Push, Root, Term};
use qrm_scene::scene::Scene;

/// Derives the equations of a kernel, in which `outputs` are to be computed too.
pub(super) fn equations(number: usize, scene: &Scene, place: &Place, outputs: &[Term]) -> KernelEquations {
    let algebra = Algebra::naming_roots(number, scene, place);
    let rows = Rows::new(scene, &algebra);
    let simple = |atom: &Atom| algebra.simple_term(atom);
    let each = |atoms: &[Atom]| atoms.iter().map(simple).collect::<Vec<_>>();
    let closures: Vec<Atom> = scene.constraints.iter().map(|c| algebra.simplify(&algebra.atom(&c.residual))).collect();
    let constraint_jacobian = closures.iter().map(|row| each(&algebra.gradient(row))).collect();
    let constraint_rate = closures.iter().map(|row| simple(&algebra.drift(row))).collect();
    let constraint_bias = closures.iter().map(|row| simple(&algebra.bias(row))).collect();
    let mass_matrix = rows.mass_matrix(scene, &algebra).iter().map(|row| each(row)).collect();
    let pushes = pushes(scene, &algebra, &rows);
    // Last, when all roots are known.
    let radicands = algebra.radicands();
    let known: Vec<Term> = radicands.iter().map(simple).collect();
    let outputs = outputs.iter().map(|output| output.naming_roots(&known)).collect();
    let roots = radicands.iter().map(|radicand| Root {
        radicand: simple(radicand),
        slopes: each(&algebra.gradient(radicand).iter().map(|slope| slope / Atom::num(2)).collect::<Vec<_>>()),
        half_drift: simple(&(algebra.drift(radicand) / Atom::num(2))),
        half_bias: simple(&(algebra.bias(radicand) / Atom::num(2))),
    });
    KernelEquations {
        roots: roots.collect(),
        constraints: each(&closures),
        constraint_jacobian,
        constraint_rate,
        constraint_bias,
        mass_matrix,
        pushes,
        outputs,
    }
}

/// What acts on the bodies: efforts along the same displacement are added up, and those of a body stay together.
fn pushes(scene: &Scene, algebra: &Algebra, rows: &Rows) -> Vec<Push> {
    let mut efforts: Vec<Effort> = rows.inertial().collect();
    for load in Loads::new(scene, algebra, rows).efforts {
        match efforts.iter_mut().find(|effort| effort.along == load.along) {
            Some(effort) => effort.size = &effort.size + &load.size,
            None => efforts.push(load),
        }
    }
    let zero = Atom::num(0);
    efforts.retain(|effort| effort.size != zero && effort.along.iter().any(|entry| *entry != zero));
    let each = |atoms: &[Atom]| atoms.iter().map(|atom| algebra.simple_term(atom)).collect::<Vec<_>>();
    let push = |efforts: &[Effort]| {
        let name = match efforts[0].group.checked_sub(scene.bodies.len()) {
            Some(load) => scene.loads[load].name.clone(),
            None => scene.bodies[efforts[0].group].name.clone(),
        };
        let along = |i: usize| efforts.iter().fold(Atom::num(0), |sum, effort| sum + &effort.size * &effort.along[i]);
        let total = (0..scene.coordinates.len()).map(|i| algebra.simple_term(&along(i))).collect();
        let effort = |effort: &Effort| (effort.name.clone(), algebra.simple_term(&effort.size), each(&effort.along));
        Push { name, efforts: efforts.iter().map(effort).collect(), total }
    };
    efforts.chunk_by(|a, b| a.group == b.group).map(push).collect()
}
