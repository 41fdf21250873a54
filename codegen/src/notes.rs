//! The cost of each function, and the list of omissions.

use qrm_core::NamedTape;
use qrm_scene::scene::{EliminationForm, Scene};

use crate::omissions;
use crate::term::Equations;

/// Functions that are not listed: they are called once, or compare numbers.
const OF_LITTLE_COST: [&str; 8] =
    ["parameters", "constants", "growth_factor", "start", "schedule", "event", "switching_functions", "tanh_arguments"];

/// The operations of each function, those of the accelerations by other methods, and the omissions; line by line.
pub(crate) fn notes(
    scene: &Scene,
    equations: &Equations,
    tape: &NamedTape,
    (form, forms): (EliminationForm, &[(EliminationForm, usize)]),
) -> Vec<String> {
    let mut lines = vec!["Operations:".to_owned()];
    let functions = || tape.functions.iter().filter(|function| !OF_LITTLE_COST.contains(&&*function.name));
    let width = functions().map(|function| function.name.len()).max().unwrap_or(0);
    lines.extend(functions().map(|function| format!("    {:width$}  {}", function.name, tape.operations(function))));
    lines.extend([String::new(), "Accelerations and multipliers, from sines and cosines on:".to_owned()]);
    let evaluated = |names: &[&str]| {
        let named = tape.functions.iter().filter(|function| names.contains(&&*function.name));
        named.map(|function| tape.operations(function).sum()).sum::<usize>()
    };
    if !equations.has_momenta() {
        let parts = ["com_jacobian", "com_bias", "constraint_jacobian", "constraint_bias"];
        let dense = evaluated(&parts) + omissions::dense(scene, equations);
        let solved = evaluated(&["dynamics"]) + omissions::system(scene);
        lines.extend([
            format!("    {dense:5} operations  with full matrices, as the method is written down"),
            format!("    {solved:5} operations  by the function `dynamics` and one full system"),
        ]);
    }
    lines.push(format!("    {:5} operations  by the kernel: {}", tape.solution.sum(), tape.solution));
    // Scenes with few coordinates have one form, which needs no list.
    if forms.len() > 1 || scene.run.elimination.is_some() || equations.has_momenta() {
        lines.extend([String::new(), "Forms of the kernel, before pairs are shared:".to_owned()]);
        lines.extend(forms.iter().map(|(counted, count)| {
            let taken = if *counted == form { ": taken" } else { "" };
            format!("    {count:5} operations  {:11}  by {}{taken}", counted.name(), counted.description())
        }));
    }
    lines.extend([String::new(), "Left out:".to_owned()]);
    lines.extend(omissions::omissions(scene, equations, form).iter().map(|line| format!("    {line}")));
    lines
}
