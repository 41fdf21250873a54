//! The parts that generated code omits, with the reasons.

use crate::term::{Equations, Symbol, Term};
use qrm_scene::scene::{EliminationForm, Scene};

/// The omitted parts, each with its reason.
pub fn omissions(scene: &Scene, equations: &Equations, form: EliminationForm) -> Vec<String> {
    let mut list: Vec<String> =
        scene.left_out().map(|p| format!("{} and all it multiplies: exactly zero in the scene", p.name)).collect();
    list.extend(equations.left_out.iter().cloned());
    list.extend(zeros(equations));
    list.extend(convective(scene, equations));
    list.extend(constraints(scene, equations, form));
    list.extend(outputs(scene));
    let is_timed = |terms: &[Term]| terms.iter().any(|term| term.any_symbol(&|symbol| symbol == Symbol::Time));
    let is_timed = match equations.has_momenta() {
        true => scene.depends_on_time(scene.loads.iter().flat_map(|load| load.kind.formulae())),
        false => is_timed(&equations.generalized_forces),
    };
    if !is_timed {
        list.push("time in the forces: no load depends on it".to_owned());
    }
    if equations.has_momenta() {
        list.push("Jacobians of forces: implicit methods take them from dual numbers".to_owned());
    } else if equations.linearization.is_none() {
        list.push(
            "Jacobians of forces and constraint forces: the scene asks for no implicit method (`stiff`)".to_owned(),
        );
    }
    list
}

/// Structural zeros of matrices.
fn zeros(equations: &Equations) -> Option<String> {
    let matrices =
        [("T", &equations.com_jacobian), ("Mbar", &equations.mass_matrix), ("C_q", &equations.constraint_jacobian)];
    let said = matrices.into_iter().filter_map(|(name, rows)| {
        let all = rows.iter().map(Vec::len).sum::<usize>();
        let zero = rows.iter().flatten().filter(|entry| entry.is_zero()).count();
        (zero > 0).then(|| format!("{zero} of the {all} entries of {name}"))
    });
    let said: Vec<String> = said.collect();
    (!said.is_empty()).then(|| format!("{}: zero by structure", said.join(", ")))
}

fn convective(scene: &Scene, equations: &Equations) -> Option<String> {
    let vanishing = equations.rows.iter().zip(&equations.com_bias).filter(|(_, bias)| bias.is_zero());
    let names: Vec<String> = vanishing
        .map(|(row, _)| format!("{}.{}", scene.bodies[row.body].name, ["x", "y", "angle"][row.axis]))
        .collect();
    (!names.is_empty()).then(|| format!("convective terms of {}: they vanish", names.join(", ")))
}

fn constraints(scene: &Scene, equations: &Equations, form: EliminationForm) -> Vec<String> {
    if scene.constraints.is_empty() {
        return vec!["constraints, multipliers and projection: the scene has no loop to close".to_owned()];
    }
    let is_timed = equations.constraints.iter().any(|c| c.any_symbol(&|symbol| symbol == Symbol::Time));
    let mut list = match form {
        EliminationForm::NullSpace => vec![
            "pivoting and fill-in: dependent coordinates are eliminated in an order that is known".to_owned(),
            "multipliers at the stages of a step: rows alone need them".to_owned(),
        ],
        EliminationForm::RangeSpace | EliminationForm::Sparse => {
            vec!["pivoting and fill-in: unknowns are eliminated in an order that is known".to_owned()]
        }
    };
    if !is_timed {
        list.push("derivatives of the constraints by time: none depends on it".to_owned());
    }
    list
}

fn outputs(scene: &Scene) -> Option<String> {
    if scene.outputs.is_empty() {
        return Some("outputs: none is asked for".to_owned());
    }
    let is_asked = |place: usize| scene.outputs.iter().any(|output| output.kind.reaction_of() == Some(place));
    let silent: Vec<&str> =
        scene.constraints.iter().enumerate().filter(|(i, _)| !is_asked(*i)).map(|(_, c)| c.name.as_str()).collect();
    (!silent.is_empty()).then(|| format!("reaction forces of {}: not asked for", silent.join(", ")))
}

/// The number of operations of the equations of motion with dense matrices: `T' M T` and `T' (F - M bias)` by loops,
/// and one system for accelerations and multipliers by elimination.
pub fn dense(scene: &Scene, equations: &Equations) -> usize {
    let (rows, n) = (equations.rows.len(), scene.coordinates.len());
    let reduced = rows * n + n * n * (2 * rows).saturating_sub(1) + 2 * rows + n * (2 * rows).saturating_sub(1);
    reduced + system(scene)
}

/// The number of operations for a dense solution of accelerations and multipliers.
pub fn system(scene: &Scene) -> usize {
    let k = scene.coordinates.len() + scene.constraints.len();
    // Quotients and products of the elimination, then both triangular solves.
    (0..k).map(|i| (k - 1 - i) + 2 * (k - 1 - i) * (k - 1 - i)).sum::<usize>() + 2 * k * k - k
}
