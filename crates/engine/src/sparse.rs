//! The equations of motion for a sparse elimination: named quantities are variables, each differentiated with respect
//! to those in its own formula.

use symbolica::atom::Atom;

use super::algebra::Algebra;
use super::differentiate::root_letter;
use super::loads::Effort;
use super::system::System;
use super::{Place, derive};
use qrm_codegen::kernel::Kernel;
use qrm_codegen::lower::Lowering;
use qrm_codegen::term::{
    BodyInertia, EffortsAlongVariables, Equations, FunctionOfVariables, Named, NamedKind, NamedVariable,
    SparseEquations, Symbol, Term,
};
use qrm_scene::scene::{EliminationForm, MANY_COORDINATES, Scene};

/// The number of coordinates above which a sparse elimination may be cheaper in a scene without constraints.
const MANY_OF_TREE: usize = 4;

/// Whether a scene may have a sparse elimination.
pub(super) fn is_sparse(scene: &Scene) -> bool {
    // Normal forces are derived with respect to the accelerations of the coordinates.
    let is_possible = !scene.coordinates.is_empty() && scene.normal_forces().is_empty();
    let most = if scene.constraints.is_empty() { MANY_OF_TREE } else { MANY_COORDINATES };
    is_possible && scene.run.elimination.map_or(scene.coordinates.len() > most, |form| form == EliminationForm::Sparse)
}

/// Derives the sparse equations; `None` for scenes with few coordinates, or with friction by normal forces.
pub(super) fn equations(number: usize, place: &Place, scene: &Scene) -> Option<SparseEquations> {
    is_sparse(scene).then(|| sparse_equations(&System::new(Algebra::with_names_as_variables(number, scene, place))))
}

/// Derives all equations from the sparse ones; `None` unless the scene is a large tree and all its coordinates have
/// inertia.
pub(super) fn all_equations(number: usize, place: &Place, scene: &Scene) -> Option<Equations> {
    if !scene.is_large_tree() {
        return None;
    }
    let system = System::new(Algebra::with_names_as_variables(number, scene, place));
    let sparse = sparse_equations(&system);
    let (algebra, rows) = (&system.algebra, &system.rows);
    let terms = |atoms: &[Atom]| -> Vec<Term> { atoms.iter().map(|atom| algebra.term(atom)).collect() };
    let n = scene.coordinates.len();
    let equations = Equations {
        rows: rows.rows.clone(),
        left_out: rows.left_out.clone(),
        com_positions: terms(&rows.x),
        com_velocities: rows.x.iter().map(|x| algebra.simple_term(&algebra.velocity(x))).collect(),
        com_bias: terms(&rows.bias),
        momenta: (0..n).map(|i| Term::Symbol(Symbol::Momentum(i))).collect(),
        generalized_forces: (0..n).map(|i| Term::Symbol(Symbol::GeneralizedForce(i))).collect(),
        energy: [&system.kinetic_energy(), &system.loads.potential].map(|atom| algebra.simple_term(atom)).to_vec(),
        power: vec![algebra.simple_term(&system.loads.power)],
        outputs: sparse.outputs.clone(),
        points: derive::points(algebra),
        names: sparse
            .names
            .iter()
            .map(|own| Named { name: own.name.clone(), kind: NamedKind::Variable(own.clone()) })
            .collect(),
        sparse: Some(sparse),
        ..Equations::default()
    };
    Kernel::new(scene, &equations, &mut Lowering::default(), EliminationForm::Sparse).is_some().then_some(equations)
}

fn sparse_equations(system: &System) -> SparseEquations {
    let (algebra, scene) = (&system.algebra, system.algebra.scene);
    let constraints =
        system.constraints.iter().map(|constraint| function(algebra, constraint, &Atom::num(1))).collect();
    let inertias = (0..scene.bodies.len()).map(|body| inertia(system, body)).collect();
    let (efforts, outputs) = (efforts(system), derive::outputs(system));
    // At the end, when all named quantities are known.
    SparseEquations { names: names(algebra), constraints, inertias, efforts, outputs }
}

/// A function with its local derivatives; all but the value are divided by a number.
fn function(algebra: &Algebra, atom: &Atom, over: &Atom) -> FunctionOfVariables {
    let part = |atom: &Atom| algebra.simple_term(&(atom / over));
    let by = algebra.local_derivatives(atom);
    FunctionOfVariables {
        value: algebra.term(atom),
        by: by.iter().map(|(symbol, derivative)| (*symbol, part(derivative))).collect(),
        by_time: part(&algebra.derivative(atom, Symbol::Time)),
        bias: part(&algebra.local_bias(atom)),
    }
}

/// The named quantities.
fn names(algebra: &Algebra) -> Vec<NamedVariable> {
    let names = algebra.names.borrow();
    let letter = root_letter(algebra.scene);
    let mut roots = 0;
    let mut variables: Vec<NamedVariable> = Vec::new();
    for entry in names.iter() {
        roots += usize::from(entry.is_root);
        let function = function(algebra, &entry.formula, &Atom::num(if entry.is_root { 2 } else { 1 }));
        variables.push(NamedVariable {
            name: if entry.is_root { format!("{letter}{roots}") } else { entry.name.clone() },
            is_root: entry.is_root,
            function,
        });
    }
    variables
}

/// The inertia of a body for the rates of the variables on which it depends.
fn inertia(system: &System, body: usize) -> BodyInertia {
    let (algebra, rows) = (&system.algebra, &system.rows);
    let own = (0..rows.rows.len()).filter(|&row| rows.rows[row].body == body);
    let own: Vec<(&Atom, Vec<(Symbol, Atom)>)> =
        own.map(|row| (&rows.inertia[row], algebra.local_derivatives(&rows.x[row]))).collect();
    let variables = variables(own.iter().map(|(_, by)| by));
    let entry = |i: usize, j: usize| {
        let sum = own.iter().fold(Atom::num(0), |sum, (inertia, by)| {
            let part = |place: usize| by.iter().find(|(symbol, _)| *symbol == variables[place]).map(|(_, part)| part);
            match part(i).zip(part(j)) {
                Some((a, b)) => sum + *inertia * a * b,
                None => sum,
            }
        });
        algebra.simple_term(&sum)
    };
    let matrix = (0..variables.len()).map(|i| (0..=i).map(|j| entry(i, j)).collect()).collect();
    BodyInertia { variables, matrix }
}

/// The variables of several lists of derivatives.
fn variables<'a>(lists: impl Iterator<Item = &'a Vec<(Symbol, Atom)>>) -> Vec<Symbol> {
    let mut variables: Vec<Symbol> = lists.flatten().map(|(symbol, _)| *symbol).collect();
    variables.sort_unstable();
    variables.dedup();
    variables
}

/// The efforts on the bodies and those of the loads: those along the same displacement are summed.
fn efforts(system: &System) -> Vec<EffortsAlongVariables> {
    let algebra = &system.algebra;
    let mut efforts: Vec<Effort> = system.rows.inertial().collect();
    for load in &system.loads.efforts {
        match efforts.iter_mut().find(|effort| effort.group == load.group && effort.displacement == load.displacement) {
            Some(effort) => effort.size = &effort.size + &load.size,
            None => efforts.push(load.clone()),
        }
    }
    efforts.retain(|effort| !effort.size.is_zero());
    efforts.sort_by_key(|effort| effort.group);
    let group = |efforts: &[Effort]| {
        let along: Vec<Vec<(Symbol, Atom)>> =
            efforts.iter().map(|effort| algebra.local_derivatives(&effort.displacement)).collect();
        let variables = variables(along.iter());
        let part = |along: &[(Symbol, Atom)], variable: Symbol| {
            along.iter().find(|(symbol, _)| *symbol == variable).map_or_else(|| Atom::num(0), |(_, part)| part.clone())
        };
        let total = |&variable: &Symbol| {
            let sum = efforts
                .iter()
                .zip(&along)
                .fold(Atom::num(0), |sum, (effort, along)| sum + &effort.size * part(along, variable));
            algebra.simple_term(&sum)
        };
        let effort = |(effort, along): (&Effort, &Vec<(Symbol, Atom)>)| {
            let along: Vec<Term> =
                variables.iter().map(|&variable| algebra.simple_term(&part(along, variable))).collect();
            (effort.name.clone(), algebra.simple_term(&effort.size), along)
        };
        EffortsAlongVariables {
            efforts: efforts.iter().zip(&along).map(effort).collect(),
            total: variables.iter().map(total).collect(),
            variables,
        }
    };
    efforts.chunk_by(|a, b| a.group == b.group).map(group).collect()
}
