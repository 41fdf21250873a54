//! The equations of motion in the form for a kernel: roots have names, and forces on bodies are separate.

use symbolica::atom::Atom;

use super::Place;
use super::algebra::Algebra;
use super::loads::Effort;
use super::system::System;
use qrm_codegen::term::{EffortGroup, Equations, KernelEquations};

/// The equations of a kernel that also computes the outputs of the plain functions.
///
/// They are derived again if roots have no names in the plain functions.
pub(super) fn equations(number: usize, place: &Place, plain: &System, known: &Equations) -> KernelEquations {
    if plain.algebra.has_named_roots() {
        return kernel_equations(plain, known);
    }
    let system = System::new(Algebra::naming_roots(number, plain.algebra.scene, place));
    kernel_equations(&system, known)
}

fn kernel_equations(system: &System, known: &Equations) -> KernelEquations {
    let algebra = &system.algebra;
    let each = |atoms: &[Atom]| atoms.iter().map(|atom| algebra.simple_term(atom)).collect::<Vec<_>>();
    let matrix = |rows: &[Vec<Atom>]| rows.iter().map(|row| each(row)).collect();
    let effort_groups = effort_groups(system);
    // At the end, when all named quantities are known.
    let names = algebra.named();
    KernelEquations {
        constraints: each(&system.constraints),
        constraint_jacobian: matrix(&system.constraint_jacobian),
        constraint_rate: each(&system.constraint_rates),
        constraint_bias: each(&system.constraint_bias),
        mass_matrix: matrix(&system.mass),
        effort_groups,
        outputs: known.outputs.iter().map(|output| output.naming_roots(&names)).collect(),
        normal_forces: known.normal_forces.iter().map(|own| own.map(|term| term.naming_roots(&names))).collect(),
        names,
    }
}

/// The efforts on the bodies: those along the same displacement are summed, and those of a body grouped.
fn effort_groups(system: &System) -> Vec<EffortGroup> {
    let (algebra, scene) = (&system.algebra, system.algebra.scene);
    let mut efforts: Vec<Effort> = system.rows.inertial().collect();
    for load in system.loads.efforts.iter().filter(|effort| effort.normal.is_none()).cloned() {
        match efforts.iter_mut().find(|effort| effort.along == load.along) {
            Some(effort) => effort.size = &effort.size + &load.size,
            None => efforts.push(load),
        }
    }
    efforts.retain(|effort| !effort.size.is_zero() && effort.along.iter().any(|entry| !entry.is_zero()));
    let each = |atoms: &[Atom]| atoms.iter().map(|atom| algebra.simple_term(atom)).collect::<Vec<_>>();
    let group = |efforts: &[Effort]| {
        let name = match efforts[0].group.checked_sub(scene.bodies.len()) {
            Some(load) => scene.loads[load].name.clone(),
            None => scene.bodies[efforts[0].group].name.clone(),
        };
        let along = |i: usize| efforts.iter().fold(Atom::num(0), |sum, effort| sum + &effort.size * &effort.along[i]);
        let total = (0..scene.coordinates.len()).map(|i| algebra.simple_term(&along(i))).collect();
        let effort = |effort: &Effort| (effort.name.clone(), algebra.simple_term(&effort.size), each(&effort.along));
        EffortGroup { name, efforts: efforts.iter().map(effort).collect(), total }
    };
    efforts.chunk_by(|a, b| a.group == b.group).map(group).collect()
}
