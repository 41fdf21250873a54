//! A scene's equations of motion by the TMT method.

use symbolica::atom::Atom;

use super::algebra::Algebra;
use super::loads::Effort;
use super::normal_forces::{Sizes, normal_forces};
use super::system::{System, norm};
use super::virtual_work::{self, VirtualDisplacement};
use super::{Place, kernel, linearization, sparse};
use qrm_codegen::term::{Equations, Symbol, Term};
use qrm_scene::scene::{OutputKind, Scene};

/// Derives all terms of the generated functions. `number` distinguishes the scenes of a process.
pub(super) fn equations(number: usize, scene: &Scene, place: &Place) -> Equations {
    if let Some(equations) = sparse::all_equations(number, place, scene) {
        return equations;
    }
    let system = System::new(Algebra::new(number, scene, place));
    let (algebra, rows, c) = (&system.algebra, &system.rows, &system.constraints);
    let terms = |atoms: &[Atom]| -> Vec<Term> { atoms.iter().map(|atom| algebra.term(atom)).collect() };
    let matrix = |rows: &[Vec<Atom>]| rows.iter().map(|row| terms(row)).collect();
    let mut equations = Equations {
        com_positions: rows.x.iter().map(|x| algebra.term(&algebra.definition(x))).collect(),
        com_jacobian: rows
            .x
            .iter()
            .zip(&rows.gradients)
            .map(|(x, row)| algebra.slopes(x).map_or_else(|| terms(row), |row| terms(&row)))
            .collect(),
        com_bias: terms(&rows.bias),
        constraints: terms(c),
        constraint_jacobian: matrix(&system.constraint_jacobian),
        constraint_rate: system.constraint_rates.iter().map(|rate| algebra.simple_term(rate)).collect(),
        constraint_bias: terms(&system.constraint_bias),
        mass_matrix: matrix(&system.mass),
        ..Equations::default()
    };
    // Second derivatives serve only the derivation, and would be unreadable if formulae expand too much.
    if !algebra.names_formulae {
        let gradient =
            |entry: &Atom| algebra.gradient(entry).iter().map(|second| algebra.simple_term(second)).collect();
        let hessian = |row: &Vec<Atom>| row.iter().map(gradient).collect();
        equations.constraint_hessians = system.constraint_jacobian.iter().map(hessian).collect();
    }
    let loads = &system.loads;
    let efforts: Vec<Effort> = rows.inertial().chain(loads.efforts.iter().cloned()).collect();
    let force = |i: usize| {
        let moving = efforts.iter().filter(|effort| !effort.along[i].is_zero());
        algebra.simplify(&moving.fold(Atom::num(0), |sum, effort| sum + &effort.size * &effort.along[i]))
    };
    let forces: Vec<Atom> = (0..scene.coordinates.len()).map(force).collect();
    equations.generalized_forces = terms(&forces);
    if scene.run.stiff {
        equations.linearization =
            Some(linearization::derive(algebra, &system.mass, &forces, c, &system.constraint_jacobian));
    }
    let kinetic = system.kinetic_energy();
    equations.energy = [&kinetic, &loads.potential].into_iter().map(|atom| algebra.simple_term(atom)).collect();
    // A constraint that depends on time does work: -lambda' C_q qd = lambda' C_t.
    let driving = algebra.contract(&system.constraint_rates, Symbol::Multiplier);
    let power = algebra.simple_term(&(&loads.power + driving));
    let (outputs, sizes) = outputs_and_sizes(&system);
    equations.power = vec![sizes.insert(&power)];
    equations.outputs = terms_of_outputs(&system, &outputs, &sizes);
    equations.normal_forces = normal_forces(&system, &outputs);
    equations.points = points(algebra);
    (equations.rows, equations.left_out) = (rows.rows.clone(), rows.left_out.clone());
    equations.names = algebra.named();
    equations.kernel = kernel::equations(number, place, &system, &equations);
    equations.sparse = sparse::equations(number, place, scene);
    equations
}

/// The outputs as terms.
fn terms_of_outputs(system: &System, outputs: &[Atom], sizes: &Sizes) -> Vec<Term> {
    let algebra = &system.algebra;
    let mut terms: Vec<Term> = Vec::new();
    for (own, output) in algebra.scene.outputs.iter().zip(outputs) {
        // The engine would expand the sum of the squares.
        let term = match (&own.kind, &own.scale) {
            (OutputKind::Norm { components, .. }, _) => norm(components.map(|i| &terms[i])),
            (_, Some(scale)) => sizes.insert(&algebra.simple_term(&(algebra.atom(scale) * output))),
            _ => sizes.insert(&algebra.term(output)),
        };
        terms.push(term);
    }
    terms
}

/// The outputs as expressions, and the sizes of normal forces in them.
fn outputs_and_sizes(system: &System) -> (Vec<Atom>, Sizes) {
    let (algebra, scene) = (&system.algebra, system.algebra.scene);
    let outputs: Vec<Atom> =
        scene.outputs.iter().map(|own| algebra.simplify(&output(scene, system, &own.kind))).collect();
    let terms: Vec<Term> = outputs.iter().map(|output| algebra.term(output)).collect();
    let sizes = Sizes::new(scene, &terms);
    (outputs, sizes)
}

/// The outputs of a scene.
pub(super) fn outputs(system: &System) -> Vec<Term> {
    let (outputs, sizes) = outputs_and_sizes(system);
    terms_of_outputs(system, &outputs, &sizes)
}

/// Abscissa and ordinate of each named point.
pub(super) fn points(algebra: &Algebra) -> Vec<[Term; 2]> {
    let coordinate = |i: usize, axis: usize| algebra.simple_term(&algebra.definition(&algebra.point(i)[axis]));
    (0..algebra.scene.points.len()).map(|i| [0, 1].map(|axis| coordinate(i, axis))).collect()
}

/// An output; zero for a norm, which is not a single expression.
fn output(scene: &Scene, system: &System, kind: &OutputKind) -> Atom {
    let algebra = &system.algebra;
    match kind {
        OutputKind::LoadPower(load) => system.loads.power_of(algebra, *load),
        OutputKind::DrivePower(k) => &system.constraint_rates[*k] * algebra.symbol(Symbol::Multiplier(*k)),
        OutputKind::Value(value) => algebra.atom(value),
        OutputKind::Rate(value) => algebra.rate(&algebra.simplify(&algebra.atom(value))),
        OutputKind::SecondRate(value) => algebra.second_rate(&algebra.simplify(&algebra.atom(value))),
        OutputKind::ReactionForce { constraint, point, along } => {
            let along = [algebra.atom(&along[0]), algebra.atom(&along[1])];
            let shifted = |p: usize, axis: usize| {
                let position = algebra.point(p)[axis].clone();
                if p == *point { position + algebra.displacement() * &along[axis] } else { position }
            };
            reaction(
                algebra,
                *constraint,
                &algebra.atom_where(&scene.constraints[*constraint].residual, shifted, |i| {
                    algebra.symbol(Symbol::Coordinate(i))
                }),
            )
        }
        OutputKind::FreeBody { displacements, multipliers, loads } => {
            let multipliers =
                multipliers.iter().map(|(k, factor)| algebra.atom(factor) * algebra.symbol(Symbol::Multiplier(*k)));
            let loads = loads.iter().map(|(load, factor)| algebra.atom(factor) * system.loads.force_of(*load));
            multipliers.chain(loads).fold(virtual_work::free_body(system, displacements), |sum, term| sum + term)
        }
        OutputKind::ShakingForce(along) => virtual_work::on_ground(system, &VirtualDisplacement::along(system, along)),
        OutputKind::ShakingMoment(point) => {
            virtual_work::on_ground(system, &VirtualDisplacement::about(system, *point))
        }
        OutputKind::Norm { .. } => Atom::num(0),
        OutputKind::ReactionMoment { constraint, coordinate } => {
            let turned = |i: usize| {
                let angle = algebra.symbol(Symbol::Coordinate(i));
                if i == *coordinate { angle + algebra.displacement() } else { angle }
            };
            reaction(
                algebra,
                *constraint,
                &algebra.atom_where(
                    &scene.constraints[*constraint].residual,
                    |p, axis| algebra.point(p)[axis].clone(),
                    turned,
                ),
            )
        }
    }
}

/// The force of a constraint along a virtual displacement of its point or body: -lambda dC/ds.
fn reaction(algebra: &Algebra, constraint: usize, displaced: &Atom) -> Atom {
    -algebra.derivative_by_displacement(displaced) * algebra.symbol(Symbol::Multiplier(constraint))
}
