//! `qrm list`

use crate::scenes::Scenes;

/// Prints every scene with what can be set and what it gives.
pub(super) fn list(scenes: &Scenes) {
    for (i, scene) in scenes.iter().enumerate() {
        let description = scene.description();
        if i > 0 {
            println!();
        }
        println!("{}: {}", description.name, description.doc);
        let names = |quantities: &[qrm_mechanism::QuantityDescription]| {
            quantities.iter().map(|q| q.name).collect::<Vec<_>>().join(", ")
        };
        println!("  coordinates  {}", names(description.coordinates));
        println!("  constraints  {}", names(description.constraints));
        println!("  outputs      {}", names(description.outputs));
        if !description.until.is_empty() {
            println!("  until        {}", description.until);
        }
        println!("  parameters (--set NAME=VALUE)");
        let values = scene.parameters(&|_| None);
        for (parameter, value) in description.parameters.iter().zip(values) {
            println!("    {:6} {:>20} {:8} {}", parameter.name, format!("{value}"), parameter.unit, parameter.doc);
        }
        if !description.left_out.is_empty() {
            println!("  left out     {} (zero in the scene)", description.left_out.join(", "));
        }
    }
}
